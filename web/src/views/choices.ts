/** What the reader has chosen in a drawn graph: what is open, what is selected, what is marked. */

import { computed } from "@preact/signals";
import { fold, Hierarchy, openTo } from "../graph/fold.ts";
import type { Picture } from "../graph/picture.ts";
import type { Address } from "./address.ts";

export class GraphChoices {
  readonly open;
  readonly selected;
  private readonly usual: ReadonlySet<string>;
  private readonly hierarchy: Hierarchy;

  constructor(
    readonly picture: Picture,
    readonly address: Address,
  ) {
    this.hierarchy = new Hierarchy(picture);
    this.usual = openTo(picture, usualDepth(picture));
    const known = new Set(picture.groups.map((group) => group.path));
    const words = computed(() => address.word("open"));
    this.open = computed<ReadonlySet<string>>(() =>
      words.value === null ? this.usual : new Set(["", ...words.value.split(",").filter((path) => known.has(path))]),
    );
    this.selected = computed(() => address.word("selected"));
  }

  select(path: string | null): void {
    this.address.write({ selected: path });
  }

  /** Select a thing and open all groups around it. */
  show(path: string): void {
    this.reveal([path]);
    this.select(path);
  }

  /** Open a closed group, or close an open one with all that is in it. */
  toggle(group: string): void {
    const open = new Set(this.open.peek());
    if (open.has(group)) {
      for (const path of [...open]) if (path === group || path.startsWith(`${group}.`)) open.delete(path);
      open.add("");
    } else for (const around of this.hierarchy.lineage(group)) open.add(around.path);
    this.set(open);
  }

  /** Open all groups around some things, so that they are visible. */
  reveal(paths: readonly string[]): void {
    const open = new Set(this.open.peek());
    const wanted = new Set(paths);
    const around = [
      ...this.picture.nodes.filter((node) => wanted.has(node.path) || (node.row !== undefined && wanted.has(node.row))).map((node) => node.group),
      ...this.picture.groups.filter((group) => wanted.has(group.path) && group.path !== "").map((group) => group.parent),
    ];
    for (const group of around) for (const one of this.hierarchy.lineage(group)) open.add(one.path);
    if (open.size !== this.open.peek().size) this.set(open);
  }

  openDepth(depth: number): void {
    this.set(openTo(this.picture, depth));
  }

  private set(open: ReadonlySet<string>): void {
    const isUsual = open.size === this.usual.size && [...this.usual].every((path) => open.has(path));
    const named = [...open].filter((path) => path !== "").sort();
    this.address.write({ open: isUsual ? null : named.join(",") }, "step");
  }
}

const DEEPEST = 2;
const ROOM = 40; // things whose letters can be read on one page

/** How deep a picture is opened at first: as deep as there is room for. */
export function usualDepth(picture: Picture): number {
  for (let depth = DEEPEST; depth > 0; depth--) {
    const { nodes, closed } = fold(picture, openTo(picture, depth));
    if (nodes.length + closed.length <= ROOM) return depth;
  }
  return 0;
}
