/**
 * The studio in a real browser, served by the command that users have: pages must show what Python says. The folder and what
 * it must show are made by `python -m tests.browser.studio` before.
 */

import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser, BrowserContext, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { launched } from "./chromium.ts";
import { Server, Visitor } from "./server.ts";

interface Drawn {
  readonly nodes: readonly string[];
  readonly strokes: Readonly<Record<string, "head" | "tail">>;
  readonly groups: readonly string[];
}
interface Expected {
  readonly models: Readonly<Record<string, Drawn>>;
  readonly rows: readonly (readonly [string, number])[];
  readonly kept: readonly (readonly [number, number])[];
  /** The speed of the body after every step. */
  readonly step: number;
  readonly values: readonly number[];
  readonly reduction: {
    readonly threshold: number;
    readonly states: readonly [number, number];
    readonly gone: readonly string[];
    readonly outputs: Readonly<Record<string, number>>;
  };
  readonly spike: number;
}

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
const FOLDER = `${ROOT}out/browser/studio`;
const expected = JSON.parse(readFileSync(`${FOLDER}.json`, "utf-8")) as Expected;
const CAR = "quarter_car.py:QuarterCar";
const RUN = `model=${CAR}&scenario=scenario&method=rk4&step=0.001`;

const AXE = readFileSync(fileURLToPath(import.meta.resolve("axe-core")), "utf-8");

let browser: Browser;
let server: Server;
let context: BrowserContext;
let visitor: Visitor;
let page: Page;
let reduction = ""; // the number of the last one

beforeAll(async () => {
  [browser, server] = await Promise.all([launched(), Server.start(FOLDER)]);
  context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
  visitor = await Visitor.at(context, server);
  page = visitor.page;
});
afterAll(async () => {
  await browser.close();
  await server.stop();
  expect(visitor.faults).toEqual([]);
});

/** Run what the form says, and wait until it is over; gives the number of the job. */
async function finished(hash: string): Promise<string> {
  await visitor.open(hash);
  await page.getByRole("button", { name: "Run", exact: true }).click();
  const now = page.locator(".job-now");
  await now.waitFor();
  await page.waitForFunction(() => !["queued", "running"].includes(document.querySelector<HTMLElement>(".job-now")?.dataset.state ?? "queued"));
  return (await now.getAttribute("data-job")) as string;
}

/** The recorded sample of a signal next to a time. */
async function sample(run: string, path: string, at: number): Promise<{ time: number; value: number }> {
  return page.evaluate(
    async ([id, signal, time]) => {
      const answer = await fetch(`/api/runs/${id}/values?signal=${signal}&time=${time}`);
      const found = (await answer.json()) as { time: number; values: Record<string, number> };
      return { time: found.time, value: found.values[signal as string] as number };
    },
    [run, path, at] as const,
  );
}

/** Go to a view, and read the column that it asks for. */
async function column(hash: string, run: string, signal: string): Promise<number[]> {
  const [response] = await Promise.all([
    page.waitForResponse((found) => {
      const url = new URL(found.url());
      return url.pathname === `/api/runs/${run}/series` && url.searchParams.getAll("signal").join(" ") === signal;
    }),
    visitor.open(hash),
  ]);
  return page.evaluate(async (url) => {
    const bytes = await (await fetch(url)).arrayBuffer();
    return [...new Float32Array(bytes, (8 * bytes.byteLength) / 12)];
  }, response.url());
}

describe("start", () => {
  test("offers models, and asks once before it runs a Python file of the folder", async () => {
    await page.waitForSelector('[data-model="truck"]');
    await page.locator(`[data-model="${CAR}"] .name`).click();
    await page.getByRole("dialog").waitFor();
    expect(await page.getByRole("dialog").textContent()).toContain("quarter_car.py");
    await page.getByRole("button", { name: "Do not run it" }).click();
    expect(visitor.hash).not.toContain("model");
    await page.locator(`[data-model="${CAR}"] .name`).click();
    await page.getByRole("button", { name: "Trust this folder" }).click();
    await page.waitForSelector(".graph svg .node");
    await visitor.open("#/");
    await page.locator('[data-model="trouble.py:Shaken"] .name').click();
    await page.waitForSelector(".graph svg .node");
    expect(await page.getByRole("dialog").count()).toBe(0);
  });
});

describe.each(Object.entries(expected.models))("model %s", (model, drawn) => {
  test("has the nodes, bonds and strokes that Python says", async () => {
    await visitor.drawn(`#/model?model=${model}`);
    await page.getByRole("button", { name: "all", exact: true }).click();
    await page.waitForFunction((count) => document.querySelectorAll(".graph .node").length === count, drawn.nodes.length);
    const found = await page.evaluate(() => ({
      nodes: [...document.querySelectorAll<SVGElement>(".graph .node")].map((node) => node.dataset.id).sort(),
      strokes: Object.fromEntries(
        [...document.querySelectorAll<SVGElement>(".graph [data-bond]")].map((bond) => [
          bond.dataset.bond,
          [...bond.querySelectorAll<SVGElement>(".stroke")].map((stroke) => stroke.dataset.end).join(" "),
        ]),
      ),
      // The barb leaves the end of the line that the half arrow points to.
      barbs: [...document.querySelectorAll<SVGElement>(".graph [data-bond]")].filter((bond) => {
        const numbers = (of: string): number[] => (bond.querySelector(of)?.getAttribute("d")?.match(/-?[\d.]+/g) ?? []).map(Number);
        const [line, barb] = [numbers(".line"), numbers(".barb")];
        return Math.hypot((line.at(-2) ?? 0) - (barb[0] ?? 1e9), (line.at(-1) ?? 0) - (barb[1] ?? 1e9)) > 0.1;
      }).length,
    }));
    expect(found.nodes).toEqual(drawn.nodes);
    expect(found.strokes).toEqual(drawn.strokes);
    expect(found.barbs).toBe(0);
  });

  test.each(["nothing", "one level", "two levels", "all"])("open to %s, nothing overlaps and labels are inside", async (depth) => {
    await page.getByRole("button", { name: depth, exact: true }).click();
    await page.waitForTimeout(700);
    const bad = await page.evaluate(() => {
      const boxOf = (node: Element): DOMRect | undefined => node.querySelector<SVGGraphicsElement>("rect")?.getBBox() as DOMRect | undefined;
      const things = [...document.querySelectorAll<SVGElement>(".graph .node, .graph .closed")];
      const boxes = things.map((thing) => [thing.dataset.id ?? thing.dataset.group, boxOf(thing)] as const).filter((pair): pair is readonly [string, DOMRect] => pair[1] !== undefined);
      const found: string[] = [];
      boxes.forEach(([name, a], i) => {
        for (const [other, b] of boxes.slice(i + 1)) {
          if (a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height) found.push(`${name} over ${other}`);
        }
      });
      for (const thing of things) {
        const [box, text] = [boxOf(thing), thing.querySelector<SVGGraphicsElement>("text")?.getBBox()];
        if (box !== undefined && text !== undefined && (text.x < box.x - 0.5 || text.x + text.width > box.x + box.width + 0.5)) found.push(`label of ${thing.dataset.id}`);
      }
      return found;
    });
    expect(bad).toEqual([]);
  });

  test("labels are at least 10 px high in the view that it opens with", async () => {
    await visitor.open("#/");
    await page.waitForSelector(".cards");
    await visitor.drawn(`#/model?model=${model}`);
    const least = await page.evaluate(() => {
      const svg = document.querySelector<SVGSVGElement>(".graph svg") as SVGSVGElement;
      const scale = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
      const texts = [...svg.querySelectorAll(".node > text:first-of-type, .closed > text:first-of-type")];
      return Math.min(...texts.map((text) => Number(text.getAttribute("font-size")) * scale));
    });
    expect(least).toBeGreaterThanOrEqual(10);
  });
});

describe("the view of a model", () => {
  test("groups close and open: the address changes, Back restores, loading anew gives the same drawing", async () => {
    await visitor.drawn("#/model?model=half-car&theme=light");
    const first = visitor.hash;
    const group = page.locator(".tree [aria-level='1'][aria-expanded='true']").first();
    const path = (await group.getAttribute("data-key")) as string;
    await page.locator(`.graph .group[data-group="${path}"] > text`).click();
    await page.waitForSelector(`.graph .closed[data-group="${path}"]`);
    const closed = visitor.hash;
    expect(closed).not.toBe(first);
    await page.goBack();
    await page.waitForSelector(`.graph .group[data-group="${path}"]`);
    await page.goForward();
    await page.waitForSelector(`.graph .closed[data-group="${path}"]`);
    const drawing = (): Promise<string> => page.locator(".graph .page svg").evaluate((svg) => svg.innerHTML.replace(/ (tabindex|class)="[^"]*"/g, ""));
    const before = await drawing();
    await page.reload();
    await page.waitForSelector("body[data-ready] .graph svg .node");
    expect(visitor.hash).toBe(closed);
    expect(await drawing()).toBe(before);
  });

  test("a click on a count marks its elements", async () => {
    await visitor.drawn(`#/model?model=${CAR}`);
    await page.locator('[data-count="inertias"]').click();
    await page.waitForSelector(".graph .marked");
    const marked = await page.evaluate(() => [...document.querySelectorAll<SVGElement>(".graph .node.marked")].map((node) => node.dataset.id));
    expect(marked.sort()).toEqual(["body", "wheel"]);
    await page.waitForFunction(() => location.hash.includes("mark=inertias"));
  });

  test("an element is found by /, shown in graph and tree, and its law and parameters are told", async () => {
    await visitor.drawn("#/model?model=half-car&open=");
    await page.locator("main").focus();
    await page.keyboard.press("/");
    await page.keyboard.type("front tyre spring");
    await page.keyboard.press("Enter");
    await page.waitForSelector('.graph .node.chosen[data-id="front.tyre.spring"]');
    expect(await page.locator('.tree [aria-selected="true"]').getAttribute("data-key")).toBe("front.tyre.spring");
    const details = await page.locator(".details").textContent();
    expect(details).toContain("front.tyre.spring");
    expect(details).toMatch(/\.py:\d+/);
    expect(await page.locator(".details [data-parameter]").count()).toBeGreaterThan(0);
    await page.locator("main").focus();
    await page.keyboard.press("Escape");
    await page.waitForFunction(() => document.querySelectorAll(".graph .chosen").length === 0);
  });

  test("equations and parameters are listed and searched", async () => {
    await visitor.drawn(`#/model?model=${CAR}`);
    await page.getByRole("tab", { name: "Equations" }).click();
    await page.waitForSelector(".equations");
    expect(await page.locator(".equations").textContent()).toContain("suspension");
    await page.getByRole("tab", { name: "Parameters" }).click();
    await page.getByLabel("Find in the parameters").fill("tyre stiffness");
    expect(await page.locator("table.parameters [data-parameter]").allTextContents()).toHaveLength(
      await page.locator('table.parameters [data-parameter*="tyre"]').count(),
    );
  });
});

describe("runs", () => {
  test("go to their end, and their signals are what Python has", async () => {
    const id = await finished(`#/run?${RUN}`);
    expect(await page.locator(".job-now").getAttribute("data-state")).toBe("complete");
    await page.waitForSelector(".job-now .lane canvas");
    for (const wanted of [0.6, 2.5, 7.25]) {
      const { time, value } = await sample(id, "body.flange.flow", wanted);
      expect(time).toBeCloseTo(wanted, 1);
      expect(value).toBeCloseTo(expected.values[Math.round(time / expected.step)] as number, 6);
    }
  });

  test("progress never falls, a page loaded anew picks the run up, cancel keeps what there is", async () => {
    await visitor.open("#/run?model=trouble.py:Shaken&scenario=endless");
    await page.getByRole("button", { name: "Run", exact: true }).click();
    const times: number[] = [];
    const look = async (): Promise<void> => {
      for (let i = 0; i < 8; i++) {
        times.push(Number(await page.locator("dd[data-time]").getAttribute("data-time")));
        await page.waitForTimeout(150);
      }
    };
    await page.waitForSelector("dd[data-time]");
    await look();
    await page.reload();
    await page.waitForSelector('.job-now[data-state="running"] dd[data-time]');
    await look();
    expect(times).toEqual([...times].sort((a, b) => a - b));
    expect(times.at(-1)).toBeGreaterThan(times[0] as number);
    await page.locator(".job-now").getByRole("button", { name: "Cancel" }).click();
    await page.waitForSelector('.job-now[data-state="cancelled"]');
    const least = await page.evaluate(async () => {
      const id = document.querySelector<HTMLElement>(".job-now")?.dataset.job;
      const answer = await fetch(`/api/runs/${id}/series?signal=mass.flange.flow&from=0&to=1&count=10`);
      return Math.max(...new Float32Array((await answer.arrayBuffer()).slice(160)));
    });
    expect(least).toBeGreaterThan(0);
  });

  test("one that fails says why, and marks the element in the graph", async () => {
    await finished("#/run?model=trouble.py:Breaking&scenario=hard_pull");
    expect(await page.locator(".job-now").getAttribute("data-state")).toBe("failed");
    expect(await page.locator(".job-now [role=alert]").textContent()).toContain("mass.momentum is no longer a finite number");
    await page.waitForSelector('.job-now .node.marked[data-id="mass"]');
  });
});

describe("plots", () => {
  test("a spike of one sample is in the drawn data at every zoom", async () => {
    const id = await finished("#/run?model=trouble.py:Shaken&scenario=bump");
    const table = await page.evaluate(async (run) => (await fetch(`/api/runs/${run}/csv?signal=road.flow`)).text(), id);
    const samples = table.trim().split("\n").map((line) => Number(line.split(",")[1])).filter(Number.isFinite);
    const highest = Math.max(...samples);
    expect(highest).toBeGreaterThan(expected.spike / 2);
    expect(samples.filter((value) => value > highest / 2).length).toBeLessThanOrEqual(4);
    for (const zoom of ["", "&from=2&to=12", "&from=4.9&to=5.1"]) {
      const values = await column(`#/plots?run=${id}&signal=road.flow${zoom}`, id, "road.flow");
      expect(Math.max(...values)).toBeCloseTo(highest, 5);
    }
  });

  test("a drag zooms all lanes together, a double click shows everything again", async () => {
    const id = await finished(`#/run?${RUN}`);
    await visitor.open(`#/plots?run=${id}&signal=body.flange.flow&signal=wheel.flange.flow`);
    await page.waitForFunction(() => document.querySelectorAll(".lane canvas").length === 2);
    const over = (await page.locator(".lane .u-over").first().boundingBox()) as { x: number; y: number; width: number; height: number };
    await page.mouse.move(over.x + over.width * 0.25, over.y + 40);
    await page.mouse.down();
    await page.mouse.move(over.x + over.width * 0.5, over.y + 40, { steps: 5 });
    await page.mouse.up();
    await page.waitForFunction(() => location.hash.includes("from="));
    const words = new URLSearchParams(visitor.hash.split("?")[1]);
    expect(Number(words.get("from"))).toBeCloseTo(2.5, 1);
    expect(Number(words.get("to"))).toBeCloseTo(5, 1);
    await page.waitForTimeout(400);
    // Both lanes ask for the same part of the time.
    const asked = visitor.asked.filter((url) => url.includes("/series")).at(-1) as string;
    expect(asked).toContain("body.flange.flow");
    expect(asked).toContain("wheel.flange.flow");
    expect(Number(new URL(asked).searchParams.get("from"))).toBeCloseTo(2.5, 1);
    await page.locator(".lane .u-over").nth(1).dblclick({ position: { x: 100, y: 40 } });
    await page.waitForFunction(() => !location.hash.includes("from="));
  });

  test("values at the cursor are samples of the run", async () => {
    const strip = page.locator(".strip");
    await strip.focus();
    await page.keyboard.press("ArrowRight");
    await page.waitForTimeout(600);
    const time = parseFloat((await page.locator("output.time").textContent()) as string);
    const shown = parseFloat((await page.locator(".lane output").first().textContent()) as string);
    const run = new URLSearchParams(visitor.hash.split("?")[1]).get("run") as string;
    expect(shown).toBeCloseTo((await sample(run, "body.flange.flow", time)).value, 4);
  });

  test("sixty signals are drawn, and texts of axes have room", async () => {
    const id = await finished("#/run?model=half-car&until=2");
    const paths = await page.evaluate(async (run) => {
      const answer = await fetch(`/api/runs/${run}/signals`);
      return ((await answer.json()) as { path: string }[]).slice(0, 60).map((entry) => entry.path);
    }, id);
    expect(paths.length).toBe(60);
    await visitor.open(`#/plots?run=${id}&${paths.map((path) => `signal=${path}`).join("&")}`);
    await page.waitForFunction(() => document.querySelectorAll(".lane").length === 60);
    await page.waitForSelector(".lane canvas");
    expect(await page.locator(".lane-title").allTextContents()).toHaveLength(60);
  });

  test("runs laid over one another differ by pen", async () => {
    await visitor.open("#/start");
    const ids = await page.evaluate(async (model) => {
      const jobs = (await (await fetch("/api/jobs")).json()) as { id: string; model: string; state: string }[];
      return jobs.filter((job) => job.model === model && job.state === "complete").map((job) => job.id);
    }, CAR);
    expect(ids.length).toBeGreaterThanOrEqual(2);
    await visitor.open(`#/plots?run=${ids[0]}&run=${ids[1]}&signal=body.flange.flow`);
    await page.waitForSelector(".lane canvas");
    const dashes = await page.locator(".lane .pen line").evaluateAll((lines) => lines.map((line) => line.getAttribute("stroke-dasharray")));
    expect(new Set(dashes).size).toBe(2);
  });
});

describe("activity and reduction", () => {
  const kept = async (): Promise<number> => Number(await page.locator("output[data-kept]").getAttribute("data-kept"));
  let run: string;

  beforeAll(async () => {
    run = await finished(`#/run?${RUN}`);
    await visitor.drawn(`#/activity?run=${run}`);
  });

  test("a run is ranked as Python ranks it", async () => {
    const found = await page.locator("tbody tr[data-row]").evaluateAll((rows) => rows.map((row) => [(row as HTMLElement).dataset.row, Number((row as HTMLElement).dataset.activity)] as const));
    expect(found.map(([path]) => path)).toEqual(expected.rows.map(([path]) => path));
    found.forEach(([, activity], i) => expect(activity / (expected.rows[i] as [string, number])[1]).toBeCloseTo(1, 6));
  });

  test("the slider keeps at every place what Python keeps, and never less for more", async () => {
    const found: [number, number][] = [];
    for (const [threshold] of expected.kept) {
      await visitor.page.evaluate((value) => (location.hash = location.hash.replace(/&threshold=[^&]*|$/, `&threshold=${value}`)), threshold);
      await page.waitForTimeout(40);
      found.push([threshold, await kept()]);
    }
    expect(found).toEqual(expected.kept);
    expect(found.map(([, count]) => count)).toEqual(found.map(([, count]) => count).sort((a, b) => a - b));
    const [last] = await page.locator(".bars .bar:not(.below)").evaluateAll((bars) => bars.slice(-1).map((bar) => (bar as SVGElement).dataset.row));
    expect(last).toBe(expected.rows[(await kept()) - 1]?.[0]);
  });

  test("the line and the slider are one, and arrow keys move an element at a time", async () => {
    await visitor.drawn(`#/activity?run=${run}&threshold=0.9`);
    const before = await kept();
    await page.locator("#threshold").focus();
    await page.keyboard.press("ArrowLeft");
    expect(await kept()).toBe(before - 1);
    await page.keyboard.press("ArrowRight");
    expect(await kept()).toBe(before);
    const box = (await page.locator(".bars").boundingBox()) as { x: number; y: number; width: number; height: number };
    const y = (share: number): number => box.y + box.height * ((12 + (230 - 12 - 24) * (1 - share)) / 230);
    const at = (await page.locator("#threshold").inputValue()) as string;
    await page.mouse.move(box.x + box.width / 2, y(1 - (1 - Number(at)) ** 2));
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2, y(0.5), { steps: 4 });
    await page.mouse.up();
    const dragged = expected.kept.find(([threshold]) => threshold === 0.5)?.[1];
    expect(await kept()).toBe(dragged);
    expect(1 - (1 - Number(await page.locator("#threshold").inputValue())) ** 2).toBeCloseTo(0.5, 1);
  });

  test("a bar selects its element in the graph and draws what it did; its power adds up to its activity", async () => {
    await visitor.drawn(`#/activity?run=${run}&open=`);
    const [path, activity] = expected.rows[0] as [string, number];
    await page.locator(`.bars [data-row="${path}"]`).click();
    await page.waitForSelector(".graph .node.chosen");
    await page.waitForSelector(".histories .lane canvas");
    const titles = (await page.locator(".histories .lane-title").allTextContents()).map((title) => title.split(" ")[0]);
    expect(titles).toEqual(["effort", "flow", "power", "activity"]);
    const [drawnActivity] = await page.evaluate(async ([id, row]) => {
      const answer = await fetch(`/api/runs/${id}/history?row=${row}`);
      const { times, items } = (await answer.json()) as { times: string; items: { power: string }[] };
      const numbers = (text: string): Float32Array => new Float32Array(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
      return items.map(({ power }) => {
        const [t, p] = [numbers(times), numbers(power)];
        let sum = 0;
        for (let i = 1; i < t.length; i++) sum += (Math.abs(p[i] as number) + Math.abs(p[i - 1] as number)) * 0.5 * ((t[i] as number) - (t[i - 1] as number));
        return sum;
      });
    }, [run, path] as const);
    // Least and greatest values of few intervals: near, not exact.
    expect((drawnActivity as number) / activity).toBeGreaterThan(0.9);
    expect((drawnActivity as number) / activity).toBeLessThan(1.1);
    const strip = page.locator(".histories .strip");
    await strip.focus();
    for (let i = 0; i < 60; i++) await page.keyboard.press("Shift+ArrowRight");
    const shown = (await page.locator(".histories .lane").last().locator("output").textContent()) as string;
    expect(parseFloat(shown) / activity).toBeCloseTo(1, 3);
  });

  test("a part of the run is ranked without asking the server, as Python ranks it", async () => {
    await visitor.drawn(`#/activity?run=${run}`);
    const before = visitor.asked.length;
    await page.evaluate(() => (location.hash = location.hash + "&from=2.5&to=7.5"));
    await page.waitForFunction(() => !document.querySelector<HTMLButtonElement>(".window button")?.disabled);
    await page.waitForFunction(() => location.hash.includes("from="));
    const found = await page.locator("tbody tr[data-row]").evaluateAll((rows) => rows.map((row) => [(row as HTMLElement).dataset.row, Number((row as HTMLElement).dataset.activity)] as const));
    expect(visitor.asked.length).toBe(before);
    const [from, to] = ((await page.locator("output[for='from to']").textContent()) as string).match(/[\d.]+/g) as [string, string];
    const told = execFileSync(`${ROOT}.venv/bin/python`, ["-m", "tests.browser.studio", "window", from, to], { cwd: ROOT, encoding: "utf-8" });
    const rows = JSON.parse(told) as [string, number][];
    expect(found.map(([path]) => path)).toEqual(rows.map(([path]) => path));
    found.forEach(([, activity], i) => expect(activity / (rows[i] as [string, number])[1]).toBeCloseTo(1, 6));
  });

  test("a locked element stays at every threshold, and what goes is told without colour", async () => {
    await visitor.drawn(`#/activity?run=${run}&threshold=0.5&open=suspension,tyre`);
    const least = (expected.rows.at(-1) as [string, number])[0];
    await page.getByRole("button", { name: `keep ${least} at every threshold` }).click();
    await page.waitForFunction(() => location.hash.includes("keep="));
    for (const threshold of [0.5, 0.9, 0.99]) {
      await page.evaluate((value) => (location.hash = location.hash.replace(/threshold=[^&]*/, `threshold=${value}`)), threshold);
      await page.waitForTimeout(60);
      expect(await page.locator(`.bars .bar[data-row="${least}"]`).getAttribute("class")).not.toContain("below");
      await page.waitForFunction((row) => document.querySelector(`.graph .node[data-row="${row}"]`)?.classList.contains("gone") === false, least);
    }
    await page.evaluate(() => (location.hash = location.hash.replace(/threshold=[^&]*/, "threshold=0.5")));
    await page.waitForSelector(".graph .node.gone");
    const plain = await page.locator(".graph .node.gone").evaluateAll((nodes) => nodes.filter((node) => !node.querySelector("rect")?.hasAttribute("stroke-dasharray")).length);
    expect(plain).toBe(0);
  });

  test("the reduced model is built and compared, with the numbers of Python", async () => {
    const outputs = Object.keys(expected.reduction.outputs);
    await visitor.drawn(`#/activity?run=${run}&threshold=${expected.reduction.threshold}&${outputs.map((path) => `output=${path}`).join("&")}`);
    await page.getByRole("button", { name: "Build reduced model" }).click();
    await page.waitForSelector('[data-screen="compare"]');
    await page.waitForSelector("table.outputs [data-output]");
    reduction = new URLSearchParams(visitor.hash.split("?")[1]).get("reduction") as string;
    const facts = await page.locator(".fact").allTextContents();
    expect(facts.join(" ")).toContain(`${expected.reduction.states[0]} → ${expected.reduction.states[1]}`);
    const errors = await page.locator("table.outputs [data-output]").evaluateAll((rows) =>
      Object.fromEntries(rows.map((row) => [(row as HTMLElement).dataset.output, Number((row.children[1] as HTMLElement).dataset.value)])),
    );
    for (const [path, rms] of Object.entries(expected.reduction.outputs)) expect(errors[path], path).toBeCloseTo(rms, 6);
    await page.waitForFunction(() => document.querySelectorAll(".beside .page svg").length === 2);
    const gone = await page.locator(".beside .graph-box").nth(1).locator(".node.gone").evaluateAll((nodes) => nodes.map((node) => (node as SVGElement).dataset.row).sort());
    expect(gone).toEqual(expected.reduction.gone);
    expect(await page.locator(".beside .graph-box").nth(0).locator(".node.gone").count()).toBe(0);
    await page.waitForSelector('#courses, .lane[data-lane^="difference"]');
    const keys = await page.locator(".lane").evaluateAll((lanes) => lanes.map((lane) => (lane as HTMLElement).dataset.lane?.split(" ")[0]));
    expect(keys).toEqual(outputs.flatMap(() => ["values", "difference"]));
    expect(await page.locator("td.passes, td.fails").count()).toBe(outputs.length);
    const [report] = await Promise.all([page.waitForEvent("download"), page.getByRole("link", { name: "Download the report" }).click()]);
    expect(report.suggestedFilename()).toMatch(/\.html$/);
  });

  test("the Python of every screen is shown", async () => {
    for (const hash of [`#/model?model=${CAR}`, `#/run?${RUN}`, `#/plots?run=${run}&signal=body.flange.flow`, `#/activity?run=${run}`]) {
      await visitor.open(hash);
      await page.getByRole("button", { name: "Show the Python for this" }).click();
      await page.waitForSelector("pre.python");
      expect(await page.locator("pre.python").textContent()).toContain("import propermodel as pm");
      await page.keyboard.press("Escape");
      await page.waitForSelector("dialog", { state: "detached" });
    }
  });
});

test("from start to comparison by keys alone", async () => {
  /** Go on with the tabulator until something of this name has the focus. */
  const reach = async (name: string): Promise<void> => {
    for (let i = 0; i < 150; i++) {
      await page.keyboard.press("Tab");
      const here = await page.evaluate(() => {
        const { activeElement } = document;
        const isSeen = activeElement !== null && getComputedStyle(activeElement).visibility !== "hidden";
        return isSeen ? (activeElement?.getAttribute("aria-label") ?? activeElement?.textContent ?? "") : "";
      });
      if (here.trim() === name) return;
    }
    throw new Error(`'${name}' cannot be reached`);
  };
  await visitor.open("#/");
  await page.waitForSelector(".cards");
  await reach("QuarterCar");
  await page.keyboard.press("Enter");
  await page.waitForSelector(".graph svg .node");
  await reach("Run");
  await page.keyboard.press("Enter");
  await page.waitForSelector(".run-form .preview, .run-form .hint");
  await reach("Run");
  if (await page.evaluate(() => document.activeElement?.matches("a") === true)) await reach("Run");
  await page.keyboard.press("Enter");
  await page.waitForSelector('.job-now[data-state="complete"]');
  await reach("Activity");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#threshold");
  await reach("Build reduced model");
  await page.keyboard.press("Enter");
  await page.waitForSelector("table.outputs [data-output]");
});

/** Every screen, as it is looked at before a release. */
const SCREENS: readonly (readonly [string, () => string, string])[] = [
  ["start", () => "#/", ".cards"],
  ["model", () => "#/model?model=truck", ".graph svg .node, .graph svg .closed"],
  ["details", () => "#/model?model=half-car&selected=front.tyre.spring&mark=inertias", ".graph svg .node.chosen"],
  ["equations", () => "#/model?model=half-car&tab=equations", ".equations"],
  ["parameters", () => "#/model?model=half-car&tab=parameters", "table.parameters"],
  ["run", () => `#/run?${RUN}`, ".run-form"],
  ["plots", () => `#/plots?model=${CAR}`, ".lane canvas"],
  ["activity", () => `#/activity?model=${CAR}&threshold=0.9&selected=suspension.damper`, ".histories .lane canvas"],
  ["compare", () => `#/compare?reduction=${reduction}`, "table.outputs"],
];

describe.each(["light", "dark"])("%s screens", (theme) => {
  test.each(SCREENS)("%s can be used by everybody", async (name, hash, there) => {
    const address = hash();
    await visitor.open(`${address}${address.includes("?") ? "&" : "?"}theme=${theme}`);
    await page.waitForSelector(there);
    await page.waitForTimeout(500);
    // The page runs only its own scripts; the test's comes from the browser, past that rule.
    await page.evaluate(AXE);
    const found = await page.evaluate(async () => {
      const axe = (window as unknown as { axe: { run(): Promise<{ violations: { id: string; impact: string; nodes: { html: string }[] }[] }> } }).axe;
      return (await axe.run()).violations;
    });
    const serious = found.filter(({ impact }) => impact === "serious" || impact === "critical");
    expect(serious.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html.slice(0, 160)).join(" ")}`)).toEqual([]);
    for (const [width, height] of [[1280, 800], [1920, 1080]] as const) {
      await page.setViewportSize({ width, height });
      await page.waitForTimeout(200);
      await page.screenshot({ path: `${ROOT}out/browser/screens/${name}_${theme}_${width}.png` });
    }
    await page.setViewportSize({ width: 1280, height: 800 });
  });
});
