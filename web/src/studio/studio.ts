/** What all screens of the studio share: the address, the jobs, the models that were opened. */

import { computed } from "@preact/signals";
import ELK from "elkjs/lib/elk-api.js";
import type { Placer } from "../graph/layout.ts";
import { Address, changed, hashOf, type Value } from "../views/address.ts";
import { Themes } from "../views/theme.ts";
import type { Job, ModelSheet } from "./api.ts";
import { get, ServerSource } from "./client.ts";
import { Jobs } from "./jobs.ts";

export const SCREENS = [
  ["", "Start"],
  ["model", "Model"],
  ["run", "Run"],
  ["plots", "Plots"],
  ["activity", "Activity"],
  ["compare", "Compare"],
] as const;
export type Screen = (typeof SCREENS)[number][0];

/** Words that go along from screen to screen. */
const COMMON = ["model", "selected", "open", "theme"];

export class Studio {
  readonly address = new Address();
  readonly themes = new Themes(this.address);
  readonly jobs = new Jobs();
  readonly source = new ServerSource();
  readonly placer: Placer = new ELK({ workerUrl: "/assets/elk-worker.min.js" }) as unknown as Placer;
  readonly screen = computed<Screen>(() => SCREENS.find(([name]) => name === this.address.place.value.screen)?.[0] ?? "");
  /** The run that is looked at: the one in the address, or the last one of the model. */
  readonly run = computed<Job | null>(() => {
    const wanted = this.address.word("run");
    if (wanted !== null) return this.jobs.byId.value.get(wanted) ?? null;
    const model = this.address.word("model");
    return this.jobs.runs.value.find((job) => model === null || job.model === model) ?? null;
  });
  readonly model = computed<string | null>(() => {
    const wanted = this.address.word("model");
    if (wanted !== null) return wanted;
    const shown = this.address.word("run") ?? this.address.word("a") ?? this.address.word("reduction");
    return shown === null ? null : (this.jobs.byId.value.get(shown)?.model ?? null);
  });
  private readonly sheets = new Map<string, Promise<ModelSheet>>();

  /** What is known of a model; asked for once, until the page is loaded anew or that failed. */
  sheet(model: string): Promise<ModelSheet> {
    const known = this.sheets.get(model);
    if (known !== undefined) return known;
    const found = get<ModelSheet>("/model", { id: model });
    this.sheets.set(model, found);
    found.catch(() => this.sheets.delete(model));
    return found;
  }

  /** The address of a screen, with what goes along. */
  link(screen: Screen, words: Readonly<Record<string, Value>> = {}): string {
    const hash = hashOf({ screen, words: this.along(words) });
    return hash === "" ? "#/" : hash;
  }

  go(screen: Screen, words: Readonly<Record<string, Value>> = {}): void {
    this.address.go(screen, this.along(words));
  }

  private along(words: Readonly<Record<string, Value>>): URLSearchParams {
    const now = this.address.place.value.words;
    const kept = new URLSearchParams([...now].filter(([name]) => COMMON.includes(name)));
    const model = this.model.value;
    if (!kept.has("model") && model !== null) kept.set("model", model);
    // What is selected and open belongs to one model.
    const isOther = "model" in words && words["model"] !== kept.get("model");
    return changed(isOther ? changed(kept, { selected: null, open: null }) : kept, words);
  }
}
