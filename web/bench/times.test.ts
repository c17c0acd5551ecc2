/**
 * How long the pages take, on this machine, in figures; nothing is asserted. `make bench-browser` makes the report and the
 * folder that are opened here.
 */

import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, test } from "vitest";
import { launched } from "../browser/chromium.ts";
import { Server, Visitor } from "../browser/server.ts";

const OUT = new URL("../../out/browser/", import.meta.url);
const MISSION = process.env.MISSION ?? "20"; // s of the truck's mission
let browser: Browser;
let server: Server;
let visitor: Visitor;
let page: Page;

beforeAll(async () => {
  [browser, server] = await Promise.all([launched(), Server.start(fileURLToPath(new URL("studio", OUT)))]);
  visitor = await Visitor.at(await browser.newContext({ viewport: { width: 1280, height: 800 } }), server);
  page = visitor.page;
});
afterAll(async () => {
  await browser.close();
  await server.stop();
});

const say = (name: string, text: string): void => console.log(`${name.padEnd(58)} ${text}`);
const spread = (times: readonly number[]): string => {
  const sorted = [...times].sort((a, b) => a - b);
  const at = (share: number): string => (sorted[Math.floor(share * (sorted.length - 1))] ?? NaN).toFixed(1).padStart(7);
  return `median ${at(0.5)} ms, largest ${at(1)} ms, of ${times.length}`;
};

async function timed(action: () => Promise<unknown>): Promise<number> {
  const start = performance.now();
  await action();
  return performance.now() - start;
}

/** Move the threshold from 0.5 to 1 in 50 steps, each until it is painted. */
async function slid(on: Page): Promise<number[]> {
  return on.evaluate(async () => {
    const slider = document.querySelector<HTMLInputElement>("#threshold") as HTMLInputElement;
    const times: number[] = [];
    for (let i = 0; i <= 50; i++) {
      const start = performance.now();
      slider.value = String(1 - Math.sqrt(0.5 * (1 - i / 50)));
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      await new Promise((painted) => requestAnimationFrame(() => setTimeout(painted)));
      times.push(performance.now() - start);
    }
    return times;
  });
}

async function ran(hash: string): Promise<string> {
  await visitor.open(hash);
  await page.getByRole("button", { name: "Run", exact: true }).click();
  await page.waitForFunction(() => !["queued", "running"].includes(document.querySelector<HTMLElement>(".job-now")?.dataset.state ?? "queued"), undefined, { timeout: 900_000 });
  return (await page.locator(".job-now").getAttribute("data-job")) as string;
}

test("times", { timeout: 1_800_000 }, async () => {
  const opened = async (): Promise<number> => {
    await visitor.open("#/");
    await page.waitForSelector(".cards");
    return timed(() => visitor.drawn("#/model?model=truck"));
  };
  say("truck, first time: until it is drawn", `${(await opened()).toFixed(0)} ms`);
  await page.reload();
  say("truck, known to the server: until it is drawn", `${(await opened()).toFixed(0)} ms`);

  const groups = await page.locator(".graph .closed").evaluateAll((boxes) => boxes.map((box) => (box as SVGElement).dataset.group as string));
  const folded: number[] = [];
  for (let round = 0; round < 2; round++) {
    for (const group of groups) {
      folded.push(await timed(async () => {
        await page.locator(`.tree [data-key="${group}"] .twig`).click();
        await page.waitForSelector(`.graph .group[data-group="${group}"]`);
      }));
      folded.push(await timed(async () => {
        await page.locator(`.tree [data-key="${group}"] .twig`).click();
        await page.waitForSelector(`.graph .closed[data-group="${group}"]`);
      }));
    }
  }
  say("a group opens or closes, placed for the first time or again", spread(folded));

  const run = await ran(`#/run?model=truck&until=${MISSION}`);
  await visitor.drawn(`#/activity?run=${run}`);
  await page.getByRole("button", { name: "all", exact: true }).first().click();
  await page.waitForTimeout(4000);
  say("threshold of the truck, everything open: until painted", spread(await slid(page)));
  await page.evaluate(async () => {
    const order = { model: "trouble.py:Shaken", scenario: "endless" };
    await fetch("/api/trust", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" });
    await fetch("/api/runs", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(order) });
  });
  await page.waitForTimeout(6000);
  say("the same while a run is busy", spread(await slid(page)));
  await page.evaluate(async () => {
    const jobs = (await (await fetch("/api/jobs")).json()) as { id: string; state: string }[];
    for (const job of jobs.filter(({ state }) => state === "running")) {
      await fetch(`/api/jobs/${job.id}/cancel`, { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" });
    }
  });

  const { paths, rows } = await page.evaluate(async (id) => {
    const signals = (await (await fetch(`/api/runs/${id}/signals`)).json()) as { path: string }[];
    const table = await (await fetch(`/api/runs/${id}/csv?signal=${signals[0]?.path}`)).text();
    return { paths: signals.slice(0, 60).map(({ path }) => path), rows: table.trim().split("\n").length - 1 };
  }, run);
  const signals = paths.map((path) => `signal=${path}`).join("&");
  const settled = (): Promise<unknown> => page.waitForFunction(() => document.querySelector(".strip")?.getAttribute("aria-busy") === "false" && document.querySelector(".lane canvas") !== null);
  const first = await timed(async () => {
    await visitor.open(`#/plots?run=${run}&${signals}`);
    await page.waitForFunction(() => document.querySelectorAll(".lane").length === 60);
    await settled();
  });
  say(`60 signals of ${rows} rows (${((60 * rows) / 1e6).toFixed(2)} M samples): first drawn`, `${first.toFixed(0)} ms`);
  const zooms: number[] = [];
  await page.locator(".strip").focus();
  for (let i = 0; i < 50; i++) {
    const key = Math.floor(i / 5) % 2 === 0 ? "+" : "-";
    zooms.push(await timed(async () => {
      const asked = page.waitForResponse((response) => response.url().includes("/series"));
      await page.keyboard.press(key);
      await asked;
      await settled();
    }).catch(() => NaN));
  }
  say("  zoomed", spread(zooms.filter(Number.isFinite)));
  const heap = await page.evaluate(() => (performance as unknown as { memory: { usedJSHeapSize: number } }).memory.usedJSHeapSize);
  say("  heap of the page afterwards", `${(heap / 2 ** 20).toFixed(0)} MiB`);

  const report = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  const shown: number[] = [];
  for (let i = 0; i < 3; i++) {
    shown.push(await timed(async () => {
      await report.goto(new URL("truck.html", OUT).href);
      await report.waitForSelector(".fact");
    }));
  }
  say(`report of the truck (${(readFileSync(new URL("truck.html", OUT)).length / 1e6).toFixed(2)} MB): until its figures are there`, spread(shown));
  await report.waitForSelector("body[data-ready]");
  say("  threshold: until painted", spread(await slid(report)));
});
