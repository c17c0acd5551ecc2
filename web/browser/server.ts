/** The studio's real server for tests, and who visits it. */

import { spawn, type ChildProcess } from "node:child_process";
import { existsSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { fileURLToPath } from "node:url";
import type { BrowserContext, Page } from "playwright-core";

const ROOT = fileURLToPath(new URL("../../", import.meta.url));
/** The package as users get it, before its sources: `python -m tests.browser.wheel`. */
const WHEEL = `${ROOT}out/browser/wheel`;
const PATIENCE = 60_000; // ms

/** A server of a folder, by the command that users have. */
export class Server {
  private constructor(
    private readonly child: ChildProcess,
    readonly address: string,
  ) {}

  static async start(folder: string): Promise<Server> {
    const command = process.env.PROPERMODEL ?? `${ROOT}.venv/bin/propermodel`;
    if (!existsSync(WHEEL)) throw new Error("no wheel: python -m tests.browser.wheel");
    // What this server is told to trust is forgotten with it.
    const env = { ...process.env, XDG_DATA_HOME: mkdtempSync(`${tmpdir()}/propermodel-`), PYTHONPATH: WHEEL };
    const child = spawn(command, ["studio", folder, "--no-browser"], { cwd: ROOT, env, stdio: ["ignore", "pipe", "inherit"] });
    let text = "";
    const address = await new Promise<string>((resolve, reject) => {
      child.on("exit", (code) => reject(new Error(`the studio ended with ${code}`)));
      child.stdout?.on("data", (bytes: Buffer) => {
        text += bytes.toString();
        const found = /http:\S+/.exec(text);
        if (found !== null) resolve(found[0]);
      });
    });
    return new Server(child, address);
  }

  async stop(): Promise<void> {
    const ended = new Promise((resolve) => this.child.on("exit", resolve));
    this.child.kill("SIGINT");
    await ended;
  }
}

/** A page of the studio that notes everything that should not be: errors, and requests to elsewhere. */
export class Visitor {
  readonly faults: string[] = [];
  readonly asked: string[] = [];
  /** Answers that a test has provoked. */
  readonly expected = new Set<number>();

  private constructor(readonly page: Page) {}

  static async at(context: BrowserContext, server: Server): Promise<Visitor> {
    const page = await context.newPage();
    page.setDefaultTimeout(PATIENCE);
    const visitor = new Visitor(page);
    const own = new URL(server.address).origin;
    page.on("pageerror", (error) => visitor.faults.push(error.message));
    page.on("console", (message) => {
      const isExpected = [...visitor.expected].some((status) => message.text().includes(String(status)));
      if (message.type() === "error" && !isExpected) visitor.faults.push(message.text());
    });
    page.on("request", (request) => {
      visitor.asked.push(request.url());
      if (!request.url().startsWith(own) && !/^(blob|data):/.test(request.url())) visitor.faults.push(`asked for ${request.url()}`);
    });
    await page.goto(server.address);
    await page.waitForSelector("main[data-screen]");
    return visitor;
  }

  /** Go to a view by its address. */
  async open(hash: string): Promise<void> {
    await this.page.evaluate((to) => {
      if (location.hash === to) return;
      delete document.body.dataset.ready;
      location.hash = to;
    }, hash);
  }

  /** Go to a view with a graph, and wait until it is drawn. */
  async drawn(hash: string): Promise<void> {
    await this.open(hash);
    await this.page.waitForSelector("body[data-ready] .graph svg .node, body[data-ready] .graph svg .closed");
  }

  get hash(): string {
    return new URL(this.page.url()).hash;
  }
}
