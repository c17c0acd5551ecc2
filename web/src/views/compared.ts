/** Which lanes a study shows: its panels, with the signals of both models. */

import type { StudyData } from "./data.ts";
import type { LaneGroup, LaneRun, LaneSignal } from "./lanes.tsx";

export const BOTH: readonly LaneRun[] = [
  { id: "full", name: "full" },
  { id: "reduced", name: "reduced" },
];

/** The panels of a study; values are in the units that are shown. */
export function panelsOf(data: StudyData): LaneGroup[] {
  const found = new Map<string, { title: string; unit: string; signals: LaneSignal[] }>();
  for (const item of data.signals.items) {
    const group = found.get(item.panel) ?? { title: item.panel, unit: item.unit, signals: [] };
    group.signals.push({ path: item.path, label: item.label, factor: 1, ...(item.reduced === null ? { runs: ["full"] } : {}) });
    found.set(item.panel, group);
  }
  return [...found.values()];
}
