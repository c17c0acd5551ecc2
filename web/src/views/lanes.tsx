/** Signals over time: one lane for each quantity, one time axis and one cursor; full model against reduced. */

import { useEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { numbers, type SignalData, type StudyData } from "./data.ts";
import type { State } from "./state.ts";

const HEIGHT = 150;

/** A signal with its columns unpacked. */
export interface Columns extends Omit<SignalData, "full" | "reduced"> {
  readonly full: ArrayLike<number>;
  readonly reduced: ArrayLike<number> | null;
}

/** What is drawn above one another on one scale. */
export interface Lane {
  readonly title: string;
  readonly unit: string;
  readonly items: readonly Columns[];
}

export function LanesView({ state }: { state: State }) {
  const lanes = lanesOf(state.data);
  const times = numbers(state.data.signals.times);
  return (
    <div class="lanes">
      <p class="hint">Drag to zoom all lanes, double click to see everything. Full lines: the full model; dashed: the reduced one.</p>
      {lanes.map((lane) => (
        <LanePlot key={lane.title} lane={lane} times={times} state={state} />
      ))}
    </div>
  );
}

function lanesOf(data: StudyData): Lane[] {
  const found = new Map<string, { title: string; unit: string; items: Columns[] }>();
  for (const item of data.signals.items) {
    const lane = found.get(item.panel) ?? { title: item.panel, unit: item.unit, items: [] };
    lane.items.push({ ...item, full: numbers(item.full), reduced: item.reduced === null ? null : numbers(item.reduced) });
    found.set(item.panel, lane);
  }
  return [...found.values()];
}

export function LanePlot({ lane, times, state }: { lane: Lane; times: ArrayLike<number>; state: State }) {
  const place = useRef<HTMLDivElement>(null);
  const theme = state.theme.value;
  useEffect(() => {
    const element = place.current;
    if (element === null) return;
    const style = getComputedStyle(document.documentElement);
    const ink = style.getPropertyValue("--ink");
    const grid = style.getPropertyValue("--line");
    const colours = [1, 2, 3, 4].map((i) => style.getPropertyValue(`--series-${i}`));
    const series: uPlot.Series[] = [{ label: "time", value: (_, t) => (t === null ? "–" : `${Number(t.toPrecision(6))} s`) }];
    const columns: ArrayLike<number>[] = [times];
    lane.items.forEach((item, i) => {
      const stroke = colours[i % colours.length] as string;
      const name = item.label;
      const value = (_: uPlot, v: number | null): string => (v === null ? "–" : `${Number(v.toPrecision(5))} ${item.unit}`);
      series.push({ label: name, stroke, width: 1.4, value, points: { show: false } });
      columns.push(item.full);
      if (item.reduced !== null) {
        series.push({ label: `${name}, reduced`, stroke, width: 1.4, dash: [6, 4], value, points: { show: false } });
        columns.push(item.reduced);
      }
    });
    const plot = new uPlot(
      {
        width: element.clientWidth,
        height: HEIGHT,
        title: `${lane.title}${lane.unit === "" ? "" : ` [${lane.unit}]`}`,
        cursor: { sync: { key: "lanes", setSeries: false }, drag: { x: true, y: false } },
        scales: { x: { time: false } },
        axes: [
          { stroke: ink, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid }, size: 26, values: (_, ticks) => ticks.map((t) => `${t}`) },
          { stroke: ink, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid }, size: 64 },
        ],
        series,
        hooks: {
          setScale: [
            (own, key) => {
              if (key === "x") together(own);
            },
          ],
        },
      },
      columns as unknown as uPlot.AlignedData,
      element,
    );
    plots.add(plot);
    const resized = new ResizeObserver(() => plot.setSize({ width: element.clientWidth, height: HEIGHT }));
    resized.observe(element);
    return () => {
      resized.disconnect();
      plots.delete(plot);
      plot.destroy();
    };
  }, [lane.title, theme]);
  return <div class="lane" ref={place} data-paths={lane.items.map((item) => item.path).join(" ")} />;
}

const plots = new Set<uPlot>();
let isZooming = false;

/** All lanes show the same time. */
function together(source: uPlot): void {
  if (isZooming) return;
  isZooming = true;
  const { min, max } = source.scales.x ?? {};
  for (const plot of plots) if (plot !== source && min != null && max != null) plot.setScale("x", { min, max });
  isZooming = false;
}
