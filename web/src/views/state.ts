/** A ranking as the reader looks at it: part of the run, threshold, and rows that are to stay or to go whatever their activity. */

import { computed } from "@preact/signals";
import type { Address } from "./address.ts";
import { GraphChoices } from "./choices.ts";
import { exactNumbers, keptBy, rankedWithin, type RankingData } from "./data.ts";

/** What fills and dashes of the graph show: what the threshold would keep, or the reduction that was made. */
export type Shown = "threshold" | "reduction";

/** What the reader has said about a row. */
export type Lock = "keep" | "go";

export class RankingState {
  readonly graph: GraphChoices;
  readonly threshold;
  readonly shown;
  /** The part of the run that is ranked, as places among the instants at which activity was kept. */
  readonly window;
  readonly times: Float64Array;
  readonly rows;
  /** How many rows the threshold keeps, from the top. */
  readonly kept;
  readonly locks;
  /** The paths of rows that stay: by the threshold, or because the reader said so. */
  readonly staying;
  /** The paths of the others. */
  readonly below;
  private readonly activities: ReadonlyMap<string, Float64Array>;

  constructor(
    readonly data: RankingData,
    readonly address: Address,
    usual: Shown,
  ) {
    this.graph = new GraphChoices(data.picture, address);
    this.times = exactNumbers(data.windows.times);
    this.activities = new Map(Object.entries(data.windows.rows).map(([path, text]) => [path, exactNumbers(text)]));
    this.threshold = computed(() => {
      const found = Number(address.word("threshold"));
      return address.word("threshold") !== null && found >= 0 && found <= 1 ? found : data.threshold;
    });
    this.shown = computed<Shown>(() => {
      const found = address.word("shown");
      return found === "threshold" || found === "reduction" ? found : usual;
    });
    const words = computed(() => [address.word("from"), address.word("to")].join(" "));
    this.window = computed<readonly [number, number] | null>(() => {
      const [from, to] = words.value.split(" ");
      if (from === "" || to === "" || from === undefined || to === undefined) return null;
      const [first, last] = [this.placeOf(Number(from)), this.placeOf(Number(to))];
      return first < last ? [first, last] : null;
    });
    this.rows = computed(() => {
      const window = this.window.value;
      return window === null ? data.rows : rankedWithin(data.rows, this.activities, ...window);
    });
    this.kept = computed(() => keptBy(this.rows.value, this.threshold.value));
    const said = computed(() => JSON.stringify([address.all("keep"), address.all("go")]));
    this.locks = computed<ReadonlyMap<string, Lock>>(() => {
      const [keep, go] = JSON.parse(said.value) as [string[], string[]];
      return new Map([...keep.map((path) => [path, "keep"] as const), ...go.map((path) => [path, "go"] as const)]);
    });
    this.staying = computed<ReadonlySet<string>>(() => {
      const locks = this.locks.value;
      const kept = this.kept.value;
      const stays = (path: string, place: number): boolean => (locks.has(path) ? locks.get(path) === "keep" : place < kept);
      return new Set(this.rows.value.map((row) => row.path).filter(stays));
    });
    this.below = computed<ReadonlySet<string>>(
      () => new Set(this.rows.value.map((row) => row.path).filter((path) => !this.staying.value.has(path))),
    );
  }

  /** The activity of a row since the start, J, at `times`. */
  activityOf(row: string): Float64Array | undefined {
    return this.activities.get(row);
  }

  setThreshold(threshold: number): void {
    const value = Math.min(1, Math.max(0, threshold));
    this.address.write({ threshold: value === this.data.threshold ? null : String(value), shown: "threshold" });
  }

  setShown(shown: Shown): void {
    this.address.write({ shown });
  }

  setWindow(window: readonly [number, number] | null): void {
    const last = this.times.length - 1;
    const isWhole = window === null || (window[0] === 0 && window[1] === last);
    this.address.write({
      from: isWhole ? null : String(this.times[window[0]]),
      to: isWhole ? null : String(this.times[window[1]]),
    });
  }

  /** Say that a row stays, or goes, or is left to the threshold again. */
  lock(row: string, lock: Lock | null): void {
    const without = (name: Lock): string[] => this.address.all(name).filter((path) => path !== row);
    this.address.write({
      keep: [...without("keep"), ...(lock === "keep" ? [row] : [])],
      go: [...without("go"), ...(lock === "go" ? [row] : [])],
    });
  }

  /** The instant next to a time. */
  private placeOf(time: number): number {
    let best = 0;
    this.times.forEach((at, i) => {
      if (Math.abs(at - time) < Math.abs((this.times[best] ?? 0) - time)) best = i;
    });
    return best;
  }
}
