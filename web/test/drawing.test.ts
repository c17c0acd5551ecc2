import { describe, expect, test } from "vitest";
import { draw } from "../src/graph/draw.ts";
import { fold, openTo } from "../src/graph/fold.ts";
import { place } from "../src/graph/layout.ts";
import { activityColour, barb, level, lettersOn, stroke } from "../src/graph/notation.ts";
import type { Picture } from "../src/graph/picture.ts";
import { elk, NAMES, picture } from "./pictures.ts";

async function drawn(shown: Picture, depth = 9): Promise<string> {
  const layout = await place(fold(shown, openTo(shown, depth)), elk);
  return draw(shown, layout, { theme: "light", legend: true });
}

const count = (text: string, pattern: RegExp): number => (text.match(pattern) ?? []).length;

describe.each(NAMES)("%s", async (name) => {
  const shown = picture(name);
  const text = await drawn(shown);

  test("has every node and bond once, and a stroke on every bond", () => {
    expect(count(text, /data-id="/g)).toBe(shown.nodes.length);
    expect(count(text, /data-bond="/g)).toBe(shown.bonds.length);
    expect(count(text, /class="stroke /g)).toBe(shown.bonds.filter((bond) => bond.effortInto !== undefined).length);
  });

  test("strokes stand where effort goes in", () => {
    for (const bond of shown.bonds) {
      const at = text.indexOf(`data-bond="${bond.name}"`);
      const end = /data-end="(head|tail)"/.exec(text.slice(at))?.[1];
      expect(end, bond.name).toBe(bond.effortInto === bond.head ? "head" : "tail");
    }
  });
});

test("what is gone is told without colour", async () => {
  const whole = picture("quarter_car");
  const wheel = whole.nodes.find((node) => node.path === "wheel");
  const nodes = whole.nodes.map((node) =>
    node === wheel ? { ...node, gone: { sign: "e = 0", meaning: "carries no effort" } } : node,
  );
  const bonds = whole.bonds.map((bond) => (bond.head === "wheel" ? { ...bond, gone: true } : bond));
  const text = await drawn({ ...whole, nodes, bonds });
  const gone = text.slice(text.indexOf('data-id="wheel"'));
  expect(gone.slice(0, gone.indexOf("</g>"))).toContain("stroke-dasharray");
  expect(gone.slice(0, gone.indexOf("</g>"))).toContain("e = 0");
});

test("a bond in conflict is red and crossed, with a stroke or without", async () => {
  const whole = picture("quarter_car");
  const bonds = whole.bonds.map((bond, i) => {
    const { effortInto: _effortInto, ...open } = bond;
    return i === 0 ? { ...bond, causality: "conflict" as const } : i === 1 ? { ...open, causality: "conflict" as const } : bond;
  });
  const text = await drawn({ ...whole, bonds });
  for (const bond of bonds.slice(0, 2)) {
    const own = text.slice(text.indexOf(`data-bond="${bond.name}"`));
    expect(own.slice(0, own.indexOf("</g>"))).toContain('class="cross"');
    expect(own.slice(0, own.indexOf("</g>"))).toContain("#d00000");
  }
  expect(count(text, /class="cross"/g)).toBe(2);
});

test("a closed group sums the activity of what is in it", () => {
  const whole = picture("quarter_car");
  const rows = { "suspension.spring": 0.25, "suspension.damper": 0.5 };
  const visible = fold({ ...whole, activity: { total: 1, rows, bonds: {} } }, new Set([""]));
  const suspension = visible.closed.find((group) => group.path === "suspension");
  expect(suspension?.share).toBe(0.75);
  expect(suspension?.rows).toBe(2);
});

test("text from a model cannot leave its place", async () => {
  const whole = picture("quarter_car");
  const text = await drawn({ ...whole, name: '</title><script>alert("x")</script>' });
  expect(text).not.toContain("<script");
});

test("the barb is on the flow's side: below, or right of an upright line", () => {
  expect(barb({ x: 0, y: 0 }, { x: 50, y: 0 }).y).toBeGreaterThan(0);
  expect(barb({ x: 50, y: 0 }, { x: 0, y: 0 }).y).toBeGreaterThan(0);
  expect(barb({ x: 0, y: 0 }, { x: 0, y: 50 }).x).toBeGreaterThan(0);
  expect(barb({ x: 0, y: 50 }, { x: 0, y: 0 }).x).toBeGreaterThan(0);
});

test("strokes stand across the line", () => {
  const [a, b] = stroke({ x: 0, y: 0 }, { x: 30, y: 40 }, 1.5);
  expect((a.x - b.x) * 30 + (a.y - b.y) * 40).toBeCloseTo(0, 9);
});

test("letters stand out from every fill", () => {
  const luminance = (colour: string): number => {
    const value = parseInt(colour.slice(1), 16);
    const [r, g, b] = [value >> 16, (value >> 8) & 255, value & 255].map((c) =>
      c / 255 <= 0.03928 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4,
    ) as [number, number, number];
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  for (let exponent = -6; exponent <= 0; exponent += 0.05) {
    const fill = activityColour(10 ** exponent);
    const [a, b] = [luminance(fill), luminance(lettersOn(fill))].sort((x, y) => y - x) as [number, number];
    expect((a + 0.05) / (b + 0.05), fill).toBeGreaterThan(4.5);
  }
  expect(level(1)).toBe(1);
  expect(level(1e-9)).toBe(0);
});
