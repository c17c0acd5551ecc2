/** What an element did: effort, flow and power at its ports, and its activity, over time. */

import { useEffect, useMemo, useState } from "preact/hooks";
import type { ReadonlySignal } from "@preact/signals";
import type { Theme } from "../graph/notation.ts";
import { numbers } from "./data.ts";
import { LanesView, ownZoom, type LaneGroup } from "./lanes.tsx";
import type { Histories, Source } from "./source.ts";
import type { RankingState } from "./state.ts";

interface HistoryProps {
  readonly state: RankingState;
  readonly source: Source;
  readonly run: string;
  readonly row: string;
  readonly theme: ReadonlySignal<Theme>;
}

export function HistoryView({ state, source, run, row, theme }: HistoryProps) {
  const [histories, setHistories] = useState<Histories | null>(null);
  const [fault, setFault] = useState("");
  const zoom = useMemo(ownZoom, [row]);
  useEffect(() => {
    let isWanted = true;
    setHistories(null);
    source.histories(run, row).then(
      (found) => {
        if (!isWanted) return;
        setHistories(found);
        setFault("");
      },
      (error: unknown) => isWanted && setFault(error instanceof Error ? error.message : String(error)),
    );
    return () => {
      isWanted = false;
    };
  }, [source, run, row]);
  const shown = useMemo(() => (histories === null ? null : laid(histories, state, row)), [histories, state, row]);
  const runs = useMemo(() => [{ id: run, name: "" }], [run]);
  if (fault !== "") return <p class="fault" role="alert">{fault}</p>;
  if (shown === null) return <p class="hint">Reading what it did …</p>;
  return (
    <div class="histories">
      <LanesView
        source={shown.source}
        groups={shown.groups}
        runs={runs}
        whole={state.data.window}
        zoom={zoom}
        theme={theme}
        name={`history of ${row}`}
        height={112}
      />
    </div>
  );
}

/** The columns of an element as lanes: its ports, then its activity. */
function laid(histories: Histories, state: RankingState, row: string): { groups: LaneGroup[]; source: Source } {
  const end = state.data.window[1];
  const times = Float64Array.from([...Array.from(histories.times), end]);
  const columns = new Map<string, Float64Array>();
  const groups: LaneGroup[] = [];
  const lane = (title: string, path: string, unit: string, values: ArrayLike<number>): void => {
    columns.set(path, Float64Array.from({ length: times.length }, (_, i) => values[i] ?? NaN));
    groups.push({ title, unit, signals: [{ path, label: title, factor: 1 }] });
  };
  for (const history of histories.items) {
    const at = histories.items.length > 1 ? ` at ${history.bond}` : "";
    lane(`effort${at}`, `${history.bond}.effort`, history.units[0], numbers(history.effort));
    lane(`flow${at}`, `${history.bond}.flow`, history.units[1], numbers(history.flow));
    lane(`power${at}`, `${history.bond}.power`, "W", numbers(history.power));
  }
  const activity = state.activityOf(row);
  if (activity !== undefined) lane("activity", `${row}.activity`, "J", between(state.times, activity, times));
  return {
    groups,
    source: {
      series: () => Promise.resolve({ times, columns }),
      histories: () => Promise.resolve(histories),
    },
  };
}

/** Values between instants, along straight lines. */
export function between(at: ArrayLike<number>, values: ArrayLike<number>, wanted: ArrayLike<number>): Float64Array {
  const found = new Float64Array(wanted.length);
  let i = 0;
  for (let k = 0; k < wanted.length; k++) {
    const time = wanted[k] as number;
    while (i < at.length - 2 && (at[i + 1] as number) < time) i += 1;
    const [a, b] = [at[i] as number, at[i + 1] ?? (at[i] as number)];
    const share = b > a ? Math.min(1, Math.max(0, (time - a) / (b - a))) : 0;
    const [low, high] = [values[i] ?? NaN, values[i + 1] ?? values[i] ?? NaN];
    found[k] = low + share * (high - low);
  }
  return found;
}
