/** Tables of a study: facts, errors of outputs, energy, and how it was made. */

import type { BalanceData, StudyData } from "./data.ts";
import { percent, significant } from "./format.ts";

export function Facts({ data }: { data: StudyData }) {
  return (
    <div class="facts">
      {data.facts.map((fact) => (
        <div key={fact.name} class="fact">
          <span class="name">{fact.name}</span>
          <strong>{fact.value}</strong>
          <span class="note">{fact.note}</span>
        </div>
      ))}
    </div>
  );
}

export function Outputs({ data }: { data: StudyData }) {
  return (
    <table>
      <thead>
        <tr>
          <th>output</th>
          <th class="number">rms / range</th>
          <th class="number">largest / range</th>
          <th class="number">at</th>
          <th class="number">end, full</th>
          <th class="number">end, reduced</th>
          <th class="number">end, difference</th>
        </tr>
      </thead>
      <tbody>
        {data.outputs.map((row) => (
          <tr key={row.path}>
            <td>{row.path}</td>
            <td class="number">{percent(row.rms, 3)}</td>
            <td class="number">{percent(row.maximum, 3)}</td>
            <td class="number">{row.at === null ? "–" : `${row.at.toFixed(1)} s`}</td>
            <td class="number">{significant(row.full, row.unit)}</td>
            <td class="number">{significant(row.reduced, row.unit)}</td>
            <td class="number">{percent(row.final, 3)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export function Balances({ data }: { data: StudyData }) {
  const { full, reduced } = data.balances;
  const line = (name: string, value: (balance: BalanceData) => string) => (
    <tr key={name}>
      <td>{name}</td>
      <td class="number">{value(full)}</td>
      <td class="number">{value(reduced)}</td>
    </tr>
  );
  const works = new Map<string, [number | null, number | null]>();
  full.sources.forEach(({ path, work }) => works.set(path, [work, null]));
  reduced.sources.forEach(({ path, work }) => works.set(path, [works.get(path)?.[0] ?? null, work]));
  return (
    <table>
      <thead>
        <tr>
          <th>energy</th>
          <th class="number">full</th>
          <th class="number">reduced</th>
        </tr>
      </thead>
      <tbody>
        {line("work of sources", (balance) => significant(balance.supplied, "J"))}
        {line("stored at the end more than at the start", (balance) => significant(balance.stored, "J"))}
        {line("dissipated", (balance) => significant(balance.dissipated, "J"))}
        {line("unaccounted, as a share of the work", (balance) => balance.residual.toExponential(1))}
        {[...works].map(([path, [one, other]]) => (
          <tr key={path} class="detail">
            <td>work of {path}</td>
            <td class="number">{significant(one, "J")}</td>
            <td class="number">{significant(other, "J")}</td>
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
