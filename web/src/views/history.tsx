/** What an element did: effort, flow and power at its ports, and its activity, over time. */

import { exactNumbers, numbers } from "./data.ts";
import { LanePlot, type Columns, type Lane } from "./lanes.tsx";
import type { State } from "./state.ts";

export function HistoryView({ state, row }: { state: State; row: string }) {
  const histories = state.data.histories.rows[row] ?? [];
  const times = numbers(state.data.histories.times);
  const activity = exactNumbers(state.data.windows.rows[row] ?? "");
  const lanes: [Lane, ArrayLike<number>][] = histories.flatMap((history) => {
    const lane = (title: string, unit: string, values: string): [Lane, ArrayLike<number>] => [
      { title: `${title} at ${history.bond}`, unit, items: [only(history.bond, title, unit, numbers(values))] },
      times,
    ];
    return [
      lane("effort", history.units[0], history.effort),
      lane("flow", history.units[1], history.flow),
      lane("power", "W", history.power),
    ];
  });
  lanes.push([{ title: "activity", unit: "J", items: [only(row, "activity", "J", activity)] }, state.times]);
  return (
    <div class="histories">
      {lanes.map(([lane, at]) => (
        <LanePlot key={`${row} ${lane.title}`} lane={lane} times={at} state={state} />
      ))}
    </div>
  );
}

function only(path: string, label: string, unit: string, full: ArrayLike<number>): Columns {
  return { path, label, unit, panel: label, full, reduced: null };
}
