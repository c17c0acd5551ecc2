/** What the reader has chosen: one selection and one threshold for all views; the address of the page holds them. */

import { computed, effect, signal } from "@preact/signals";
import { openTo } from "../graph/fold.ts";
import type { Theme } from "../graph/notation.ts";
import { exactNumbers, keptBy, rankedWithin, type StudyData } from "./data.ts";

/** What fills and dashes of the graph show: what the threshold would keep, or the reduction that was made. */
export type Shown = "threshold" | "reduction";

export class State {
  readonly threshold;
  readonly selected = signal<string | null>(null);
  readonly open;
  readonly shown = signal<Shown>("reduction");
  readonly theme = signal<Theme>(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  /** The part of the run that is ranked, as places among the instants at which activity was kept. */
  readonly window = signal<readonly [number, number] | null>(null);
  readonly times: Float64Array;
  readonly rows;
  readonly kept;

  constructor(readonly data: StudyData) {
    this.threshold = signal(data.threshold);
    this.open = signal<ReadonlySet<string>>(openTo(data.picture, 1));
    this.times = exactNumbers(data.windows.times);
    const activities = new Map(Object.entries(data.windows.rows).map(([path, text]) => [path, exactNumbers(text)]));
    this.rows = computed(() => {
      const window = this.window.value;
      return window === null ? data.rows : rankedWithin(data.rows, activities, ...window);
    });
    this.kept = computed(() => keptBy(this.rows.value, this.threshold.value));
    this.read();
    effect(() => this.write());
    addEventListener("hashchange", () => this.read());
    effect(() => {
      document.documentElement.dataset.theme = this.theme.value;
    });
  }

  /** Open a closed group, or close an open one with all that is in it. */
  toggle(group: string): void {
    const open = new Set(this.open.value);
    if (open.has(group)) {
      for (const path of [...open]) if (path === group || path.startsWith(`${group}.`)) open.delete(path);
      if (group === "") open.add("");
    } else open.add(group);
    this.open.value = open;
  }

  /** Open all groups around a thing, so that it is visible. */
  reveal(path: string): void {
    const node = this.data.picture.nodes.find((found) => found.path === path || found.row === path);
    if (node === undefined) return;
    const open = new Set(this.open.value);
    const parents = new Map(this.data.picture.groups.map((group) => [group.path, group.parent]));
    for (let at = node.group; at !== ""; at = parents.get(at) ?? "") open.add(at);
    if (open.size !== this.open.value.size) this.open.value = open;
  }

  /** The instant next to a time. */
  private placeOf(time: number): number {
    let best = 0;
    this.times.forEach((at, i) => {
      if (Math.abs(at - time) < Math.abs((this.times[best] ?? 0) - time)) best = i;
    });
    return best;
  }

  private read(): void {
    const words = new URLSearchParams(location.hash.slice(1));
    const threshold = Number(words.get("threshold"));
    if (words.has("threshold") && threshold >= 0 && threshold <= 1) this.threshold.value = threshold;
    if (words.get("shown") === "threshold" || words.get("shown") === "reduction") {
      this.shown.value = words.get("shown") as Shown;
    }
    const from = words.get("from");
    const to = words.get("to");
    if (from !== null && to !== null) {
      const [first, last] = [this.placeOf(Number(from)), this.placeOf(Number(to))];
      if (first < last) this.window.value = [first, last];
    }
    if (words.has("selected")) this.selected.value = words.get("selected");
    const open = words.get("open");
    if (open !== null) {
      const known = new Set(this.data.picture.groups.map((group) => group.path));
      this.open.value = new Set(["", ...open.split(",").filter((path) => known.has(path))]);
    }
  }

  private write(): void {
    const words = new URLSearchParams();
    if (this.threshold.value !== this.data.threshold) words.set("threshold", String(this.threshold.value));
    if (this.shown.value !== "reduction") words.set("shown", this.shown.value);
    const window = this.window.value;
    if (window !== null) {
      words.set("from", String(this.times[window[0]]));
      words.set("to", String(this.times[window[1]]));
    }
    if (this.selected.value !== null) words.set("selected", this.selected.value);
    const usual = openTo(this.data.picture, 1);
    const open = this.open.value;
    if (open.size !== usual.size || [...usual].some((path) => !open.has(path))) {
      words.set("open", [...open].filter((path) => path !== "").join(","));
    }
    const hash = words.toString();
    if (hash !== location.hash.slice(1)) history.replaceState(null, "", hash === "" ? location.pathname + location.search : `#${hash}`);
  }
}
