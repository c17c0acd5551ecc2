/**
 * Drawing without a page: one function for JavaScript engines that have no document, such as the one inside Python.
 *
 * The worker of ELK is loaded before this script and left as it is; here it runs in place.
 */

import ELK from "elkjs/lib/elk-api.js";
import { draw } from "./graph/draw.ts";
import { fold, openTo } from "./graph/fold.ts";
import { place, type Direction, type Placer } from "./graph/layout.ts";
import type { Theme } from "./graph/notation.ts";
import type { Picture } from "./graph/picture.ts";

interface StaticOptions {
  readonly depth: number;
  readonly open: readonly string[];
  readonly theme: Theme;
  readonly legend: boolean;
  readonly direction: Direction;
}

declare const ElkWorker: new () => Worker;

/** The SVG text of a picture; both arguments are JSON texts. */
async function drawPicture(document: string, options: string): Promise<string> {
  const picture = JSON.parse(document) as Picture;
  const wanted = JSON.parse(options) as StaticOptions;
  const open = openTo(picture, wanted.depth);
  for (const path of wanted.open) open.add(path);
  const placer = new ELK({ workerFactory: () => new ElkWorker() }) as unknown as Placer;
  const layout = await place(fold(picture, open), placer, wanted.direction);
  return draw(picture, layout, { theme: wanted.theme, legend: wanted.legend });
}

Object.assign(globalThis, { drawPicture });
