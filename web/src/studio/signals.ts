/** Signals of runs as lanes, in units for readers. */

import type { Kind, Picture } from "../graph/picture.ts";
import type { LaneGroup } from "../views/lanes.tsx";
import type { Panel, SignalEntry } from "./api.ts";

/** A lane for each signal, or one for all that share a unit. */
export function laneGroups(chosen: readonly string[], known: ReadonlyMap<string, SignalEntry>, isTogether: boolean): LaneGroup[] {
  const entries = chosen.map((path) => known.get(path)).filter((entry) => entry !== undefined);
  const shown = (entry: SignalEntry, label: string) => ({ path: entry.path, label, factor: entry.display.factor });
  if (!isTogether) {
    return entries.map((entry) => ({ title: entry.path, unit: entry.display.unit, signals: [shown(entry, lastOf(entry.path))] }));
  }
  const units = new Map<string, SignalEntry[]>();
  for (const entry of entries) units.set(entry.display.unit, [...(units.get(entry.display.unit) ?? []), entry]);
  return [...units].map(([unit, found]) => ({
    title: found.length === 1 ? (found[0]?.path ?? "") : `${found.length} signals`,
    unit,
    signals: found.map((entry) => shown(entry, entry.path)),
  }));
}

/** What tells a signal from its neighbours: the last two names of its path. */
export const lastOf = (path: string): string => path.split(".").slice(-2).join(".");

/** The lanes that the model's author usually looks at, of signals that a run has. */
export function panelGroups(panels: readonly Panel[], known: ReadonlyMap<string, SignalEntry>): LaneGroup[] {
  return panels.flatMap(({ title, signals }) => {
    const found = signals.flatMap(({ path, label }) => {
      const entry = known.get(path);
      return entry === undefined ? [] : [{ entry, label: label === "" ? lastOf(path) : label }];
    });
    // On one scale stands what has one unit.
    const unit = found[0]?.entry.display.unit;
    const alike = found.filter(({ entry }) => entry.display.unit === unit);
    if (unit === undefined) return [];
    return [{ title, unit, signals: alike.map(({ entry, label }) => ({ path: entry.path, label, factor: entry.display.factor })) }];
  });
}

const USUAL = 4;

/** Signals to begin with: outputs; where none are named, the flow of inertias and the effort of compliances. */
export function usualSignals(outputs: readonly string[], picture: Picture, known: ReadonlyMap<string, SignalEntry>): string[] {
  const named = outputs.filter((path) => known.has(path));
  if (named.length > 0) return named.slice(0, USUAL);
  const kinds = new Map(picture.nodes.map((node) => [node.path, node.kind]));
  const stored = (kind: Kind, answer: string): string[] =>
    picture.bonds.filter(({ tail, head }) => kinds.get(tail) === kind || kinds.get(head) === kind).map(({ name }) => `${name}.${answer}`);
  const found = [...stored("I", "flow"), ...stored("C", "effort"), ...known.keys()].filter((path) => known.has(path));
  return [...new Set(found)].slice(0, USUAL);
}
