/** All equations and all parameters of a model, to be searched. */

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { csvOf, saveCsv } from "../views/saving.ts";
import type { ModelSheet, ParameterRow } from "./api.ts";
import { get } from "./client.ts";
import { When } from "./fault.tsx";
import { useResource } from "./resource.ts";

export function Equations({ sheet }: { sheet: ModelSheet }) {
  const equations = useResource(sheet.id, (model) => get<{ readonly lines: readonly string[] }>("/equations", { model }));
  return <When resource={equations} waiting="Writing the equations …">{({ lines }) => <EquationList lines={lines} />}</When>;
}

function EquationList({ lines }: { lines: readonly string[] }) {
  const text = useSignal("");
  const found = lines.filter((line) => has(line, text.value));
  return (
    <div class="list">
      <Filter text={text} label="Find in the equations" shown={found.length} all={lines.length} />
      <pre class="equations" tabIndex={0} aria-label="Equations">{found.join("\n")}</pre>
    </div>
  );
}

export function Parameters({ sheet }: { sheet: ModelSheet }) {
  const text = useSignal("");
  const place = useRef<HTMLDivElement>(null);
  const found = sheet.parameters.filter((row) => has(`${row.path} ${row.source} ${row.status}`, text.value));
  return (
    <div class="list">
      <Filter text={text} label="Find in the parameters" shown={found.length} all={sheet.parameters.length}>
        <button type="button" onClick={() => { const table = place.current?.querySelector("table"); if (table != null) saveCsv(csvOf(table), `parameters of ${sheet.name}`); }}>CSV</button>
      </Filter>
      <div class="scroll" ref={place} tabIndex={0} role="region" aria-label="Parameters">
        <ParameterTable rows={found} base="" />
      </div>
    </div>
  );
}

export function ParameterTable({ rows, base }: { rows: readonly ParameterRow[]; base: string }) {
  return (
    <table class="parameters">
      <thead>
        <tr>
          <th>parameter</th>
          <th class="number">value</th>
          <th>unit</th>
          <th>status and source</th>
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => (
          <tr key={row.path} data-parameter={row.path}>
            <td title={row.path}>{base !== "" && row.path.startsWith(`${base}.`) ? row.path.slice(base.length + 1) : row.path}</td>
            <td class="number">{row.value}</td>
            <td>{row.unit}</td>
            <td class="quiet">{[row.status, row.source].filter((text) => text !== "").join(": ")}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

const has = (line: string, text: string): boolean =>
  text.toLowerCase().split(/\s+/).every((word) => line.toLowerCase().includes(word));

interface FilterProps {
  readonly text: { value: string };
  readonly label: string;
  readonly shown: number;
  readonly all: number;
  readonly children?: preact.ComponentChildren;
}

export function Filter({ text, label, shown, all, children }: FilterProps) {
  return (
    <div class="tools filter">
      <input type="search" placeholder={label} aria-label={label} value={text.value} onInput={(event) => (text.value = event.currentTarget.value)} />
      <output class="hint">{shown === all ? `${all}` : `${shown} of ${all}`}</output>
      {children}
    </div>
  );
}
