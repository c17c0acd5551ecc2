/** Signals over time: a lane for each quantity, with one time axis, one cursor and one zoom for all. */

import { signal, useComputed, useSignal, useSignalEffect, type ReadonlySignal, type Signal } from "@preact/signals";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Theme } from "../graph/notation.ts";
import { instant } from "./format.ts";
import { COLOURS, LanePlot, lineKey, type Lane, type LaneColumns, type Line } from "./plot.tsx";
import { csv, saveCsv, savePictureText } from "./saving.ts";
import type { Series, Source, Span } from "./source.ts";
import { lanesPicture } from "./strip.ts";

/** A signal in a unit for readers. */
export interface LaneSignal {
  readonly path: string;
  readonly label: string;
  readonly factor: number; // from the unit of the source to the one that is shown
  readonly runs?: readonly string[]; // that have it, where not all do
}

/** Signals that share a scale. */
export interface LaneGroup {
  readonly title: string;
  readonly unit: string; // as shown
  readonly signals: readonly LaneSignal[];
}

/** A run whose lines have a pen of their own. */
export interface LaneRun {
  readonly id: string;
  readonly name: string;
}

/** Pens of runs laid over one another, told apart without colour. */
export const PENS: readonly (readonly number[])[] = [[], [7, 4], [2, 3], [9, 3, 2, 3]];
const HEIGHT = 150;
const DIFFERENCE_HEIGHT = 100;

interface LanesProps {
  readonly source: Source;
  readonly groups: readonly LaneGroup[];
  readonly runs: readonly LaneRun[];
  /** The run (of the source) that has the second run less the first, drawn below each lane. */
  readonly difference?: string;
  readonly whole: Span;
  readonly zoom: Zoom;
  readonly theme: ReadonlySignal<Theme>;
  readonly name: string;
  readonly height?: number;
  /** Changes when runs have more to show. */
  readonly version?: ReadonlySignal<number>;
}

/** Which part of the time is shown, null for all of it. */
export interface Zoom {
  readonly span: ReadonlySignal<Span | null>;
  readonly set: (span: Span | null) => void;
}

/** A zoom that no address holds. */
export function ownZoom(): Zoom {
  const span = signal<Span | null>(null);
  return { span, set: (wanted) => (span.value = wanted) };
}

let made = 0;

export function LanesView({ source, groups, runs, difference, whole, zoom, theme, name, height, version }: LanesProps) {
  const box = useRef<HTMLDivElement>(null);
  const cursor = useSignal<number | null>(null);
  const exact = useSignal<ReadonlyMap<string, number> | null>(null);
  const [series, setSeries] = useState<ReadonlyMap<string, Series>>(new Map());
  const [fault, setFault] = useState("");
  const isReading = useSignal(false);
  const key = useMemo(() => `lanes-${(made += 1)}`, []);
  const wholeNow = useSignal(whole);
  wholeNow.value = whole;
  const span = useComputed<Span>(() => zoom.span.value ?? wholeNow.value);
  const lanes = useMemo(() => lanesOf(groups, runs, difference), [groups, runs, difference]);
  const paths = useMemo(() => [...new Set(groups.flatMap((group) => group.signals.map((signal) => signal.path)))], [groups]);
  const wanted = useMemo(() => [...runs.map((run) => run.id), ...(difference === undefined ? [] : [difference])], [runs, difference]);

  const turn = useRef(0);
  const load = async (): Promise<void> => {
    const mine = (turn.current += 1);
    const count = Math.max(200, Math.round((box.current?.clientWidth ?? 1000) - 300));
    isReading.value = true;
    try {
      const found = await Promise.all(
        wanted.map(async (run) => [run, paths.length === 0 ? EMPTY : await source.series(run, paths, span.peek(), count)] as const),
      );
      if (mine !== turn.current) return;
      setSeries(new Map(found));
      setFault("");
    } catch (error) {
      if (mine === turn.current) setFault(error instanceof Error ? error.message : String(error));
    } finally {
      if (mine === turn.current) isReading.value = false;
    }
  };
  const seen = useComputed(() => `${span.value.join(" ")} ${version?.value ?? 0}`).value;
  useEffect(() => void load(), [source, paths.join(" "), wanted.join(" "), seen]);
  useExact(source, groups, runs, series, cursor, exact);

  const columns = useMemo(() => lanes.map((lane) => columnsOf(lane, groups, series)), [lanes, series]);
  const shared = { theme, span, cursor, zoom: zoom.set };
  const typed = (event: KeyboardEvent): void => {
    const count = columns[0]?.[0]?.length ?? 0;
    const [from, to] = span.peek();
    const at = cursor.peek() ?? Math.floor(count / 2);
    const by = event.shiftKey ? Math.ceil(count / 50) : 1;
    if (event.key === "ArrowRight") cursor.value = Math.min(count - 1, at + by);
    else if (event.key === "ArrowLeft") cursor.value = Math.max(0, at - by);
    else if (event.key === "+" || event.key === "-") {
      const middle = (columns[0]?.[0]?.[at] as number | undefined) ?? (from + to) / 2;
      const half = ((to - from) / 2) * (event.key === "+" ? 0.5 : 2);
      const next: Span = [Math.max(whole[0], middle - half), Math.min(whole[1], middle + half)];
      zoom.set(next[0] === whole[0] && next[1] === whole[1] ? null : next);
    } else if (event.key === "Home") zoom.set(null);
    else return;
    event.preventDefault();
  };
  const time = useComputed(() => {
    const at = cursor.value;
    return at === null ? "" : instant((columns[0]?.[0]?.[at] as number | undefined) ?? NaN);
  });
  return (
    <div class="lanes" ref={box}>
      <div class="tools" role="toolbar" aria-label={name}>
        <output class="time" aria-label="Time at the cursor">{series.size === 0 && isReading.value ? "reading …" : time.value === "" ? "–" : time}</output>
        <button type="button" disabled={zoom.span.value === null} onClick={() => zoom.set(null)}>whole run</button>
        <span class="hint">drag to zoom all lanes, double click to see everything</span>
        <span class="gap" />
        <button type="button" onClick={() => saveCsv(csvOf(lanes, columns), name)}>CSV</button>
        <button type="button" onClick={() => savePlots("svg")}>SVG</button>
        <button type="button" onClick={() => savePlots("png")}>PNG</button>
      </div>
      {fault !== "" && <p class="fault" role="alert">{fault}</p>}
      <div class="strip" aria-busy={isReading.value} tabIndex={0} role="group" aria-label={`${name}: arrow keys move the cursor, + and - zoom, Home shows everything`} onKeyDown={typed}>
        {lanes.map((lane, i) => (
          <LanePlot
            key={lane.key}
            lane={lane}
            columns={columns[i] as LaneColumns}
            shared={shared}
            height={lane.key.startsWith("difference") ? DIFFERENCE_HEIGHT : (height ?? HEIGHT)}
            group={key}
            exact={exact}
          />
        ))}
      </div>
    </div>
  );

  function savePlots(kind: "svg" | "png"): void {
    const picture = lanesPicture(lanes, columns, span.peek());
    void savePictureText(picture.text, picture.width, picture.height, name, kind);
  }
}

const EMPTY: Series = { times: [], columns: new Map() };

/** One lane for each group, with a line for each signal of each run; and below it one of differences. */
export function lanesOf(groups: readonly LaneGroup[], runs: readonly LaneRun[], difference: string | undefined): Lane[] {
  return groups.flatMap((group) => {
    const linesOf = (run: string, label: (signal: LaneSignal) => string, dash: readonly number[]): Line[] =>
      group.signals.flatMap((signal, i) => {
        const isThere = signal.runs === undefined || signal.runs.includes(run);
        return isThere ? [{ run, path: signal.path, label: label(signal), colour: (i % COLOURS) + 1, dash }] : [];
      });
    const several = group.signals.length > 1;
    const named = (run: LaneRun) => (signal: LaneSignal): string =>
      runs.length === 1 ? signal.label : several ? `${signal.label}, ${run.name}` : run.name;
    const lines = runs.flatMap((run, pen) => linesOf(run.id, named(run), PENS[pen % PENS.length] as readonly number[]));
    const found: Lane[] = [{ key: `values ${group.title}`, title: group.title, unit: group.unit, lines }];
    if (difference !== undefined) {
      const lines = linesOf(difference, (signal) => (several ? signal.label : "difference"), []);
      if (lines.length > 0) found.push({ key: `difference ${group.title}`, title: "difference", unit: group.unit, lines });
    }
    return found;
  });
}

/** The columns of a lane in the unit that is shown. */
function columnsOf(lane: Lane, groups: readonly LaneGroup[], series: ReadonlyMap<string, Series>): LaneColumns {
  const factors = new Map(groups.flatMap((group) => group.signals.map((signal) => [signal.path, signal.factor] as const)));
  const times = lane.lines.map((line) => series.get(line.run)?.times).find((found) => found !== undefined && found.length > 0) ?? [];
  return [
    times,
    ...lane.lines.map((line) => {
      const column = series.get(line.run)?.columns.get(line.path);
      const factor = factors.get(line.path) ?? 1;
      const shown = new Array<number | null>(times.length);
      for (let i = 0; i < times.length; i++) {
        const value = column?.[i];
        // A gap in a line is null for the plot.
        shown[i] = value === undefined || Number.isNaN(value) ? null : value * factor;
      }
      return shown;
    }),
  ];
}

/** Ask for the samples next to the cursor where the source has more than what is drawn. */
function useExact(
  source: Source,
  groups: readonly LaneGroup[],
  runs: readonly LaneRun[],
  series: ReadonlyMap<string, Series>,
  cursor: Signal<number | null>,
  exact: Signal<ReadonlyMap<string, number> | null>,
): void {
  const waiting = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const latest = useRef({ groups, runs, series });
  latest.current = { groups, runs, series };
  useSignalEffect(() => {
    const at = cursor.value;
    exact.value = null;
    clearTimeout(waiting.current);
    if (at === null || source.values === undefined) return;
    waiting.current = setTimeout(() => {
      const now = latest.current;
      const time = [...now.series.values()].find((one) => one.times.length > 0)?.times[at];
      if (time === undefined || source.values === undefined) return;
      const signals = now.groups.flatMap((group) => group.signals);
      void Promise.all(
        now.runs.map(async (run) => [run.id, await source.values?.(run.id, signals.map((signal) => signal.path), time)] as const),
      ).then((found) => {
        if (cursor.peek() !== at) return;
        const values = new Map<string, number>();
        for (const [run, known] of found) {
          for (const signal of signals) {
            const value = known?.get(signal.path);
            if (value !== undefined) values.set(lineKey({ run, path: signal.path }), value * signal.factor);
          }
        }
        exact.value = values;
      }, () => undefined /* what is drawn is shown instead */);
    }, 80);
  });
}

function csvOf(lanes: readonly Lane[], columns: readonly LaneColumns[]): string {
  const times = columns[0]?.[0] ?? [];
  const heads = lanes.flatMap((lane) => lane.lines.map((line) => `${lane.title}: ${line.label}${lane.unit === "" ? "" : ` [${lane.unit}]`}`));
  const rows = Array.from(times, (time, i) => [
    String(time),
    ...columns.flatMap((lane) => lane.slice(1).map((column) => (column[i] == null ? "" : String(column[i])))),
  ]);
  return csv([["time [s]", ...heads], ...rows]);
}
