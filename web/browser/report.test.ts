/**
 * The report in a real browser, with no network: it must show what Python says. The pages and what they must tell are made by
 * `python -m tests.browser.pages` before.
 */

import { readFileSync, statSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { launched } from "./chromium.ts";
import { FOLDER, opened } from "./pages.ts";

interface Expected {
  readonly nodes: number;
  readonly strokes: Readonly<Record<string, "head" | "tail">>;
  readonly kept: readonly (readonly [number, number])[];
  readonly gone: Readonly<Record<string, string>>;
  readonly outputs: readonly string[];
  readonly window: { readonly from: number; readonly to: number; readonly rows: readonly (readonly [string, number])[] };
}

let browser: Browser;

beforeAll(async () => {
  browser = await launched();
});
afterAll(async () => browser.close());

async function ready(name: string, faults: string[], hash = ""): Promise<Page> {
  const page = await opened(browser, name, faults, hash);
  await page.waitForSelector("body[data-ready]", { timeout: 60_000 });
  return page;
}

describe.each(["quarter_car", "truck"])("%s", (name) => {
  const file = new URL(`${name}.html`, FOLDER);
  const expected = JSON.parse(readFileSync(new URL(`${name}.json`, FOLDER), "utf-8")) as Expected;
  const faults: string[] = [];
  let page: Page;

  beforeAll(async () => {
    page = await ready(name, faults, "#open=" + (name === "quarter_car" ? "suspension,tyre" : ""));
  });
  afterAll(async () => {
    await page.close();
    expect(faults).toEqual([]);
  });

  test("is one file of less than 2 MB", () => {
    expect(statSync(fileURLToPath(file)).size).toBeLessThan(2e6);
  });

  test("strokes stand where Python says", async () => {
    await page.getByRole("button", { name: "all", exact: true }).click();
    await page.waitForFunction((count) => document.querySelectorAll(".node").length === count, expected.nodes);
    const ends = await page.evaluate(() =>
      Object.fromEntries(
        [...document.querySelectorAll<SVGElement>("[data-bond]")].map((bond) => [
          bond.dataset.bond,
          bond.querySelector<SVGElement>(".stroke")?.dataset.end,
        ]),
      ),
    );
    expect(ends).toEqual(expected.strokes);
  });

  test("labels are inside their boxes as the browser draws them", async () => {
    const outside = await page.evaluate(() =>
      [...document.querySelectorAll<SVGGraphicsElement>(".node")]
        .filter((node) => {
          const box = node.querySelector<SVGGraphicsElement>("rect")?.getBBox();
          const text = node.querySelector<SVGGraphicsElement>("text")?.getBBox();
          return box !== undefined && text !== undefined && (text.x < box.x - 0.5 || text.x + text.width > box.x + box.width + 0.5);
        })
        .map((node) => node.dataset.id),
    );
    expect(outside).toEqual([]);
  });

  test("what is gone has a sign and a dashed outline", async () => {
    const signs = await page.evaluate(() =>
      Object.fromEntries(
        [...document.querySelectorAll<SVGElement>(".node.gone")].map((node) => [
          node.dataset.id,
          [...node.querySelectorAll("text")].at(-1)?.textContent,
        ]),
      ),
    );
    expect(signs).toEqual(expected.gone);
    const plain = await page.evaluate(
      () => [...document.querySelectorAll(".node.gone rect:first-of-type")].filter((box) => !box.hasAttribute("stroke-dasharray")).length,
    );
    expect(plain).toBe(0);
  });

  test("the slider keeps at every place what Python keeps", async () => {
    const found: [number, number][] = [];
    for (const [threshold] of expected.kept) {
      const kept = await page.evaluate((value) => {
        location.hash = `#shown=threshold&threshold=${value}`;
        return new Promise<number>((resolve) =>
          setTimeout(() => resolve(Number(document.querySelector<HTMLElement>("output[data-kept]")?.dataset.kept)), 30),
        );
      }, threshold);
      found.push([threshold, kept]);
    }
    expect(found).toEqual(expected.kept);
  });

  test("a window is ranked as Python ranks it", async () => {
    const { from, to, rows } = expected.window;
    await page.evaluate((hash) => (location.hash = hash), `#from=${from}&to=${to}`);
    await page.waitForFunction(() => !document.querySelector<HTMLButtonElement>(".window button")?.disabled);
    const found = await page.evaluate(() =>
      [...document.querySelectorAll("tbody tr[data-row]")].map((row) => [
        (row as HTMLElement).dataset.row,
        Number((row as HTMLElement).dataset.activity),
      ]),
    );
    expect(found.map(([path]) => path)).toEqual(rows.map(([path]) => path));
    found.forEach(([, activity], i) => expect(activity).toBeCloseTo((rows[i] as [string, number])[1], 6));
    await page.locator(".window button").click();
  });

  test("an element shows effort, flow and power at its ports, and its activity", async () => {
    await page.locator("tbody button").first().click();
    await page.waitForSelector(".histories .lane-title");
    const titles = (await page.locator(".histories .lane-title").allTextContents()).map((title) => title.split(" ")[0]);
    expect(titles.slice(0, 3)).toEqual(["effort", "flow", "power"]);
    expect(titles.at(-1)).toBe("activity");
  });

  test("arrow keys move one element at a time", async () => {
    const count = async (): Promise<number> => Number(await page.locator("output[data-kept]").getAttribute("data-kept"));
    await page.evaluate(() => (location.hash = "#shown=threshold&threshold=0.9"));
    await page.locator("#threshold").focus();
    const before = await count();
    await page.keyboard.press("ArrowLeft");
    expect(await count()).toBe(before - 1);
    await page.keyboard.press("ArrowRight");
    expect(await count()).toBe(before);
  });

  test("a chosen row is shown in the graph, whose groups open for it", async () => {
    await page.getByRole("button", { name: "nothing", exact: true }).click();
    await page.locator("tbody button").nth(1).click();
    await page.waitForSelector(".graph .chosen");
    const row = await page.locator("tbody button").nth(1).textContent();
    expect(await page.locator(".element h3").textContent()).toContain(row);
  });

  test("groups close and open, and the address holds what is open", async () => {
    await page.getByRole("button", { name: "nothing", exact: true }).click();
    const group = page.locator(".closed").first();
    await group.waitFor();
    const path = (await group.getAttribute("data-group")) as string;
    await group.click();
    await page.waitForSelector(`.group[data-group="${path}"]`);
    expect(new URL(page.url()).hash).toContain(path);
    const again = await ready(name, faults, new URL(page.url()).hash);
    expect(await again.locator(`.group[data-group="${path}"]`).count()).toBe(1);
    await again.close();
  });

  test("labels of the usual view are at least 10 px high", async () => {
    await page.getByRole("button", { name: "one level" }).click();
    await page.waitForTimeout(300);
    const least = await page.evaluate(() => {
      const svg = document.querySelector<SVGSVGElement>(".graph svg") as SVGSVGElement;
      const scale = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
      const sizes = [...svg.querySelectorAll(".node > text:first-of-type, .closed > text:first-of-type")];
      return Math.min(...sizes.map((text) => Number(text.getAttribute("font-size")) * scale));
    });
    // Labels; notes under two-ports and in groups are smaller.
    expect(least).toBeGreaterThanOrEqual(10);
  });

  test("every compared output has a lane", async () => {
    const shown = await page.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>(".lane")].flatMap((lane) => lane.dataset.paths?.split(" ")),
    );
    expect(shown).toEqual(expect.arrayContaining([...expected.outputs]));
  });

  test("below every lane of both models stands their difference", async () => {
    const keys = await page.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>("#outputs .lane")].map((lane) => (lane.dataset.lane ?? "").split(" ")[0]),
    );
    expect(keys.length).toBeGreaterThan(0);
    // A lane of signals that the reduced model has not, such as an input, stands alone.
    expect(keys.filter((key) => key === "difference").length).toBeGreaterThan(0);
    expect(keys.slice(0, 2)).toEqual(["values", "difference"]);
    const lane = page.locator("#outputs .lane").nth(1);
    await lane.scrollIntoViewIfNeeded();
    await lane.locator(".u-over").hover({ position: { x: 400, y: 40 } });
    await page.waitForFunction(() => document.querySelectorAll("#outputs .lane")[1]?.querySelector("output")?.textContent !== "–");
    const values = await page.locator("#outputs .lane").first().locator("output").allTextContents();
    const difference = (await lane.locator("output").first().textContent()) as string;
    expect(values.length).toBeGreaterThanOrEqual(2);
    expect(Number.isFinite(parseFloat(difference))).toBe(true);
  });
});
