/** One lane: what is drawn above one another on one scale over time, with the values at the cursor beside it. */

import { useComputed, useSignal, type ReadonlySignal, type Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { axisUnit, unitText, type AxisUnit } from "./format.ts";
import type { Theme } from "../graph/notation.ts";
import type { Span } from "./source.ts";

/** A line of a lane: a signal of a run. */
export interface Line {
  readonly run: string;
  readonly path: string;
  readonly label: string;
  readonly colour: number; // 1 to 6
  readonly dash: readonly number[];
}

/** What is drawn above one another on one scale. */
export interface Lane {
  readonly key: string;
  readonly title: string;
  readonly unit: string;
  readonly lines: readonly Line[];
}

/** The columns of a lane: instants, then one column for each line. */
export type LaneColumns = readonly ArrayLike<number | null>[];

/** What all lanes of a page share. */
export interface Shared {
  readonly theme: ReadonlySignal<Theme>;
  readonly span: ReadonlySignal<Span>;
  /** The instant under the cursor, as its place in the columns. */
  readonly cursor: Signal<number | null>;
  readonly zoom: (span: Span | null) => void;
}

export const COLOURS = 6;
const AXIS = 58; // px: room for "−123.45"

interface PlotProps {
  readonly lane: Lane;
  readonly columns: LaneColumns;
  readonly shared: Shared;
  readonly height: number;
  readonly group: string; // whose cursors go together
  /** Exact values at the cursor by line, where they are known. */
  readonly exact: ReadonlySignal<ReadonlyMap<string, number> | null>;
}

export const lineKey = (line: { readonly run: string; readonly path: string }): string => `${line.run}/${line.path}`;

export function LanePlot({ lane, columns, shared, height, group, exact }: PlotProps) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const isNear = useSignal(false);
  const unit = useSignal<AxisUnit>({ text: lane.unit, factor: 1 });
  const latest = useRef(columns);
  latest.current = columns;
  const theme = shared.theme.value;
  const near = isNear.value;
  const shape = lane.lines.map(lineKey).join(" ");

  // A lane far from view is not drawn: sixty of them would hold up the page.
  useEffect(() => {
    if (place.current === null) return;
    const watched = new IntersectionObserver((entries) => (isNear.value = entries.some((entry) => entry.isIntersecting)), {
      rootMargin: "300px",
    });
    watched.observe(place.current);
    const printed = (): void => void (isNear.value = true);
    addEventListener("beforeprint", printed);
    return () => {
      watched.disconnect();
      removeEventListener("beforeprint", printed);
    };
  }, []);
  useEffect(() => {
    const element = place.current;
    if (element === null || !near) return;
    const made = drawn(element, lane, latest.current, shared, height, group, unit);
    plot.current = made;
    const resized = new ResizeObserver(() => made.setSize({ width: element.clientWidth, height }));
    resized.observe(element);
    return () => {
      resized.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [shape, theme, near, height]);
  useEffect(() => {
    if (plot.current === null) return;
    unit.value = axisUnit(sizeOf(columns, shared.span.peek()), lane.unit);
    plot.current.setData(columns as unknown as uPlot.AlignedData);
  }, [columns]);

  const title = useComputed(() => `${lane.title}${unit.value.text === "" ? "" : ` [${unit.value.text}]`}`);
  return (
    <div class="lane" data-lane={lane.key} data-paths={[...new Set(lane.lines.map((line) => line.path))].join(" ")}>
      <div class="lane-plot">
        <h4 class="lane-title" title={lane.title}>{title}</h4>
        <div class="canvas" ref={place} style={{ height: `${height}px` }} />
      </div>
      <Readings lane={lane} columns={columns} shared={shared} exact={exact} />
    </div>
  );
}

/** Which line is which, and its value at the cursor. */
function Readings({ lane, columns, shared, exact }: Pick<PlotProps, "lane" | "columns" | "shared" | "exact">) {
  const at = shared.cursor.value;
  const known = exact.value;
  return (
    <ul class="readings">
      {lane.lines.map((line, i) => {
        const value = known?.get(lineKey(line)) ?? (at === null ? null : (columns[i + 1]?.[at] ?? null));
        const isNumber = value !== null && Number.isFinite(value);
        return (
          <li key={lineKey(line)}>
            <svg class="pen" width="26" height="8" aria-hidden="true">
              <line x1="1" x2="25" y1="4" y2="4" class={`series-${line.colour}`} stroke-dasharray={line.dash.join(" ")} />
            </svg>
            <span class="name" title={line.path}>{line.label}</span>
            <output data-line={lineKey(line)}>{isNumber ? `${Number(value.toPrecision(5))} ${unitText(lane.unit)}`.trim() : "–"}</output>
          </li>
        );
      })}
    </ul>
  );
}

function drawn(
  element: HTMLElement,
  lane: Lane,
  columns: LaneColumns,
  shared: Shared,
  height: number,
  group: string,
  unit: Signal<AxisUnit>,
): uPlot {
  const style = getComputedStyle(document.documentElement);
  const ink = style.getPropertyValue("--quiet");
  const grid = style.getPropertyValue("--grid");
  const font = "11px Helvetica, Arial, 'Liberation Sans', sans-serif";
  unit.value = axisUnit(sizeOf(columns, shared.span.peek()), lane.unit);
  const ticks = (_: uPlot, values: number[], _axis: number, _space: number, step: number): string[] =>
    values.map((value) => short(value / unit.peek().factor, step / unit.peek().factor));
  const axis = { stroke: ink, font, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, size: 4 }, gap: 4 };
  return new uPlot(
    {
      width: element.clientWidth,
      height,
      padding: [6, 12, 0, 0],
      legend: { show: false },
      cursor: {
        sync: { key: group, setSeries: false },
        y: false,
        drag: { x: true, y: false, setScale: false },
        points: { size: 6 },
        // All lanes go back to everything together.
        bind: {
          dblclick: () => () => {
            shared.zoom(null);
            return null;
          },
        },
      },
      select: { show: true, left: 0, top: 0, width: 0, height: 0 },
      scales: { x: { time: false, range: () => [...shared.span.peek()] as [number, number] }, y: { range: padded } },
      axes: [
        { ...axis, size: 24, values: (_, values) => values.map((value) => String(Number(value.toPrecision(9)))) },
        { ...axis, size: AXIS, values: ticks, space: 24 },
      ],
      series: [
        {},
        ...lane.lines.map((line) => ({
          label: line.label,
          stroke: style.getPropertyValue(`--series-${line.colour}`),
          width: 1.4,
          dash: [...line.dash],
          spanGaps: false,
          points: { show: false },
        })),
      ],
      hooks: {
        setCursor: [(own) => (shared.cursor.value = own.cursor.idx ?? null)],
        setSelect: [
          (own) => {
            const { left, width } = own.select;
            if (width < 4) return;
            shared.zoom([own.posToVal(left, "x"), own.posToVal(left + width, "x")]);
            own.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          },
        ],
      },
    },
    columns as unknown as uPlot.AlignedData,
    element,
  );
}

/** As many digits as tell one tick from the next, which leaves them short enough for the room beside the axis. */
function short(value: number, step: number): string {
  const digits = Math.min(8, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
  return String(Number(value.toFixed(digits))).replace("-", "−");
}

/** Room above and below; a constant is in the middle. */
function padded(_: uPlot, low: number | null, high: number | null): [number, number] {
  if (low === null || high === null || !Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  if (low === high) {
    const room = Math.abs(low) * 0.1 || 1;
    return [low - room, high + room];
  }
  const room = 0.06 * (high - low);
  return [low - room, high + room];
}

/** The greatest absolute value of a lane within a span. */
function sizeOf(columns: LaneColumns, [from, to]: Span): number {
  const times = columns[0] ?? [];
  let size = 0;
  for (const column of columns.slice(1)) {
    for (let i = 0; i < column.length; i++) {
      const [time, value] = [times[i] as number, column[i]];
      if (time >= from && time <= to && value != null && Number.isFinite(value)) size = Math.max(size, Math.abs(value));
    }
  }
  return size;
}
