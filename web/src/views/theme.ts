/** Light or dark: as the reader's system has it, until the reader says otherwise. */

import { computed, effect } from "@preact/signals";
import type { Theme } from "../graph/notation.ts";
import type { Address } from "./address.ts";

export class Themes {
  readonly theme;
  private readonly usual: Theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";

  constructor(private readonly address: Address) {
    this.theme = computed<Theme>(() => {
      const wanted = address.word("theme");
      return wanted === "dark" || wanted === "light" ? wanted : this.usual;
    });
    effect(() => {
      document.documentElement.dataset.theme = this.theme.value;
    });
  }

  turn(): void {
    const other = this.theme.value === "dark" ? "light" : "dark";
    this.address.write({ theme: other === this.usual ? null : other });
  }
}
