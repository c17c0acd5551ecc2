/** Lanes as a drawing that can be saved: the same lines and pens as on the page, on white. */

import { escaped, number, tag } from "../graph/xml.ts";
import { FONT } from "../graph/text.ts";
import { axisUnit } from "./format.ts";
import type { Lane, LaneColumns } from "./plot.tsx";
import type { Span } from "./source.ts";

const WIDTH = 900;
const LANE = 150;
const LEFT = 70;
const RIGHT = 20;
const TOP = 34;
const BOTTOM = 24;
const INKS = ["#0b5cad", "#c2410c", "#2e7d32", "#7b3fa0", "#8a6d00", "#a3195b"];

/** A drawing of lanes within a span, one below the other. */
export function lanesPicture(lanes: readonly Lane[], columns: readonly LaneColumns[], span: Span): { text: string; width: number; height: number } {
  const height = lanes.length * LANE + 20;
  const body = lanes.map((lane, i) => laneOf(lane, columns[i] ?? [], span, i * LANE)).join("");
  const look = { xmlns: "http://www.w3.org/2000/svg", width: WIDTH, height, viewBox: `0 0 ${WIDTH} ${height}`, "font-family": FONT, "font-size": 11 };
  const paper = tag("rect", { width: WIDTH, height, fill: "#ffffff" });
  const foot = tag("text", { x: WIDTH - RIGHT, y: height - 6, "text-anchor": "end" }, "time, s");
  return { text: tag("svg", look, paper + body + foot), width: WIDTH, height };
}

function laneOf(lane: Lane, columns: LaneColumns, [from, to]: Span, top: number): string {
  const times = columns[0] ?? [];
  const values = columns.slice(1);
  let [low, high] = [Infinity, -Infinity];
  for (const column of values) {
    for (let i = 0; i < column.length; i++) {
      const [time, value] = [times[i] as number, column[i]];
      if (time < from || time > to || value == null) continue;
      [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
  }
  if (low > high) [low, high] = [0, 1];
  if (low === high) [low, high] = [low - (Math.abs(low) * 0.1 || 1), high + (Math.abs(high) * 0.1 || 1)];
  const x = (time: number): number => LEFT + ((WIDTH - LEFT - RIGHT) * (time - from)) / (to - from || 1);
  const y = (value: number): number => top + LANE - BOTTOM - ((LANE - TOP - BOTTOM) * (value - low)) / (high - low);
  const unit = axisUnit(Math.max(Math.abs(low), Math.abs(high)), lane.unit);
  const parts = [tag("text", { x: LEFT, y: top + 14, "font-weight": 700 }, escaped(`${lane.title}${unit.text === "" ? "" : ` [${unit.text}]`}`))];
  for (const value of ticks(low, high, 4)) {
    parts.push(tag("path", { d: `M${LEFT} ${number(y(value))}H${WIDTH - RIGHT}`, stroke: "#d7dee7" }));
    parts.push(tag("text", { x: LEFT - 6, y: y(value) + 4, "text-anchor": "end" }, String(Number((value / unit.factor).toPrecision(5)))));
  }
  for (const time of ticks(from, to, 9)) {
    parts.push(tag("path", { d: `M${number(x(time))} ${top + TOP}V${top + LANE - BOTTOM}`, stroke: "#d7dee7" }));
    parts.push(tag("text", { x: x(time), y: top + LANE - BOTTOM + 14, "text-anchor": "middle" }, String(Number(time.toPrecision(6)))));
  }
  let legend = LEFT;
  lane.lines.forEach((line, i) => {
    const pen = { fill: "none", stroke: INKS[line.colour - 1] ?? "#000000", "stroke-width": 1.3, ...(line.dash.length > 0 ? { "stroke-dasharray": line.dash.join(" ") } : {}) };
    let d = "";
    let isDown = false;
    const column = values[i] ?? [];
    for (let k = 0; k < column.length; k++) {
      const [time, value] = [times[k] as number, column[k]];
      if (time < from || time > to) continue;
      if (value == null) isDown = false;
      else {
        d += `${isDown ? "L" : "M"}${number(x(time))} ${number(y(value))}`;
        isDown = true;
      }
    }
    parts.push(tag("path", { d, ...pen }));
    parts.push(tag("path", { d: `M${legend} ${top + 25}h22`, ...pen }));
    parts.push(tag("text", { x: legend + 26, y: top + 29 }, escaped(line.label)));
    legend += 46 + 6 * line.label.length;
  });
  return parts.join("");
}

/** Round numbers between two values, about so many. */
export function ticks(low: number, high: number, about: number): number[] {
  const raw = (high - low) / about;
  const size = 10 ** Math.floor(Math.log10(raw));
  const step = ([1, 2, 5].find((one) => one * size >= raw) ?? 10) * size;
  const found: number[] = [];
  for (let at = Math.ceil(low / step); at * step <= high + 1e-9 * step; at++) found.push(at * step);
  return found;
}
