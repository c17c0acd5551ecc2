/** Pages that Python has written, opened in Chromium with no network: whatever they ask for or complain about is a fault. */

import type { Browser, Page } from "playwright-core";

export const FOLDER = new URL("../../out/browser/", import.meta.url);

/** A page from a file, with all faults that it shows. */
export async function opened(browser: Browser, name: string, faults: string[], hash = ""): Promise<Page> {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  page.on("pageerror", (error) => faults.push(error.message));
  page.on("console", (message) => {
    if (message.type() === "error") faults.push(message.text());
  });
  page.on("request", (request) => {
    if (!/^(file|blob|data):/.test(request.url())) faults.push(`asked for ${request.url()}`);
  });
  await page.goto(`${new URL(`${name}.html`, FOLDER).href}${hash}`);
  return page;
}
