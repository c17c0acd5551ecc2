/**
 * Places on the page: ELK places figures and groups, and routes what joins them; figures place their own spots.
 *
 * The same document gives the same layout, whoever asks for it.
 */

import type { ElkExtendedEdge, ElkNode } from "elkjs/lib/elk-api";
import { figuresOf, PORT, TITLE, type Figure, type Spot } from "./figures.ts";
import type { Visible, VisibleBond } from "./fold.ts";
import { isJunction, type Signal } from "./picture.ts";
import { widthOf } from "./text.ts";

/** The engine that places boxes: ELK in a page or worker, or in Python's JavaScript engine. */
export interface Placer {
  layout(graph: ElkNode): Promise<ElkNode>;
}

export interface Point {
  readonly x: number;
  readonly y: number;
}

/** An open group as a frame. */
export interface Frame {
  readonly path: string;
  readonly name: string;
  readonly depth: number;
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** A bond with its line, from tail to head. */
export interface BondLine {
  readonly shown: VisibleBond;
  readonly points: readonly Point[];
}

/** A signal with the four points of its curve (a cubic Bezier curve), from giver to user. */
export interface SignalLine {
  readonly signal: Signal;
  readonly points: readonly [Point, Point, Point, Point];
}

export interface Layout {
  readonly width: number;
  readonly height: number;
  readonly frames: readonly Frame[];
  readonly spots: readonly Spot[];
  readonly bonds: readonly BondLine[];
  readonly signals: readonly SignalLine[];
}

const RADIUS = 11; // around the symbol of a junction or two-port, where its bonds end

/** Which way power flows through the page. */
export type Direction = "RIGHT" | "DOWN";

const OPTIONS = {
  "elk.algorithm": "layered",
  "elk.hierarchyHandling": "INCLUDE_CHILDREN",
  "elk.edgeRouting": "ORTHOGONAL",
  "elk.layered.nodePlacement.strategy": "NETWORK_SIMPLEX",
  "elk.layered.mergeEdges": "false",
  "elk.spacing.nodeNode": "22",
  "elk.spacing.edgeNode": "14",
  "elk.spacing.edgeEdge": "12",
  "elk.layered.spacing.nodeNodeBetweenLayers": "40",
  "elk.layered.spacing.edgeNodeBetweenLayers": "18",
  "elk.layered.spacing.edgeEdgeBetweenLayers": "12",
  "elk.spacing.portPort": String(PORT),
  "elk.portAlignment.default": "CENTER",
  "elk.json.shapeCoords": "ROOT",
  "elk.json.edgeCoords": "ROOT",
};

/** Place what is visible. */
export async function place(visible: Visible, placer: Placer, direction: Direction = "RIGHT"): Promise<Layout> {
  const figures = figuresOf(visible);
  const figureOf = new Map<string, Figure>();
  for (const figure of figures) for (const spot of figure.spots) figureOf.set(spot.id, figure);
  const inner = new Set(figures.flatMap((figure) => figure.inner));
  const outer = visible.bonds.filter((bond) => !inner.has(bond));

  const boxes = new Map<string, ElkNode>();
  for (const group of visible.groups) {
    boxes.set(group.path, {
      id: `frame:${group.path}`,
      children: [],
      layoutOptions: {
        "elk.padding": group.path === "" ? "[top=8,left=8,bottom=8,right=8]" : "[top=32,left=14,bottom=14,right=14]",
        "elk.nodeSize.constraints": "MINIMUM_SIZE",
        "elk.nodeSize.minimum": `(${Math.ceil(widthOf(group.name, TITLE, true)) + 40}, 40)`,
      },
    });
  }
  for (const group of visible.groups) {
    if (group.path !== "") boxes.get(group.parent)?.children?.push(boxes.get(group.path) as ElkNode);
  }
  for (const figure of figures) {
    boxes.get(figure.group)?.children?.push({ id: figure.id, width: figure.width, height: figure.height });
  }
  const root = boxes.get("") ?? { id: "frame:", children: [] };
  const edges: ElkExtendedEdge[] = outer.map((bond, number) => ({
    id: `bond:${number}`,
    sources: [figureOf.get(bond.tail)?.id ?? bond.tail],
    targets: [figureOf.get(bond.head)?.id ?? bond.head],
  }));
  const graph: ElkNode = {
    ...root,
    id: "frame:",
    edges,
    layoutOptions: { ...OPTIONS, ...root.layoutOptions, "elk.direction": direction },
  };
  const drafted = await placer.layout(JSON.parse(JSON.stringify(graph)) as ElkNode);
  const placed = await placer.layout(withPorts(graph, drafted, figures));
  return collected(visible, figures, outer, placed);
}

/**
 * The graph with a port for every end of a bond, on the side and in the order of a draft: ELK alone centres bonds on the
 * side of a figure, but its junction need not be in the middle.
 */
function withPorts(graph: ElkNode, drafted: ElkNode, figures: readonly Figure[]): ElkNode {
  const figureOf = new Map(figures.map((figure) => [figure.id, figure]));
  const corners = new Map<string, ElkNode>();
  const lines = new Map<string, ElkExtendedEdge>();
  for (const box of everyBox(drafted)) {
    corners.set(box.id, box);
    for (const edge of box.edges ?? []) lines.set(edge.id, edge);
  }
  const sides = new Map<string, { port: string; at: Point }[]>();
  for (const edge of graph.edges ?? []) {
    const section = lines.get(edge.id)?.sections?.[0];
    const [source, target] = [edge.sources[0], edge.targets[0]];
    if (section === undefined || source === undefined || target === undefined) continue;
    for (const [owner, port, at] of [
      [source, `${edge.id}:tail`, section.startPoint],
      [target, `${edge.id}:head`, section.endPoint],
    ] as const) {
      const ends = sides.get(owner) ?? [];
      ends.push({ port, at });
      sides.set(owner, ends);
    }
    edge.sources = [`${edge.id}:tail`];
    edge.targets = [`${edge.id}:head`];
  }
  for (const box of everyBox(graph)) {
    const figure = figureOf.get(box.id);
    const corner = corners.get(box.id);
    if (figure === undefined || corner === undefined) continue;
    const ends = sides.get(box.id) ?? [];
    const isWest = ({ at }: { at: Point }): boolean => at.x < (corner.x ?? 0) + figure.width / 2;
    box.ports = [];
    for (const side of [ends.filter(isWest), ends.filter((end) => !isWest(end))]) {
      side.sort((a, b) => a.at.y - b.at.y);
      side.forEach((end, place) => {
        const y = figure.middle + PORT * (place - (side.length - 1) / 2);
        box.ports?.push({
          id: end.port,
          width: 0,
          height: 0,
          x: isWest(end) ? 0 : figure.width,
          y: Math.min(Math.max(y, 1), figure.height - 1),
          layoutOptions: { "elk.port.side": isWest(end) ? "WEST" : "EAST" },
        });
      });
    }
    box.layoutOptions = { ...box.layoutOptions, "elk.portConstraints": "FIXED_POS" };
  }
  return graph;
}

function* everyBox(root: ElkNode): Generator<ElkNode> {
  const pending = [root];
  for (let box = pending.pop(); box !== undefined; box = pending.pop()) {
    yield box;
    pending.push(...(box.children ?? []));
  }
}

function collected(
  visible: Visible,
  figures: readonly Figure[],
  outer: readonly VisibleBond[],
  placed: ElkNode,
): Layout {
  const corner = new Map<string, Point>();
  const frames: Frame[] = [];
  const names = new Map(visible.groups.map((group) => [`frame:${group.path}`, group]));
  const lines = new Map<string, Point[]>();
  const pending: [ElkNode, number][] = [[placed, 0]];
  while (pending.length > 0) {
    const [box, depth] = pending.pop() as [ElkNode, number];
    const [x, y] = [box.x ?? 0, box.y ?? 0];
    corner.set(box.id, { x, y });
    const group = names.get(box.id);
    if (group !== undefined && group.path !== "") {
      frames.push({ path: group.path, name: group.name, depth, x, y, width: box.width ?? 0, height: box.height ?? 0 });
    }
    for (const child of box.children ?? []) pending.push([child, depth + 1]);
    for (const edge of box.edges ?? []) {
      const section = edge.sections?.[0];
      if (section !== undefined) {
        lines.set(edge.id, [section.startPoint, ...(section.bendPoints ?? []), section.endPoint]);
      }
    }
  }
  frames.sort((a, b) => a.depth - b.depth || (a.path < b.path ? -1 : 1));

  const spots = new Map<string, Spot>();
  for (const figure of figures) {
    const at = corner.get(figure.id) ?? { x: 0, y: 0 };
    for (const spot of figure.spots) spots.set(spot.id, { ...spot, x: spot.x + at.x, y: spot.y + at.y });
  }
  const whole = (id: string, from: string, to: string): Point[] => {
    const line = lines.get(id);
    const [tail, head] = [spots.get(from), spots.get(to)];
    if (line === undefined || tail === undefined || head === undefined) throw new Error(`no way from ${from} to ${to}`);
    const back = reaching([...line].reverse(), tail).reverse();
    return tidy(reaching(back, head));
  };
  const bonds: BondLine[] = outer.map((shown, number) => ({
    shown,
    points: whole(`bond:${number}`, shown.tail, shown.head),
  }));
  for (const figure of figures) {
    for (const shown of figure.inner) {
      const [tail, head] = [spots.get(shown.tail), spots.get(shown.head)];
      if (tail !== undefined && head !== undefined) bonds.push({ shown, points: between(tail, head) });
    }
  }
  const signals: SignalLine[] = [];
  for (const signal of visible.signals) {
    const [from, to] = [spots.get(signal.from), spots.get(signal.to)];
    if (from !== undefined && to !== undefined) signals.push({ signal, points: curve(from, to) });
  }
  return {
    width: placed.width ?? 0,
    height: placed.height ?? 0,
    frames,
    spots: [...spots.values()],
    bonds,
    signals,
  };
}

/** A line that ends at the border of a figure, prolonged to the spot inside that it belongs to. */
function reaching(line: readonly Point[], spot: Spot): Point[] {
  const last = line[line.length - 1] as Point;
  const before = line[line.length - 2] ?? last;
  const isLevel = Math.abs(last.y - before.y) <= Math.abs(last.x - before.x);
  const points = [...line];
  if (spot.node !== undefined && isJunction(spot.node)) {
    const [dx, dy] = [last.x - spot.x, last.y - spot.y];
    if (isLevel && Math.abs(dy) > 1.5) {
      const reach = Math.min(Math.abs(dx), RADIUS + 5 + Math.abs(dy));
      points.push({ x: spot.x + Math.sign(dx) * reach, y: last.y });
    } else if (!isLevel && Math.abs(dx) > 1.5) {
      const reach = Math.min(Math.abs(dy), RADIUS + 5 + Math.abs(dx));
      points.push({ x: last.x, y: spot.y + Math.sign(dy) * reach });
    }
    if (points.length === line.length) {
      points.push(
        isLevel
          ? { x: spot.x + Math.sign(dx) * RADIUS, y: last.y }
          : { x: last.x, y: spot.y + Math.sign(dy) * RADIUS },
      );
      return points;
    }
    const from = points[points.length - 1] as Point;
    const length = Math.hypot(from.x - spot.x, from.y - spot.y) || 1;
    points.push({
      x: spot.x + ((from.x - spot.x) * RADIUS) / length,
      y: spot.y + ((from.y - spot.y) * RADIUS) / length,
    });
    return points;
  }
  const limit = (value: number, centre: number, extent: number): number =>
    Math.min(Math.max(value, centre - extent), centre + extent);
  if (isLevel) {
    const side = Math.sign(last.x - spot.x) || 1;
    const y = limit(last.y, spot.y, Math.max(spot.height / 2 - 3, 0));
    if (Math.abs(y - last.y) > 0.5) points.push({ x: spot.x + side * (spot.width / 2 + 8), y: last.y });
    points.push({ x: spot.x + (side * spot.width) / 2, y });
  } else {
    const side = Math.sign(last.y - spot.y) || 1;
    const x = limit(last.x, spot.x, Math.max(spot.width / 2 - 3, 0));
    if (Math.abs(x - last.x) > 0.5) points.push({ x: last.x, y: spot.y + side * (spot.height / 2 + 8) });
    points.push({ x, y: spot.y + (side * spot.height) / 2 });
  }
  return points;
}

/** The straight line between a junction and an element above or below it. */
function between(tail: Spot, head: Spot): Point[] {
  const isUp = head.node !== undefined && isJunction(head.node);
  const [junction, element] = isUp ? [head, tail] : [tail, head];
  const side = Math.sign(element.y - junction.y);
  const end = { x: element.x, y: element.y - (side * element.height) / 2 };
  const length = Math.hypot(end.x - junction.x, end.y - junction.y) || 1;
  const start = {
    x: junction.x + ((end.x - junction.x) * RADIUS) / length,
    y: junction.y + ((end.y - junction.y) * RADIUS) / length,
  };
  return isUp ? [end, start] : [start, end];
}

/** A curve between the sides of two spots that face each other. */
function curve(from: Spot, to: Spot): [Point, Point, Point, Point] {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const apartX = Math.abs(dx) - (from.width + to.width) / 2;
  const apartY = Math.abs(dy) - (from.height + to.height) / 2;
  if (apartX >= apartY) {
    const side = Math.sign(dx) || 1;
    const start = { x: from.x + (side * from.width) / 2, y: from.y };
    const end = { x: to.x - (side * to.width) / 2, y: to.y };
    const reach = side * Math.max(24, Math.abs(end.x - start.x) / 2.5);
    return [start, { x: start.x + reach, y: start.y }, { x: end.x - reach, y: end.y }, end];
  }
  const side = Math.sign(dy) || 1;
  const start = { x: from.x, y: from.y + (side * from.height) / 2 };
  const end = { x: to.x, y: to.y - (side * to.height) / 2 };
  const reach = side * Math.max(24, Math.abs(end.y - start.y) / 2.5);
  return [start, { x: start.x, y: start.y + reach }, { x: end.x, y: end.y - reach }, end];
}

/** The same line without points that change nothing. */
function tidy(line: readonly Point[]): Point[] {
  const found: Point[] = [];
  for (const point of line) {
    const last = found[found.length - 1];
    if (last !== undefined && Math.hypot(point.x - last.x, point.y - last.y) < 0.25) continue;
    const before = found[found.length - 2];
    if (last !== undefined && before !== undefined) {
      const turn = (last.x - before.x) * (point.y - last.y) - (last.y - before.y) * (point.x - last.x);
      if (Math.abs(turn) < 1e-6) found.pop();
    }
    found.push(point);
  }
  return found;
}


