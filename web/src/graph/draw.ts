/** The drawing: an SVG text, the same for a page, a notebook, a report and a file. */

import type { Closed } from "./fold.ts";
import { NOTE, SIZE, TITLE, type Spot } from "./figures.ts";
import type { BondLine, Frame, Layout, Point, SignalLine } from "./layout.ts";
import { legend, LEGEND_HEIGHT, LEGEND_WIDTH } from "./legend.ts";
import {
  activityColour,
  barb,
  bondWidth,
  COLOURS,
  domainColour,
  lettersOn,
  stroke,
  type Colours,
  type Theme,
} from "./notation.ts";
import { isInformation, isJunction, isTwoPort, type Activity, type Picture } from "./picture.ts";
import { FONT, widthOf } from "./text.ts";
import { escaped, number, tag } from "./xml.ts";

export interface DrawingOptions {
  readonly theme: Theme;
  readonly legend: boolean;
  /** Rows that a threshold would take away. */
  readonly below?: ReadonlySet<string>;
}

/** Draw a layout. */
export function draw(picture: Picture, layout: Layout, options: DrawingOptions): string {
  const { attributes, parts } = drawnParts(picture, layout, options);
  return tag("svg", attributes, parts.join("\n"));
}

/** A drawing in its parts, each an element: of two drawings of one layout the same parts stand at the same places. */
export interface Parts {
  readonly attributes: Readonly<Record<string, string | number>>;
  readonly parts: readonly string[];
}

export function drawnParts(picture: Picture, layout: Layout, options: DrawingOptions): Parts {
  const colours = COLOURS[options.theme];
  const pen = new Pen(picture, colours, options.theme, options.below ?? new Set());
  const width = Math.max(layout.width, options.legend ? LEGEND_WIDTH : 0);
  const height = layout.height + (options.legend ? LEGEND_HEIGHT : 0);
  const parts = [
    tag("title", {}, escaped(`Bond graph of ${picture.name}`)),
    tag("rect", { width, height, fill: colours.paper }),
    ...layout.frames.map((frame) => pen.frame(frame)),
    ...layout.signals.map((line) => pen.signal(line)),
    ...layout.spots.map((spot) => pen.spot(spot)),
    ...layout.bonds.map((line) => pen.bond(line)),
    options.legend ? legend(picture, layout.height, options.theme) : "",
  ];
  const attributes = {
    xmlns: "http://www.w3.org/2000/svg",
    class: "bond-graph",
    viewBox: `0 0 ${number(width)} ${number(height)}`,
    width,
    height,
    "font-family": FONT,
    "font-size": SIZE,
    role: "img",
  };
  return { attributes, parts: parts.filter((part) => part !== "") };
}

class Pen {
  private readonly activity: Activity | undefined;
  private readonly greatest: number;

  constructor(
    picture: Picture,
    private readonly colours: Colours,
    private readonly theme: Theme,
    private readonly below: ReadonlySet<string>,
  ) {
    this.activity = picture.activity;
    this.greatest = Math.max(1e-300, ...Object.values(picture.activity?.bonds ?? {}));
  }

  frame(frame: Frame): string {
    const { x, y, width, height } = frame;
    return tag(
      "g",
      { class: "group", "data-group": frame.path },
      tag("title", {}, escaped(frame.path)) +
        tag("rect", { x, y, width, height, rx: 8, fill: this.colours.frame, stroke: this.colours.frameLine }) +
        this.letters(`▾ ${frame.name}`, x + 10, y + 20, { size: TITLE, bold: true, anchor: "start", fill: this.colours.quiet }),
    );
  }

  bond(line: BondLine): string {
    const { bond } = line.shown;
    const share = this.activity === undefined ? undefined : (this.activity.bonds[bond.name] ?? 0) / this.greatest;
    const width = bond.gone === true ? 1.2 : share === undefined ? 1.6 : bondWidth(share);
    const isConflict = bond.causality === "conflict";
    const colour = bond.gone === true ? this.colours.quiet : isConflict ? this.colours.stroke.conflict : domainColour(bond.domain, this.theme);
    const points = line.points;
    const last = points.length - 1;
    const tip = points[last] as Point;
    const side = barb(points[last - 1] as Point, tip);
    const pen = { fill: "none", stroke: colour, "stroke-width": width };
    const dash = bond.gone === true ? { "stroke-dasharray": "4 3" } : {};
    const parts = [
      tag("title", {}, escaped(`${bond.name} (${bond.domain})`)),
      tag("path", { class: "line", d: path(points), "stroke-linejoin": "round", ...pen, ...dash }),
      tag("path", { class: "barb", d: path([tip, side]), "stroke-linecap": "round", ...pen }),
    ];
    if (bond.effortInto !== undefined && bond.causality !== "none") {
      const atHead = bond.effortInto === bond.head;
      const [end, before] = atHead ? [tip, points[last - 1] as Point] : [points[0] as Point, points[1] as Point];
      const ends = stroke(before, end, width);
      const ink = bond.gone === true ? this.colours.quiet : this.colours.stroke[bond.causality];
      parts.push(
        tag("path", {
          class: `stroke ${bond.causality}`,
          "data-end": atHead ? "head" : "tail",
          d: path(ends),
          stroke: ink,
          "stroke-width": 2.4,
        }),
      );
      if (bond.causality === "fixed") parts.push(tag("circle", { cx: ends[0].x, cy: ends[0].y, r: 2.6, fill: ink }));
    }
    if (isConflict) parts.push(this.cross(halfway(points)));
    const attributes = { class: bond.gone === true ? "bond gone" : "bond", "data-bond": bond.name };
    return tag("g", attributes, parts.join(""));
  }

  signal(line: SignalLine): string {
    const [start, first, second, tip] = line.points;
    const length = Math.hypot(tip.x - second.x, tip.y - second.y) || 1;
    const [ux, uy] = [(tip.x - second.x) / length, (tip.y - second.y) / length];
    const head = [
      tip,
      { x: tip.x - 8 * ux - 3 * uy, y: tip.y - 8 * uy + 3 * ux },
      { x: tip.x - 8 * ux + 3 * uy, y: tip.y - 8 * uy - 3 * ux },
    ];
    const pairs = [first, second, tip].map((point) => `${number(point.x)} ${number(point.y)}`).join(",");
    const d = `M${number(start.x)} ${number(start.y)}C${pairs}`;
    return tag(
      "g",
      { class: "signal", "data-from": line.signal.from, "data-to": line.signal.to },
      tag("path", { d, fill: "none", stroke: this.colours.signal, "stroke-width": 0.8, "stroke-opacity": 0.75 }) +
        tag("path", { d: `${path(head)}Z`, fill: this.colours.signal }),
    );
  }

  spot(spot: Spot): string {
    if (spot.closed !== undefined) return this.closed(spot, spot.closed);
    const node = spot.node;
    if (node === undefined) return "";
    const share = node.row === undefined ? undefined : this.activity?.rows[node.row];
    const isGone = node.gone !== undefined || (node.row !== undefined && this.below.has(node.row));
    const fill = isGone || share === undefined ? this.colours.element : activityColour(share);
    const ink = isGone ? this.colours.quiet : share === undefined ? this.colours.ink : lettersOn(fill);
    const parts = [tag("title", {}, escaped(this.words(spot, share)))];
    if (isJunction(node) || isTwoPort(node.kind)) {
      parts.push(this.letters(spot.label, spot.x, spot.y + 4.5, { size: SIZE + 1, bold: isJunction(node), fill: ink }));
      if (spot.note !== "") {
        parts.push(this.letters(spot.note, spot.x, spot.y + spot.height / 2 + NOTE, { size: NOTE, fill: this.colours.quiet }));
      }
    } else {
      const information = isInformation(node.kind);
      const outline = isGone ? this.colours.quiet : information ? this.colours.signal : this.colours.ink;
      parts.push(
        tag("rect", {
          x: spot.x - spot.width / 2,
          y: spot.y - spot.height / 2,
          width: spot.width,
          height: spot.height,
          rx: node.row !== undefined ? spot.height / 2 : information ? 2 : 0,
          fill: node.row !== undefined || information ? fill : "none",
          stroke: node.row !== undefined || information ? outline : "none",
          "stroke-width": 1.2,
          ...(isGone ? { "stroke-dasharray": "4 3" } : {}),
        }),
        this.letters(spot.label, spot.x, spot.y + 4.3, { size: SIZE, fill: ink }),
      );
    }
    if (node.gone !== undefined) parts.push(this.badge(spot, node.gone.sign));
    const row: Record<string, string> = node.row === undefined ? {} : { "data-row": node.row };
    return tag(
      "g",
      { class: isGone ? "node gone" : "node", "data-id": node.path, "data-kind": node.kind, ...row },
      parts.join(""),
    );
  }

  private closed(spot: Spot, closed: Closed): string {
    const hasShare = this.activity !== undefined && closed.rows > 0;
    const fill = hasShare ? activityColour(closed.share) : this.colours.closed;
    const ink = hasShare ? lettersOn(fill) : this.colours.ink;
    const [x, y] = [spot.x - spot.width / 2, spot.y - spot.height / 2];
    const words = hasShare ? `${closed.path}: ${percent(closed.share)} of the activity` : closed.path;
    const parts = [
      tag("title", {}, escaped(words)),
      tag("rect", { x, y, width: spot.width, height: spot.height, rx: 8, fill, stroke: this.colours.frameLine, "stroke-width": 1.4 }),
      this.letters(`▸ ${spot.label}`, spot.x, spot.y + (spot.note === "" ? 4.5 : -2), { size: TITLE, bold: true, fill: ink }),
    ];
    if (spot.note !== "") parts.push(this.letters(spot.note, spot.x, spot.y + 14, { size: NOTE, fill: ink }));
    return tag("g", { class: "closed", "data-group": closed.path }, parts.join(""));
  }

  /** The sign of what stands in the place of an element that is gone. */
  private badge(spot: Spot, sign: string): string {
    const width = widthOf(sign, NOTE, true) + 8;
    const [x, y] = [spot.x + spot.width / 2 - 4, spot.y - spot.height / 2 - 6];
    return (
      tag("rect", { x: x - width / 2, y: y - 7, width, height: 14, rx: 3, fill: this.colours.paper, stroke: this.colours.quiet }) +
      this.letters(sign, x, y + 3.5, { size: NOTE, bold: true, fill: this.colours.ink })
    );
  }

  /** The sign of a bond whose strokes contradict one another. */
  private cross(at: Point): string {
    const d = `M${number(at.x - 5)} ${number(at.y - 5)}l10 10m0 -10l-10 10`;
    return tag("path", { class: "cross", d, stroke: this.colours.stroke.conflict, "stroke-width": 2.2, fill: "none" });
  }

  private words(spot: Spot, share: number | undefined): string {
    const node = spot.node;
    if (node === undefined) return "";
    const activity = share === undefined ? "" : `, ${percent(share)} of the activity`;
    const gone = node.gone === undefined ? "" : `, gone: ${node.gone.meaning}`;
    return `${node.path} (${node.kind})${activity}${gone}`;
  }

  private letters(
    text: string,
    x: number,
    y: number,
    look: { size: number; fill: string; bold?: boolean; anchor?: "start" | "middle" },
  ): string {
    return tag(
      "text",
      {
        x,
        y,
        fill: look.fill,
        "font-size": look.size,
        "text-anchor": look.anchor ?? "middle",
        ...(look.bold === true ? { "font-weight": 700 } : {}),
        // The place was made for this length: another font is fitted to it.
        textLength: widthOf(text, look.size, look.bold),
        lengthAdjust: "spacingAndGlyphs",
      },
      escaped(text),
    );
  }
}

const percent = (share: number): string => `${(100 * share).toPrecision(3)} %`;

const path = (points: readonly Point[]): string =>
  points.map((point, i) => `${i === 0 ? "M" : "L"}${number(point.x)} ${number(point.y)}`).join("");

/** The middle of the longest stretch of a line. */
function halfway(points: readonly Point[]): Point {
  let [best, longest] = [points[0] as Point, -1];
  points.slice(1).forEach((point, i) => {
    const from = points[i] as Point;
    const length = Math.hypot(point.x - from.x, point.y - from.y);
    if (length > longest) [best, longest] = [{ x: (from.x + point.x) / 2, y: (from.y + point.y) / 2 }, length];
  });
  return best;
}
