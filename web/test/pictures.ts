/** The pictures that Python makes of models, shared with its tests, and the layout engine. */

import { readFileSync } from "node:fs";
import ELK from "elkjs/lib/elk.bundled.js";
import type { Placer } from "../src/graph/layout.ts";
import type { Picture } from "../src/graph/picture.ts";

export const NAMES = ["quarter_car", "buck_converter", "hydraulic_press", "half_car", "truck"] as const;

export function picture(name: (typeof NAMES)[number]): Picture {
  return JSON.parse(readFileSync(new URL(`pictures/${name}.json`, import.meta.url), "utf-8")) as Picture;
}

export const elk = new ELK() as unknown as Placer;
