/** What is visible when some groups are open and the others closed: a closed group stands for all that is in it. */

import { isEnergetic, type Bond, type Group, type Node, type Picture, type Signal } from "./picture.ts";

/** A closed group, drawn as one box. */
export interface Closed {
  readonly path: string;
  readonly name: string;
  readonly group: string;
  /** Rows in it: how many, how many of them stay, and the sum of their activities. */
  readonly rows: number;
  readonly kept: number;
  readonly share: number;
}

/** A bond between two visible things. */
export interface VisibleBond {
  readonly bond: Bond;
  readonly tail: string;
  readonly head: string;
}

export interface Visible {
  readonly picture: Picture;
  readonly groups: readonly Group[];
  readonly nodes: readonly Node[];
  readonly closed: readonly Closed[];
  readonly bonds: readonly VisibleBond[];
  readonly signals: readonly Signal[];
}

export class Hierarchy {
  private readonly groups: ReadonlyMap<string, Group>;

  constructor(picture: Picture) {
    this.groups = new Map(picture.groups.map((group) => [group.path, group]));
  }

  /** The groups around a group, itself included, the root first. */
  lineage(path: string): Group[] {
    const found: Group[] = [];
    for (let at = this.groups.get(path); at !== undefined; at = this.groups.get(at.parent)) {
      found.unshift(at);
      if (at.path === "") break;
    }
    return found;
  }
}

/** The groups down to a depth; the root alone is depth 0. */
export function openTo(picture: Picture, depth: number): Set<string> {
  const hierarchy = new Hierarchy(picture);
  return new Set(
    picture.groups.map((group) => group.path).filter((path) => hierarchy.lineage(path).length - 1 <= depth),
  );
}

/**
 * Fold a picture: only what is in open groups is visible, and closed groups in them. Rows below a threshold count as gone
 * where a closed group tells how many are kept.
 */
export function fold(picture: Picture, open: ReadonlySet<string>, below: ReadonlySet<string> = new Set()): Visible {
  const hierarchy = new Hierarchy(picture);
  const shownAs = new Map<string, string>();
  const standing = new Map<string, Node[]>();
  const nodes: Node[] = [];
  for (const node of picture.nodes) {
    const shut = hierarchy.lineage(node.group).find((group) => group.path !== "" && !open.has(group.path));
    if (shut === undefined) {
      shownAs.set(node.path, node.path);
      nodes.push(node);
    } else {
      shownAs.set(node.path, `group:${shut.path}`);
      const inside = standing.get(shut.path) ?? [];
      inside.push(node);
      standing.set(shut.path, inside);
    }
  }
  const isShown = (group: Group): boolean =>
    hierarchy.lineage(group.path).every((at) => at.path === "" || open.has(at.path));
  const closed = picture.groups
    .filter((group) => standing.has(group.path))
    .map((group) => closedGroup(picture, group, standing.get(group.path) ?? [], below));
  const place = (path: string): string => shownAs.get(path) ?? path;
  const bonds = picture.bonds
    .map((bond) => ({ bond, tail: place(bond.tail), head: place(bond.head) }))
    .filter(({ tail, head }) => tail !== head);
  const seen = new Set<string>();
  const signals: Signal[] = [];
  for (const signal of picture.signals) {
    const [from, to] = [place(signal.from), place(signal.to)];
    const key = `${from}>${to}`;
    if (from === to || seen.has(key)) continue;
    seen.add(key);
    signals.push({ from, to });
  }
  return { picture, groups: picture.groups.filter(isShown), nodes, closed, bonds, signals };
}

function closedGroup(picture: Picture, group: Group, inside: readonly Node[], below: ReadonlySet<string>): Closed {
  const rows = new Map<string, boolean>();
  for (const node of inside) {
    if (!isEnergetic(node.kind) || node.row === undefined) continue;
    rows.set(node.row, (rows.get(node.row) ?? false) || (node.gone === undefined && !below.has(node.row)));
  }
  let share = 0;
  for (const row of rows.keys()) share += picture.activity?.rows[row] ?? 0;
  return {
    path: group.path,
    name: group.name,
    group: group.parent,
    rows: rows.size,
    kept: [...rows.values()].filter(Boolean).length,
    share,
  };
}
