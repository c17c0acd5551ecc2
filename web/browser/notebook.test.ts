/** An executed notebook as an HTML page: it loads nothing, and its graph stands where this front end puts it. */

import { readFileSync } from "node:fs";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { draw } from "../src/graph/draw.ts";
import { fold, openTo } from "../src/graph/fold.ts";
import { place } from "../src/graph/layout.ts";
import type { Picture } from "../src/graph/picture.ts";
import { elk } from "../test/pictures.ts";
import { launched } from "./chromium.ts";
import { FOLDER, opened } from "./pages.ts";

type Places = Readonly<Record<string, readonly [number, number]>>;

const faults: string[] = [];
let browser: Browser;
let page: Page;

beforeAll(async () => {
  browser = await launched();
  page = await opened(browser, "notebook", faults);
});
afterAll(async () => {
  await browser.close();
  expect(faults).toEqual([]);
});

/** Where the nodes of the first drawing in an element stand, from its corner, in px. */
function places(within: string): Promise<Places> {
  return page.$eval(`${within} svg:has(.node)`, (svg) => {
    const corner = svg.getBoundingClientRect();
    const scale = (svg as SVGSVGElement).viewBox.baseVal.width / corner.width;
    const found: Record<string, [number, number]> = {};
    for (const node of svg.querySelectorAll<SVGElement>(".node[data-id]")) {
      const box = node.getBoundingClientRect();
      found[node.dataset.id ?? ""] = [scale * (box.x - corner.x), scale * (box.y - corner.y)];
    }
    return found;
  });
}

test("the graph drawn without a browser is the one drawn in it", async () => {
  const picture = JSON.parse(readFileSync(new URL("notebook.json", FOLDER), "utf-8")) as Picture;
  const layout = await place(fold(picture, openTo(picture, 1)), elk);
  const inNotebook = await places("body");
  await page.evaluate((svg) => {
    const element = document.createElement("div");
    element.id = "drawn-here";
    element.innerHTML = svg;
    document.body.append(element);
  }, draw(picture, layout, { theme: "light", legend: true }));
  const here = await places("#drawn-here");
  expect(Object.keys(inNotebook).sort()).toEqual(picture.nodes.map((node) => node.path).sort());
  expect(Object.keys(here).sort()).toEqual(Object.keys(inNotebook).sort());
  for (const [path, [x, y]] of Object.entries(here)) {
    expect(Math.abs(x - (inNotebook[path]?.[0] ?? NaN)), path).toBeLessThan(0.5);
    expect(Math.abs(y - (inNotebook[path]?.[1] ?? NaN)), path).toBeLessThan(0.5);
  }
});

test("rankings, front and comparison are there", async () => {
  const text = await page.innerText("body");
  for (const words of ["suspension.spring", "recommended", "rms / range", "unaccounted"]) expect(text).toContain(words);
});
