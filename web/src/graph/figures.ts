/**
 * Figures: what is placed as one. A junction with the one-port elements of its group is one figure, inertias and sources
 * above and compliances and resistances below, as textbooks draw it; everything else is a figure of its own.
 */

import type { Closed, Visible, VisibleBond } from "./fold.ts";
import { isInformation, isJunction, isSource, isTwoPort, type Node } from "./picture.ts";
import { shortened, widthOf } from "./text.ts";

export const SIZE = 12; // of letters, px
export const TITLE = 13;
export const NOTE = 10;
const BOX = 26; // height of an element
const GAP = 14; // between elements side by side
const ARM = 40; // length of the bond between a junction and an element above or below it
const MOST_A_SIDE = 4;
const MOST_LETTERS = 20;
export const PORT = 16; // between bonds that end on the same side

/** A thing with its label, placed relative to the corner of its figure. */
export interface Spot {
  readonly id: string;
  readonly node: Node | undefined; // undefined for a closed group
  readonly closed: Closed | undefined;
  readonly label: string;
  readonly note: string;
  readonly x: number; // of the centre
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** Something to be placed: the spots in it, the first of which takes the bonds from outside. */
export interface Figure {
  readonly id: string;
  readonly group: string;
  readonly width: number;
  readonly height: number;
  readonly spots: readonly Spot[];
  /** Bonds between the junction and the elements of this figure. */
  readonly inner: readonly VisibleBond[];
  /** How far below the top bonds from outside meet the figure. */
  readonly middle: number;
}

/** What is written in an element: `I : name`, and for two-ports and junctions the symbol alone. */
export function labelOf(node: Node): string {
  if (isJunction(node) || isTwoPort(node.kind)) return node.kind;
  const name = shortened(node.name, MOST_LETTERS);
  return isInformation(node.kind) ? name : `${node.kind} : ${name}`;
}

/** Group what is visible into figures. */
export function figuresOf(visible: Visible): Figure[] {
  const nodes = new Map(visible.nodes.map((node) => [node.path, node]));
  const at = new Map<string, VisibleBond[]>();
  for (const bond of visible.bonds) {
    for (const end of [bond.tail, bond.head]) {
      const list = at.get(end) ?? [];
      list.push(bond);
      at.set(end, list);
    }
  }
  const taken = new Set<string>();
  const figures: Figure[] = [];
  for (const junction of visible.nodes.filter(isJunction)) {
    const above: [Node, VisibleBond][] = [];
    const below: [Node, VisibleBond][] = [];
    for (const bond of at.get(junction.path) ?? []) {
      const other = nodes.get(bond.tail === junction.path ? bond.head : bond.tail);
      if (other === undefined || other.group !== junction.group) continue;
      if (isJunction(other) || isTwoPort(other.kind) || (at.get(other.path) ?? []).length !== 1) continue;
      const goesUp = other.kind === "I" || isSource(other.kind);
      const [first, second] = goesUp ? [above, below] : [below, above];
      const side = first.length < MOST_A_SIDE ? first : second.length < MOST_A_SIDE ? second : undefined;
      if (side === undefined) continue;
      side.push([other, bond]);
      taken.add(other.path);
    }
    const outer = (at.get(junction.path) ?? []).length - above.length - below.length;
    figures.push(junctionFigure(junction, above, below, outer));
  }
  for (const node of visible.nodes) {
    if (isJunction(node) || taken.has(node.path)) continue;
    figures.push(singleFigure(node, (at.get(node.path) ?? []).length));
  }
  for (const closed of visible.closed) {
    figures.push(closedFigure(closed, (at.get(`group:${closed.path}`) ?? []).length));
  }
  return figures;
}

function elementSpot(node: Node, x: number, y: number): Spot {
  const label = labelOf(node);
  const note = isTwoPort(node.kind) ? shortened(node.name, MOST_LETTERS) : "";
  const plain = isJunction(node) || isTwoPort(node.kind);
  const width = Math.ceil(plain ? Math.max(22, widthOf(label, SIZE + 1) + 12) : widthOf(label, SIZE) + 20);
  return { id: node.path, node, closed: undefined, label, note, x, y, width, height: plain ? 20 : BOX };
}

function junctionFigure(
  junction: Node,
  above: readonly [Node, VisibleBond][],
  below: readonly [Node, VisibleBond][],
  outer: number,
): Figure {
  const corridor = Math.max(16, (PORT / 2) * Math.ceil(outer / 2) + 8);
  const widest = (side: readonly [Node, VisibleBond][]): number =>
    side.reduce((sum, [node]) => sum + elementSpot(node, 0, 0).width + GAP, -GAP);
  const width = Math.max(56, widest(above), widest(below));
  const arm = Math.max(ARM, corridor + 22);
  const top = above.length > 0 ? BOX + arm : corridor;
  const bottom = below.length > 0 ? BOX + arm : corridor;
  const middle = top;
  const spots = [elementSpot(junction, width / 2, middle)];
  for (const [side, y] of [[above, middle - arm - BOX / 2], [below, middle + arm + BOX / 2]] as const) {
    let x = (width - widest(side)) / 2;
    for (const [node] of side) {
      const spot = elementSpot(node, 0, y);
      spots.push({ ...spot, x: x + spot.width / 2 });
      x += spot.width + GAP;
    }
  }
  return {
    id: junction.path,
    group: junction.group,
    width,
    height: top + bottom,
    spots,
    inner: [...above, ...below].map(([, bond]) => bond),
    middle,
  };
}

function singleFigure(node: Node, bonds: number): Figure {
  const spot = elementSpot(node, 0, 0);
  const note = spot.note === "" ? 0 : 2 * (NOTE + 3);
  const height = Math.max(spot.height + note, PORT * Math.ceil(bonds / 2) + 6);
  const width = Math.max(spot.width, Math.ceil(widthOf(spot.note, NOTE)) + 4);
  const boxed = isTwoPort(node.kind) ? spot.height : Math.max(spot.height, PORT * Math.ceil(bonds / 2) + 6);
  return {
    id: node.path,
    group: node.group,
    width,
    height,
    spots: [{ ...spot, x: width / 2, y: height / 2, height: boxed }],
    inner: [],
    middle: height / 2,
  };
}

/** What a closed group tells of what is in it. */
export function noteOf(closed: Closed): string {
  if (closed.rows === 0) return "";
  if (closed.kept < closed.rows) return `${closed.kept} of ${closed.rows} kept`;
  return `${closed.rows} ${closed.rows === 1 ? "element" : "elements"}`;
}

function closedFigure(closed: Closed, bonds: number): Figure {
  const label = shortened(closed.name, 28);
  const note = noteOf(closed);
  const width = Math.ceil(Math.max(90, widthOf(label, TITLE, true) + 44, widthOf(note, NOTE) + 24));
  const height = Math.max(48, PORT * (bonds + 1));
  const id = `group:${closed.path}`;
  return {
    id,
    group: closed.group,
    width,
    height,
    spots: [{ id, node: undefined, closed, label, note, x: width / 2, y: height / 2, width, height }],
    inner: [],
    middle: height / 2,
  };
}
