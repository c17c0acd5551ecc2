import { describe, expect, test } from "vitest";
import { fold, openTo, type Visible } from "../src/graph/fold.ts";
import { NOTE, SIZE, TITLE, type Spot } from "../src/graph/figures.ts";
import { place, type Frame, type Layout, type Point } from "../src/graph/layout.ts";
import { isJunction, isTwoPort } from "../src/graph/picture.ts";
import { widthOf } from "../src/graph/text.ts";
import { elk, NAMES, picture } from "./pictures.ts";

interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

const boxOf = (spot: Spot): Box => ({
  x: spot.x - spot.width / 2,
  y: spot.y - spot.height / 2,
  width: spot.width,
  height: spot.height,
});
const overlap = (a: Box, b: Box): boolean =>
  a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
const inside = (a: Box, b: Box): boolean =>
  a.x >= b.x && a.y >= b.y && a.x + a.width <= b.x + b.width && a.y + a.height <= b.y + b.height;

const CASES = NAMES.flatMap((name) => [0, 1, 2, 9].map((depth) => [name, depth] as const));

async function layoutOf(name: (typeof NAMES)[number], depth: number): Promise<[Visible, Layout]> {
  const shown = picture(name);
  const visible = fold(shown, openTo(shown, depth));
  return [visible, await place(visible, elk)];
}

describe.each(CASES)("%s, open to depth %i", async (name, depth) => {
  const [visible, layout] = await layoutOf(name, depth);
  const spots = new Map(layout.spots.map((spot) => [spot.id, spot]));

  test("everything visible has a place, and every bond a line", () => {
    expect(layout.spots.length).toBe(visible.nodes.length + visible.closed.length);
    expect(layout.bonds.length).toBe(visible.bonds.length);
    expect(layout.signals.length).toBe(visible.signals.length);
    for (const line of layout.bonds) expect(line.points.length).toBeGreaterThanOrEqual(2);
  });

  test("no two boxes overlap", () => {
    const boxes = layout.spots.map((spot) => [spot.id, boxOf(spot)] as const);
    const clashes: string[] = [];
    boxes.forEach(([one, a], i) => {
      for (const [other, b] of boxes.slice(i + 1)) if (overlap(a, b)) clashes.push(`${one} and ${other}`);
    });
    expect(clashes).toEqual([]);
  });

  test("labels fit into their boxes", () => {
    const tooLong = layout.spots.filter((spot) => {
      const room = spot.width - (spot.closed === undefined ? 0 : 20);
      const size = spot.closed === undefined ? SIZE : TITLE;
      return widthOf(spot.label, size, spot.closed !== undefined) > room;
    });
    expect(tooLong.map((spot) => spot.id)).toEqual([]);
    for (const spot of layout.spots) if (spot.closed !== undefined) expect(widthOf(spot.note, NOTE)).toBeLessThan(spot.width);
  });

  test("everything is inside its group", () => {
    const frames = new Map<string, Frame>(layout.frames.map((frame) => [frame.path, frame]));
    const page = { x: 0, y: 0, width: layout.width, height: layout.height };
    for (const spot of layout.spots) {
      const group = spot.node?.group ?? spot.closed?.group ?? "";
      expect(inside(boxOf(spot), frames.get(group) ?? page), `${spot.id} in ${group}`).toBe(true);
    }
  });

  test("bonds end where their things are", () => {
    for (const { shown, points } of layout.bonds) {
      for (const [id, end] of [[shown.tail, points[0]], [shown.head, points[points.length - 1]]] as const) {
        const spot = spots.get(id) as Spot;
        const at = end as Point;
        const plain = spot.node !== undefined && (isJunction(spot.node) || isTwoPort(spot.node.kind));
        const reach = plain ? 4 : 0.5;
        expect(Math.abs(at.x - spot.x)).toBeLessThanOrEqual(spot.width / 2 + reach);
        expect(Math.abs(at.y - spot.y)).toBeLessThanOrEqual(spot.height / 2 + reach);
      }
    }
  });

  test("the same document gives the same layout", async () => {
    const [, again] = await layoutOf(name, depth);
    expect(JSON.stringify(again)).toBe(JSON.stringify(layout));
  });
});

test("one-port elements stand above and below their junction", async () => {
  const [, layout] = await layoutOf("quarter_car", 9);
  const at = (id: string): Spot => layout.spots.find((spot) => spot.id === id) as Spot;
  const body = at("body");
  const line = layout.bonds.find(({ shown }) => shown.tail === "body" || shown.head === "body");
  const junction = at(line?.shown.tail === "body" ? line.shown.head : (line?.shown.tail ?? ""));
  expect(body.y).toBeLessThan(junction.y);
  expect(at("suspension.spring").y).toBeGreaterThan(junction.y);
});
