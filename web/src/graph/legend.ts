/** The legend: which domain has which colour, what strokes mean, and the scale of activity. */

import { NOTE } from "./figures.ts";
import { activityColour, COLOURS, domainColour, LEAST, type Theme } from "./notation.ts";
import type { Picture } from "./picture.ts";
import { FONT, widthOf } from "./text.ts";
import { escaped, number, tag } from "./xml.ts";

export const LEGEND_HEIGHT = 58;
export const LEGEND_WIDTH = 620;
const STEPS = 20;

/** The legend of a picture as a drawing of its own, to stand beside one that is zoomed. */
export function legendAlone(picture: Picture, theme: Theme): string {
  const size = { width: LEGEND_WIDTH, height: LEGEND_HEIGHT, viewBox: `0 0 ${LEGEND_WIDTH} ${LEGEND_HEIGHT}` };
  return tag("svg", { class: "legend-alone", "font-family": FONT, "aria-hidden": "true", ...size }, legend(picture, 0, theme));
}

/** The legend of a picture, below it. */
export function legend(picture: Picture, top: number, theme: Theme): string {
  const colours = COLOURS[theme];
  const parts: string[] = [];
  const write = (text: string, x: number, y: number): number => {
    const width = widthOf(text, NOTE);
    parts.push(
      tag(
        "text",
        { x, y, fill: colours.ink, "font-size": NOTE, textLength: width, lengthAdjust: "spacingAndGlyphs" },
        escaped(text),
      ),
    );
    return x + width;
  };
  const line = (x: number, y: number, colour: string, width: number, dash = ""): void => {
    const look = dash === "" ? {} : { "stroke-dasharray": dash };
    parts.push(tag("path", { d: `M${number(x)} ${number(y)}h22`, stroke: colour, "stroke-width": width, ...look }));
  };
  let x = 12;
  let y = top + 20;
  for (const domain of [...new Set(picture.bonds.map((bond) => bond.domain))].sort()) {
    line(x, y - 3, domainColour(domain, theme), 2.2);
    x = write(domain.replace("_", " "), x + 26, y) + 16;
  }
  if (picture.signals.length > 0) {
    line(x, y - 3, colours.signal, 0.9);
    x = write("signal", x + 26, y) + 16;
  }
  x = 12;
  y += 20;
  const strokes = new Set(picture.bonds.map((bond) => bond.causality));
  for (const [kind, words] of [
    ["preferred", "causal stroke: effort goes in here"],
    ["dependent", "dependent storage"],
    ["conflict", "conflict"],
  ] as const) {
    if (!strokes.has(kind)) continue;
    parts.push(tag("path", { d: `M${number(x + 4)} ${number(y - 9)}v12`, stroke: colours.stroke[kind], "stroke-width": 2.4 }));
    x = write(words, x + 12, y) + 16;
  }
  if (picture.nodes.some((node) => node.gone !== undefined)) {
    line(x, y - 3, colours.quiet, 1.2, "4 3");
    x = write("gone, with what stands in its place", x + 26, y) + 16;
  }
  if (picture.activity !== undefined) {
    x = write("activity", x, y) + 6;
    x = write(LEAST.toExponential(0), x, y) + 4;
    for (let i = 0; i < STEPS; i++) {
      const fill = activityColour(LEAST ** (1 - (i + 0.5) / STEPS));
      parts.push(tag("rect", { x: x + 5 * i, y: y - 9, width: 5.2, height: 11, fill }));
    }
    x = write("1 of the total", x + 5 * STEPS + 4, y);
  }
  return tag("g", { class: "legend" }, parts.join(""));
}
