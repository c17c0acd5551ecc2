/**
 * Drawing without a page: one function for JavaScript engines that have no document, such as the one inside Python.
 *
 * `ELK` is the layout engine, loaded before this script and left as it is.
 */

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

declare const ELK: new () => Placer;

/** The SVG text of a picture; both arguments are JSON texts. */
async function drawPicture(document: string, options: string): Promise<string> {
  const picture = JSON.parse(document) as Picture;
  const wanted = JSON.parse(options) as StaticOptions;
  const open = openTo(picture, wanted.depth);
  for (const path of wanted.open) open.add(path);
  const layout = await place(fold(picture, open), new ELK(), wanted.direction);
  return draw(picture, layout, { theme: wanted.theme, legend: wanted.legend });
}

Object.assign(globalThis, { drawPicture });
