/**
 * What a page shows of a study: one document, inside the report or from a server. Python's side is
 * `propermodel.report.page`.
 */

import type { Picture } from "../graph/picture.ts";

/** A row of the ranking, with what became of it. */
export interface RankedRow {
  readonly path: string;
  readonly kind: string;
  readonly activity: number; // J
  readonly index: number;
  readonly cumulative: number;
  readonly verdict: "kept" | "removed" | "refused";
  readonly meaning: string;
  readonly reason: string;
}

/** A signal of both runs: least and greatest value in every interval, in turn. */
export interface SignalData {
  readonly path: string;
  readonly label: string;
  readonly unit: string; // as displayed
  readonly panel: string;
  readonly full: string; // little-endian float32, base64
  readonly reduced: string | null;
  readonly difference: string | null; // reduced less full
}

/** An output of the comparison, as shares of the range of the full model's run. */
export interface OutputRow {
  readonly path: string;
  readonly unit: string;
  readonly rms: number | null;
  readonly maximum: number | null;
  readonly at: number | null;
  readonly full: number | null;
  readonly reduced: number | null;
  readonly final: number | null;
}

/** Where energy came from and went, J. */
export interface BalanceData {
  readonly supplied: number;
  readonly stored: number;
  readonly dissipated: number;
  readonly residual: number; // share of the source work
  readonly sources: readonly { readonly path: string; readonly work: number }[];
}

/** Effort, flow and power at a port of an element: least and greatest value in every interval, in turn. */
export interface History {
  readonly bond: string;
  readonly units: readonly [string, string];
  readonly effort: string;
  readonly flow: string;
  readonly power: string;
}

/** A model that a search has tried. */
export interface Tried {
  readonly rows: number; // that stay
  readonly states: number;
  readonly score: number | null; // largest error over its tolerance
  readonly predicted: number | null;
  readonly verdict: string;
  readonly mark: "" | "recommended" | "smallest";
}

/** A figure of a summary. */
export interface Fact {
  readonly name: string;
  readonly value: string;
  readonly note: string;
}

/** The activity of one run, and how it can be ranked for parts of it. */
export interface RankingData {
  readonly model: string;
  readonly scenario: string;
  readonly window: readonly [number, number];
  readonly threshold: number;
  readonly facts: readonly Fact[];
  readonly picture: Picture;
  readonly rows: readonly RankedRow[];
  readonly totalActivity: number;
  readonly notes: readonly string[];
  /** The activity of every row since the start, at some instants: little-endian float64, base64. */
  readonly windows: { readonly times: string; readonly rows: Readonly<Record<string, string>> };
}

export interface StudyData extends RankingData {
  readonly format: "propermodel report";
  readonly version: 1;
  readonly outputs: readonly OutputRow[];
  readonly balances: { readonly full: BalanceData; readonly reduced: BalanceData };
  readonly signals: { readonly times: string; readonly items: readonly SignalData[] };
  readonly histories: { readonly times: string; readonly rows: Readonly<Record<string, readonly History[]>> };
  readonly tried: readonly Tried[] | null;
  readonly made: readonly { readonly name: string; readonly value: string }[];
  readonly certificate: readonly string[]; // lines of its text
}

/** The numbers in a text of little-endian float32 values. */
export function numbers(text: string): Float32Array {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

/** How many rows a threshold keeps: from the top, up to and with the one that reaches it (`ActivityRanking.kept_by`). */
export function keptBy(rows: readonly RankedRow[], threshold: number): number {
  if (threshold === 0) return 0;
  let share = 0;
  let kept = 0;
  for (const row of rows) {
    if (kept > 0 && share >= threshold && (threshold < 1 || row.activity === 0)) break;
    kept += 1;
    share = row.cumulative;
  }
  return kept;
}

/** The numbers in a text of little-endian float64 values. */
export function exactNumbers(text: string): Float64Array {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

/** The rows ranked by what they did between two instants, equal ones by their path (`rank_activity` with a window). */
export function rankedWithin(
  rows: readonly RankedRow[],
  activities: ReadonlyMap<string, Float64Array>,
  first: number,
  last: number,
): RankedRow[] {
  const found = rows.map((row) => {
    const column = activities.get(row.path);
    return { ...row, activity: column === undefined ? 0 : (column[last] ?? 0) - (column[first] ?? 0) };
  });
  found.sort((a, b) => b.activity - a.activity || (a.path < b.path ? -1 : 1));
  const total = found.reduce((sum, row) => sum + row.activity, 0);
  let sum = 0;
  return found.map((row) => {
    sum += row.activity;
    return { ...row, index: total > 0 ? row.activity / total : 0, cumulative: total > 0 ? sum / total : 0 };
  });
}
