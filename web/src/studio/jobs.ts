/** Runs and reductions, kept up to date by one stream of events. */

import { computed, signal } from "@preact/signals";
import type { Job, JobState } from "./api.ts";
import { addressOf, get } from "./client.ts";

export const isOver = (state: JobState): boolean => state !== "queued" && state !== "running";

/** Whether there is anything to plot. */
export const hasData = (job: Job): boolean => job.kind === "run" && job.progress !== null;

export class Jobs {
  readonly byId = signal<ReadonlyMap<string, Job>>(new Map());
  /** Newest first. */
  readonly all = computed(() => [...this.byId.value.values()].sort((a, b) => (a.created < b.created ? 1 : a.created > b.created ? -1 : 0)));
  readonly runs = computed(() => this.all.value.filter((job) => job.kind === "run"));
  readonly isConnected = signal(true);

  start(): void {
    const events = new EventSource(addressOf("/events"));
    events.addEventListener("job", (event) => this.take(JSON.parse((event as MessageEvent<string>).data) as Job));
    events.addEventListener("deleted", (event) => this.drop((JSON.parse((event as MessageEvent<string>).data) as { readonly id: string }).id));
    events.addEventListener("open", () => {
      this.isConnected.value = true;
      // What changed while nothing was heard.
      void this.load();
    });
    events.addEventListener("error", () => (this.isConnected.value = false));
  }

  async load(): Promise<void> {
    this.byId.value = new Map((await get<Job[]>("/jobs")).map((job) => [job.id, job]));
  }

  take(job: Job): void {
    this.byId.value = new Map(this.byId.value).set(job.id, job);
  }

  drop(id: string): void {
    const found = new Map(this.byId.value);
    found.delete(id);
    this.byId.value = found;
  }
}

/** How a job is called in lists. */
export const titleOf = (job: Job): string => `${job.name}, ${job.scenario}`;

/** When a job was made, as short as it can be. */
export function made(job: Job): string {
  const at = new Date(job.created);
  const isToday = at.toDateString() === new Date().toDateString();
  return isToday
    ? at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit", second: "2-digit" })
    : at.toLocaleString([], { month: "short", day: "numeric", hour: "2-digit", minute: "2-digit" });
}
