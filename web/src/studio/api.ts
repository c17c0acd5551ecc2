/**
 * What the studio's server and its pages say to each other. Python's side is `propermodel.studio`; a test of the server
 * compares its answers with these shapes.
 */

import type { Picture } from "../graph/picture.ts";
import type { BalanceData, Fact, History, OutputRow, RankingData, StudyData } from "../views/data.ts";

/** A model that can be opened; `id` is what the command line would take. */
export interface ModelEntry {
  readonly id: string;
  readonly name: string;
  readonly kind: "library" | "document" | "python";
  readonly file: string | null;
  readonly scenarios: readonly string[];
  readonly note: string;
}

export interface Start {
  readonly version: string;
  readonly folder: string;
  readonly trusted: boolean;
  readonly models: readonly ModelEntry[];
  readonly jobs: readonly Job[];
}

export type JobState = "queued" | "running" | "complete" | "failed" | "cancelled" | "lost";

export interface Progress {
  readonly time: number; // s
  readonly end: number; // s
  readonly steps: number;
  readonly rejected: number;
  readonly rate: number; // times real time
  readonly left: number | null; // s
}

/** A run or a reduction, now or earlier. */
export interface Job {
  readonly id: string;
  readonly kind: "run" | "reduction";
  readonly model: string;
  readonly name: string;
  readonly scenario: string;
  readonly run: string | null; // of a reduction: its full run
  readonly window: readonly [number, number]; // s, as asked for
  readonly state: JobState;
  readonly created: string; // ISO 8601
  readonly progress: Progress | null;
  readonly message: string;
  readonly elements: readonly string[];
  readonly outputs: readonly string[];
  readonly spark: readonly number[] | null;
  readonly summary: readonly Fact[];
}

export interface ParameterRow {
  readonly path: string;
  readonly value: string;
  readonly unit: string;
  readonly status: string;
  readonly source: string;
}

/** What is known of an element of a model. */
export interface ElementSheet {
  readonly kind: string;
  readonly laws: readonly string[];
  readonly parameters: readonly ParameterRow[];
  readonly equations: readonly string[];
  readonly bonds: readonly { readonly name: string; readonly effort: string; readonly flow: string }[];
  readonly place: string; // file:line
}

export interface Count {
  readonly name: string;
  readonly count: number;
  readonly paths: readonly string[];
}

export interface ModelSheet {
  readonly id: string;
  readonly name: string;
  readonly picture: Picture;
  readonly counts: readonly Count[];
  readonly elements: Readonly<Record<string, ElementSheet>>;
  readonly parameters: readonly ParameterRow[];
  readonly scenarios: readonly string[];
  readonly outputs: readonly string[];
  readonly methods: readonly string[];
  readonly method: string;
  readonly step: number | null;
  /** What the model's author usually looks at. */
  readonly panels: readonly Panel[];
  readonly warnings: readonly Fault[];
}

export interface Panel {
  readonly title: string;
  readonly signals: readonly { readonly path: string; readonly label: string; readonly dashed: boolean }[];
}

/** A scenario with a preview of its inputs. */
export interface ScenarioSheet {
  readonly name: string;
  readonly description: string;
  readonly start: number; // s
  readonly duration: number; // s
  readonly inputs: readonly {
    readonly path: string;
    readonly unit: string;
    readonly times: readonly number[];
    readonly values: readonly number[];
  }[];
}

export interface RunRequest {
  readonly model: string;
  readonly scenario: string;
  readonly until: number | null;
  readonly method: string;
  readonly step: number | null;
  readonly tolerance: number | null;
  readonly settings: Readonly<Record<string, string>>;
  readonly outputs: readonly string[];
}

export interface ReductionRequest {
  readonly run: string;
  readonly threshold: number;
  readonly from: number | null;
  readonly to: number | null;
  readonly keep: readonly string[];
  readonly go: readonly string[];
  readonly outputs: readonly string[];
}

export interface SignalEntry {
  readonly path: string;
  readonly unit: string;
  readonly display: { readonly unit: string; readonly factor: number };
}

/** What the activity of one run shows. */
export interface ActivityData extends RankingData {
  readonly balances: { readonly full: BalanceData };
}

export interface RowHistory {
  readonly times: string;
  readonly items: readonly History[];
}

/** Two runs side by side. */
export interface ComparisonData {
  readonly outputs: readonly OutputRow[];
  readonly balances: { readonly full: BalanceData; readonly reduced: BalanceData };
  readonly facts: readonly Fact[];
  readonly pictures: { readonly a: Picture; readonly b: Picture };
}

export type ReductionData = StudyData;

/** An error of the server, for its reader. */
export interface Fault {
  readonly code: string;
  readonly message: string;
  readonly place: string;
  readonly elements: readonly string[];
  readonly help: string;
  /** What else is wrong, found at the same time. */
  readonly others?: readonly Fault[];
}
