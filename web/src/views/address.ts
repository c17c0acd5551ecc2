/**
 * The address of the page holds the view: a screen and words, as in `#/activity?run=12&threshold=0.99`, or words alone, as in
 * `#threshold=0.99`. So going back, loading anew and mailing an address give the same view.
 */

import { signal } from "@preact/signals";

export interface Place {
  readonly screen: string; // empty where the page has no screens
  readonly words: URLSearchParams;
}

/** What a hash says. */
export function placeOf(hash: string): Place {
  const text = hash.replace(/^#/, "");
  if (!text.startsWith("/")) return { screen: "", words: new URLSearchParams(text) };
  const mark = text.indexOf("?");
  return mark < 0
    ? { screen: text.slice(1), words: new URLSearchParams() }
    : { screen: text.slice(1, mark), words: new URLSearchParams(text.slice(mark + 1)) };
}

/** The hash that says it; empty where there is nothing to say. Paths stay readable. */
export function hashOf({ screen, words }: Place): string {
  const text = words.toString().replaceAll("%2C", ",").replaceAll("%2F", "/").replaceAll("%3A", ":");
  if (screen === "") return text === "" ? "" : `#${text}`;
  return text === "" ? `#/${screen}` : `#/${screen}?${text}`;
}

/** Words with some of them changed; a word without a value goes. */
export function changed(words: URLSearchParams, changes: Readonly<Record<string, Value>>): URLSearchParams {
  const found = new URLSearchParams(words);
  for (const [name, value] of Object.entries(changes)) {
    found.delete(name);
    if (value === null) continue;
    if (typeof value === "string") found.set(name, value);
    else for (const one of value) found.append(name, one);
  }
  return found;
}

export type Value = string | readonly string[] | null;

const QUIET = 150; // ms without a change until the address is written: browsers limit how often that may be

export class Address {
  readonly place;
  private waiting: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    this.place = signal<Place>(placeOf(location.hash));
    addEventListener("hashchange", () => {
      clearTimeout(this.waiting);
      const found = placeOf(location.hash);
      if (hashOf(found) !== hashOf(this.place.value)) this.place.value = found;
    });
    addEventListener("pagehide", () => this.flush());
  }

  word(name: string): string | null {
    return this.place.value.words.get(name);
  }

  all(name: string): string[] {
    return this.place.value.words.getAll(name);
  }

  /** Change words of this view: what is adjusted replaces the entry of the history, a step to elsewhere makes one. */
  write(changes: Readonly<Record<string, Value>>, how: "adjust" | "step" = "adjust"): void {
    const { screen, words } = this.place.peek();
    this.move({ screen, words: changed(words, changes) }, how);
  }

  /** Go to another screen. */
  go(screen: string, words: URLSearchParams): void {
    this.move({ screen, words }, "step");
  }

  private move(place: Place, how: "adjust" | "step"): void {
    const hash = hashOf(place);
    if (hash === hashOf(this.place.peek())) return;
    if (how === "step") {
      this.flush();
      history.pushState(null, "", hash === "" ? location.pathname + location.search : hash);
      this.place.value = place;
      return;
    }
    this.place.value = place;
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.flush(), QUIET);
  }

  private flush(): void {
    clearTimeout(this.waiting);
    const hash = hashOf(this.place.peek());
    if (hash === location.hash) return;
    history.replaceState(null, "", hash === "" ? location.pathname + location.search : hash);
  }
}
