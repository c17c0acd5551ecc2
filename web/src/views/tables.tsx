/** Tables of a study: facts, errors of outputs, energy, and how it was made. */

import type { BalanceData, Fact, OutputRow } from "./data.ts";
import { percent, significant } from "./format.ts";

export function Facts({ facts }: { facts: readonly Fact[] }) {
  return (
    <div class="facts">
      {facts.map((fact) => (
        <div key={fact.name} class="fact">
          <span class="name">{fact.name.replaceAll("_", " ")}</span>
          <strong>{fact.value}</strong>
          <span class="note">{fact.note}</span>
        </div>
      ))}
    </div>
  );
}

interface OutputsProps {
  readonly outputs: readonly OutputRow[];
  readonly names?: readonly [string, string];
  /** The largest rms error that passes, as a share of the range. */
  readonly tolerance?: number;
}

export function Outputs({ outputs, names, tolerance }: OutputsProps) {
  const [one, other] = names ?? ["full", "reduced"];
  return (
    <table class="outputs">
      <thead>
        <tr>
          <th>output</th>
          <th class="number">rms / range</th>
          <th class="number">largest / range</th>
          <th class="number">at</th>
          <th class="number">end, {one}</th>
          <th class="number">end, {other}</th>
          <th class="number">end, difference</th>
          {tolerance !== undefined && <th>within {percent(tolerance, 0, 3)}</th>}
        </tr>
      </thead>
      <tbody>
        {outputs.map((row) => {
          const passes = tolerance !== undefined && row.rms !== null && row.rms <= tolerance;
          return (
            <tr key={row.path} data-output={row.path}>
              <td>{row.path}</td>
              <td class="number" data-value={row.rms}>{percent(row.rms, 3)}</td>
              <td class="number" data-value={row.maximum}>{percent(row.maximum, 3)}</td>
              <td class="number" data-value={row.at}>{row.at === null ? "–" : `${row.at.toFixed(1)} s`}</td>
              <td class="number" data-value={row.full}>{significant(row.full, row.unit)}</td>
              <td class="number" data-value={row.reduced}>{significant(row.reduced, row.unit)}</td>
              <td class="number" data-value={row.final}>{percent(row.final, 3)}</td>
              {tolerance !== undefined && <td class={passes ? "passes" : "fails"}>{passes ? "✓ passes" : "✗ fails"}</td>}
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}

interface BalancesProps {
  readonly full: BalanceData;
  readonly reduced?: BalanceData;
  readonly names?: readonly [string, string];
}

export function Balances({ full, reduced, names }: BalancesProps) {
  const [one, other] = names ?? ["full", "reduced"];
  const line = (name: string, value: (balance: BalanceData) => string) => (
    <tr key={name}>
      <td>{name}</td>
      <td class="number">{value(full)}</td>
      {reduced !== undefined && <td class="number">{value(reduced)}</td>}
    </tr>
  );
  const works = new Map<string, [number | null, number | null]>();
  full.sources.forEach(({ path, work }) => works.set(path, [work, null]));
  reduced?.sources.forEach(({ path, work }) => works.set(path, [works.get(path)?.[0] ?? null, work]));
  return (
    <table class="balances">
      <thead>
        <tr>
          <th>energy</th>
          <th class="number">{reduced === undefined ? "whole run" : one}</th>
          {reduced !== undefined && <th class="number">{other}</th>}
        </tr>
      </thead>
      <tbody>
        {line("work of sources", (balance) => significant(balance.supplied, "J"))}
        {line("stored at the end more than at the start", (balance) => significant(balance.stored, "J"))}
        {line("dissipated", (balance) => significant(balance.dissipated, "J"))}
        {line("unaccounted, as a share of the work", (balance) => balance.residual.toExponential(1))}
        {[...works].map(([path, [work, otherWork]]) => (
          <tr key={path} class="detail">
            <td>work of {path}</td>
            <td class="number">{significant(work, "J")}</td>
            {reduced !== undefined && <td class="number">{significant(otherWork, "J")}</td>}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export function Pairs({ pairs }: { pairs: readonly { readonly name: string; readonly value: string }[] }) {
  return (
    <dl>
      {pairs.map(({ name, value }) => (
        <>
          <dt key={name}>{name}</dt>
          <dd>{value}</dd>
        </>
      ))}
    </dl>
  );
}

/** The certificate as its reader gets it in a terminal. */
export function Certificate({ lines }: { lines: readonly string[] }) {
  return <pre tabIndex={0}>{lines.join("\n")}</pre>;
}

/** What a reader must know of the figures. */
export function Notes({ notes }: { notes: readonly string[] }) {
  if (notes.length === 0) return null;
  return (
    <details class="notes" open={notes.length <= 4}>
      <summary>{notes.length} {notes.length === 1 ? "thing" : "things"} not to be overlooked</summary>
      <ul>
        {notes.map((note) => (
          <li key={note}>{note}</li>
        ))}
      </ul>
    </details>
  );
}
