/**
 * How things are written: colours of domains and of activity, pens, half arrows, causal strokes.
 *
 * Domain colours are those of the Modelica Standard Library's connectors, which users of Modelica tools know. The signs are
 * those of textbooks (Karnopp, Margolis and Rosenberg, System Dynamics; Borutzky, Bond Graph Methodology): a half arrow
 * on the flow's side, which is below or to the right, and the stroke where effort goes in.
 */

import type { Point } from "./layout.ts";
import type { Causality } from "./picture.ts";

export type Theme = "light" | "dark";

export interface Colours {
  readonly paper: string;
  readonly ink: string;
  readonly quiet: string; // notes, and what is gone
  readonly frame: string;
  readonly frameLine: string;
  readonly closed: string;
  readonly element: string; // of an element without activity
  readonly signal: string;
  readonly stroke: Readonly<Record<Exclude<Causality, "none">, string>>;
}

export const COLOURS: Readonly<Record<Theme, Colours>> = {
  light: {
    paper: "#ffffff",
    ink: "#16191d",
    quiet: "#5f6873",
    frame: "#eef2f7",
    frameLine: "#a9b7c8",
    closed: "#e2e9f2",
    element: "#ffffff",
    signal: "#6b4a8e",
    stroke: { preferred: "#000000", dependent: "#d96a00", conflict: "#d00000", fixed: "#000000" },
  },
  dark: {
    paper: "#14171b",
    ink: "#eef1f4",
    quiet: "#9aa5b1",
    frame: "#1b2027",
    frameLine: "#4a5767",
    closed: "#252d38",
    element: "#14171b",
    signal: "#c3a5e6",
    stroke: { preferred: "#ffffff", dependent: "#ffa14a", conflict: "#ff6b6b", fixed: "#ffffff" },
  },
};

const DOMAINS: Readonly<Record<string, Readonly<Record<Theme, string>>>> = {
  translation: { light: "#007f00", dark: "#4cc24c" },
  rotation: { light: "#5f5f5f", dark: "#b0b0b0" },
  hydraulic: { light: "#007fff", dark: "#4da6ff" },
  thermal: { light: "#bf0000", dark: "#ff6b5e" },
  electrical: { light: "#0000ff", dark: "#8f9bff" },
  magnetic: { light: "#ff7f00", dark: "#ffa64d" },
};
const OTHER_DOMAIN: Readonly<Record<Theme, string>> = { light: "#8a5a00", dark: "#d9b45b" };

/** The colour of a domain; pseudo domains have that of the true one, others share one colour. */
export function domainColour(domain: string, theme: Theme): string {
  const known = DOMAINS[domain] ?? DOMAINS[domain.replace(/^pseudo_/, "")];
  return (known ?? OTHER_DOMAIN)[theme];
}

/** The scale of activity: shares of the total below the first count as nothing. */
export const LEAST = 1e-5;
const SCALE = ["#fff8e1", "#fee29a", "#fdc25a", "#f99a3c", "#ec6a2c", "#cf3a27", "#9c1220"];

/** Where a share stands on the logarithmic scale, from 0 to 1. */
export const level = (share: number): number =>
  share <= LEAST ? 0 : Math.min(1, 1 - Math.log(share) / Math.log(LEAST));

/** The fill of an element with a share of the activity. */
export function activityColour(share: number): string {
  const place = level(share) * (SCALE.length - 1);
  const low = Math.min(Math.floor(place), SCALE.length - 2);
  return mixed(SCALE[low] as string, SCALE[low + 1] as string, place - low);
}

/** The colour of letters on a fill: dark or white, whichever stands out. */
export function lettersOn(fill: string): string {
  const [r, g, b] = channels(fill).map((c) => (c / 255 <= 0.03928 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
  const luminance = 0.2126 * (r as number) + 0.7152 * (g as number) + 0.0722 * (b as number);
  return luminance > 0.179 ? "#000000" : "#ffffff";
}

function channels(colour: string): [number, number, number] {
  const value = parseInt(colour.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}

function mixed(a: string, b: string, share: number): string {
  const [from, to] = [channels(a), channels(b)];
  const sum = from.map((c, i) => Math.round(c + ((to[i] as number) - c) * share));
  return `#${sum.map((c) => c.toString(16).padStart(2, "0")).join("")}`;
}

/** The width of a bond with a share of the greatest activity of bonds. */
export const bondWidth = (share: number): number => 1.3 + 4.2 * Math.sqrt(Math.min(1, Math.max(0, share)));

const BARB = 10;
const STROKE = 12;

/** The barb of a half arrow at the end of a line: on its lower side, or on the right of an upright line. */
export function barb(before: Point, tip: Point): Point {
  const length = Math.hypot(tip.x - before.x, tip.y - before.y) || 1;
  const [ux, uy] = [(tip.x - before.x) / length, (tip.y - before.y) / length];
  let [nx, ny] = [-uy, ux];
  if (Math.abs(ny) > 0.35 ? ny < 0 : nx < 0) [nx, ny] = [-nx, -ny];
  return { x: tip.x - BARB * ux + 0.55 * BARB * nx, y: tip.y - BARB * uy + 0.55 * BARB * ny };
}

/** The two ends of a causal stroke across the end of a line. */
export function stroke(before: Point, end: Point, width: number): [Point, Point] {
  const length = Math.hypot(end.x - before.x, end.y - before.y) || 1;
  const [nx, ny] = [-(end.y - before.y) / length, (end.x - before.x) / length];
  const half = STROKE / 2 + Math.max(0, width - 2) / 2;
  return [
    { x: end.x + half * nx, y: end.y + half * ny },
    { x: end.x - half * nx, y: end.y - half * ny },
  ];
}
