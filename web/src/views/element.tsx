/** What a run tells of the chosen element: its rank, what became of it, and its history. */

import type { ReadonlySignal } from "@preact/signals";
import type { Theme } from "../graph/notation.ts";
import { percent, significant } from "./format.ts";
import { HistoryView } from "./history.tsx";
import type { Source } from "./source.ts";
import type { RankingState } from "./state.ts";

interface ElementProps {
  readonly state: RankingState;
  readonly source: Source;
  readonly run: string;
  readonly theme: ReadonlySignal<Theme>;
}

export function ElementView({ state, source, run, theme }: ElementProps) {
  const selected = state.graph.selected.value;
  const { picture } = state.data;
  const node = picture.nodes.find((found) => found.path === selected || found.row === selected);
  if (selected === null || node === undefined) {
    return <p class="hint">Click an element to see what is known of it, a frame to close it, a box to open it.</p>;
  }
  const rank = state.rows.value.findIndex((row) => row.path === node.row);
  const row = state.rows.value[rank];
  const bonds = picture.bonds.filter((bond) => bond.tail === node.path || bond.head === node.path);
  const signals = picture.signals.filter((signal) => signal.to === node.path);
  return (
    <div class="element" aria-live="polite">
      <h3>
        {node.path} <small>{node.kind}</small>
      </h3>
      {row !== undefined && (
        <p>
          Rank {rank + 1} of {state.rows.value.length}: {significant(row.activity, "J")}, {percent(row.index, 3)} of all activity.
        </p>
      )}
      {row !== undefined && row.reason !== "" && (
        <p>
          <b class={row.verdict}>{row.verdict}</b>
          {row.meaning === "" ? "" : `, ${row.meaning}`}: {row.reason}
        </p>
      )}
      {node.gone !== undefined && <p>In the reduced model: {node.gone.meaning}.</p>}
      <p>{bonds.map((bond) => `${bond.name} (${bond.domain}${bond.causality === "dependent" ? ", dependent" : ""})`).join(", ")}</p>
      {row !== undefined && <HistoryView state={state} source={source} run={run} row={row.path} theme={theme} />}
      {signals.length > 0 && <p>Has information from {signals.map((signal) => signal.from).join(", ")}.</p>}
    </div>
  );
}
