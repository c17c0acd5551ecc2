import { describe, expect, test } from "vitest";
import { axisUnit, duration, significant } from "../src/views/format.ts";
import { between } from "../src/views/history.tsx";
import { lanesOf } from "../src/views/lanes.tsx";
import { csv } from "../src/views/saving.ts";
import { ticks } from "../src/views/strip.ts";
import { unpacked } from "../src/studio/client.ts";
import { usualSignals } from "../src/studio/signals.ts";
import { branchesOf } from "../src/studio/tree.tsx";
import { usualDepth } from "../src/views/choices.ts";
import { picture } from "./pictures.ts";

describe("numbers", () => {
  test("axes have prefixes, or powers of ten where a unit takes none", () => {
    expect(axisUnit(20e6, "Pa")).toEqual({ text: "MPa", factor: 1e6 });
    expect(axisUnit(1000, "J")).toEqual({ text: "kJ", factor: 1e3 });
    expect(axisUnit(0.02, "m")).toEqual({ text: "mm", factor: 1e-3 });
    expect(axisUnit(250, "rad/s")).toEqual({ text: "rad/s", factor: 1 });
    expect(axisUnit(3e7, "Pa.s/m3")).toEqual({ text: "10⁶ Pa.s/m3", factor: 1e6 });
    expect(axisUnit(2e-4, "m3/s")).toEqual({ text: "10⁻⁶ m3/s", factor: 1e-6 });
    expect(axisUnit(0, "N")).toEqual({ text: "N", factor: 1 });
    expect(axisUnit(350, "bar")).toEqual({ text: "bar", factor: 1 });
  });

  test("values and durations are short", () => {
    expect(significant(-1234567, "W")).toBe("-1.235 MW");
    expect(significant(0.5, "")).toBe("0.5");
    expect(duration(3.21)).toBe("3.2 s");
    expect(duration(200)).toBe("3 min 20 s");
    expect(duration(null)).toBe("–");
  });

  test("ticks are round and inside", () => {
    expect(ticks(0, 10, 5)).toEqual([0, 2, 4, 6, 8, 10]);
    expect(ticks(-0.3, 0.35, 4).map((tick) => Number(tick.toPrecision(6)))).toEqual([-0.2, 0, 0.2]);
  });
});

test("an activity between instants lies on straight lines, and ends where it ends", () => {
  expect([...between([0, 1, 3], [0, 10, 30], [0, 0.5, 2, 3])]).toEqual([0, 5, 20, 30]);
});

describe("lanes", () => {
  const groups = [{ title: "speed", unit: "km/h", signals: [{ path: "a", label: "front", factor: 3.6 }, { path: "b", label: "rear", factor: 3.6 }] }];
  const runs = [{ id: "1", name: "full" }, { id: "2", name: "reduced" }];

  test("tell runs by pens and signals by colours", () => {
    const [lane] = lanesOf(groups, runs, undefined);
    expect(lane?.lines.map((line) => [line.run, line.path, line.colour])).toEqual([["1", "a", 1], ["1", "b", 2], ["2", "a", 1], ["2", "b", 2]]);
    expect(lane?.lines[0]?.dash).toEqual([]);
    expect(lane?.lines[2]?.dash).not.toEqual([]);
  });

  test("have their difference below", () => {
    const [, below] = lanesOf(groups, runs, "difference");
    expect(below?.title).toBe("difference");
    expect(below?.lines.map((line) => line.run)).toEqual(["difference", "difference"]);
  });
});

test("columns of the server are instants, then one column for each signal", () => {
  const bytes = new ArrayBuffer(4 * 8 + 2 * 4 * 4);
  new Float64Array(bytes, 0, 4).set([0, 0.5, 1, 1.5]);
  new Float32Array(bytes, 32, 4).set([1, 2, 3, 4]);
  new Float32Array(bytes, 48, 4).set([5, 6, 7, 8]);
  const { times, columns } = unpacked(bytes, ["a", "b"]);
  expect([...Array.from(times)]).toEqual([0, 0.5, 1, 1.5]);
  expect(Array.from(columns.get("b") ?? [])).toEqual([5, 6, 7, 8]);
});

test("paths make a tree of their parts", () => {
  const tree = branchesOf([{ path: "a.b.x", note: "N" }, { path: "a.y", note: "m" }, { path: "z", note: "" }]);
  expect(tree.map((one) => one.key)).toEqual(["a.", "z"]);
  expect(tree[0]?.children.map((one) => one.key)).toEqual(["a.b.", "a.y"]);
  expect(tree[0]?.children[0]?.children[0]).toMatchObject({ key: "a.b.x", label: "x", note: "N" });
});

test("without outputs, inertias show their flow and compliances their effort", () => {
  const entry = (path: string) => [path, { path, unit: "", display: { unit: "", factor: 1 } }] as const;
  const car = picture("quarter_car");
  const ends = car.bonds.flatMap(({ name }) => [`${name}.effort`, `${name}.flow`]);
  const known = new Map(["other", ...ends].map(entry));
  expect(usualSignals(["other", "missing"], car, known)).toEqual(["other"]);
  const found = usualSignals([], car, known);
  expect(found).toHaveLength(4);
  expect(found.map((path) => path.split(".").at(-1))).toEqual(["flow", "flow", "effort", "effort"]);
});

test("cells of a table are quoted where they must be", () => {
  expect(csv([["a", 'b "c"', "d,e"]])).toBe('a,"b ""c""","d,e"\n');
});

test("a small picture is open at first, a large one as far as it can be read", () => {
  expect(usualDepth(picture("quarter_car"))).toBe(2);
  expect(usualDepth(picture("truck"))).toBe(0);
});
