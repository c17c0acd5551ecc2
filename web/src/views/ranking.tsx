/** The ranking: bars with the cumulative line, the threshold as slider and as line, and the table of decisions. */

import { useEffect, useRef, useState } from "preact/hooks";
import { activityColour, LEAST, level } from "../graph/notation.ts";
import { keptBy, type RankedRow } from "./data.ts";
import { instant, percent, significant } from "./format.ts";
import { useKept } from "./kept.ts";
import { PathText } from "./path.tsx";
import { csvOf, saveCsv } from "./saving.ts";
import type { Lock, RankingState } from "./state.ts";

const HEIGHT = 230;
const LEFT = 46;
const RIGHT = 46;
const TOP = 12;
const BOTTOM = 24;
const WIDEST = 64; // of a bar, px

interface RankingProps {
  readonly state: RankingState;
  /** Whether rows can be made to stay or to go; otherwise the table tells what was decided. */
  readonly canLock?: boolean;
}

export function RankingView({ state, canLock }: RankingProps) {
  const rows = state.rows.value;
  const total = rows.reduce((sum, row) => sum + row.activity, 0);
  const staying = state.staying.value;
  const kept = staying.size;
  const share = rows.reduce((sum, row) => sum + (staying.has(row.path) ? row.index : 0), 0);
  return (
    <div class="ranking">
      <div class="tools threshold">
        <label for="threshold">threshold</label>
        <input
          id="threshold"
          type="range"
          min="0"
          max="1"
          step="any"
          value={toSlider(state.threshold.value)}
          onInput={(event) => state.setThreshold(fromSlider(Number(event.currentTarget.value)))}
          onKeyDown={(event) => step(event, state)}
        />
        <output for="threshold" data-kept={kept} data-threshold={state.kept.value}>
          {percent(state.threshold.value, 2)} keeps {kept} of {rows.length} elements, {percent(share, 2)} of{" "}
          {significant(total, "J")}
        </output>
      </div>
      <Window state={state} />
      <Bars state={state} />
      <Table state={state} canLock={canLock === true} />
    </div>
  );
}

/** The part of the run that is ranked: a short manoeuvre must not be lost in a long mission. */
function Window({ state }: { state: RankingState }) {
  const last = state.times.length - 1;
  const [from, to] = state.window.value ?? [0, last];
  const time = (place: number): string => instant(state.times[place] ?? 0);
  const move = (first: number, second: number): void =>
    state.setWindow([Math.min(first, second - 1), Math.max(second, first + 1)]);
  return (
    <div class="tools window">
      <label for="from">ranked from</label>
      <input id="from" type="range" min="0" max={last - 1} value={from} onInput={(event) => move(Number(event.currentTarget.value), Math.max(to, Number(event.currentTarget.value) + 1))} />
      <label for="to">to</label>
      <input id="to" type="range" min="1" max={last} value={to} onInput={(event) => move(Math.min(from, Number(event.currentTarget.value) - 1), Number(event.currentTarget.value))} />
      <output for="from to">
        {time(from)} to {time(to)}
      </output>
      <button type="button" disabled={state.window.value === null} onClick={() => state.setWindow(null)}>whole run</button>
    </div>
  );
}

/** Most of the slider's way is between 90 % and 100 %, where decisions are made. */
const toSlider = (threshold: number): number => 1 - Math.sqrt(1 - threshold);
const fromSlider = (place: number): number => Math.round((1 - (1 - place) ** 2) * 1e5) / 1e5;

/** Arrow keys move by one element. */
function step(event: KeyboardEvent, state: RankingState): void {
  const by = event.key === "ArrowRight" || event.key === "ArrowUp" ? 1 : event.key === "ArrowLeft" || event.key === "ArrowDown" ? -1 : 0;
  if (by === 0) return;
  event.preventDefault();
  const rows = state.rows.value;
  // Rows without activity of their own cannot be told apart by a threshold, and are passed over together.
  for (let wanted = state.kept.value + by; wanted >= 0 && wanted <= rows.length; wanted += by) {
    const threshold = wanted === 0 ? 0 : wanted === rows.length ? 1 : (rows[wanted - 1]?.cumulative ?? 1);
    if (keptBy(rows, threshold) === state.kept.value) continue;
    state.setThreshold(threshold);
    return;
  }
}

function Bars({ state }: { state: RankingState }) {
  const svg = useRef<SVGSVGElement>(null);
  const width = useWidth(svg);
  const kept = useKept();
  const rows = state.rows.value;
  const staying = state.staying.value;
  const wide = Math.min(WIDEST, (width - LEFT - RIGHT) / Math.max(1, rows.length));
  const high = HEIGHT - TOP - BOTTOM;
  const y = (part: number): number => TOP + high * (1 - part);
  const line = rows.map((row, i) => `${i === 0 ? "M" : "L"}${LEFT + wide * (i + 0.5)} ${y(row.cumulative)}`).join("");
  const at = y(state.threshold.value);
  const drag = (event: PointerEvent): void => {
    if (event.buttons === 0 || svg.current === null) return;
    const box = svg.current.getBoundingClientRect();
    const place = ((event.clientY - box.top) / box.height) * HEIGHT;
    state.setThreshold(Math.round((1 - (place - TOP) / high) * 1e3) / 1e3);
  };
  const decades = Array.from({ length: Math.round(-Math.log10(LEAST)) + 1 }, (_, i) => 10 ** -i);
  return (
    <svg ref={svg} class="bars" viewBox={`0 0 ${width} ${HEIGHT}`} role="img" aria-label="Activity indices and their sum">
      {decades.map((share) => (
        <g key={share} class="axis">
          <line x1={LEFT} x2={width - RIGHT} y1={y(level(share))} y2={y(level(share))} />
          <text x={LEFT - 6} y={y(level(share)) + 4} text-anchor="end">{percent(share, 0, 3)}</text>
        </g>
      ))}
      {[0, 0.25, 0.5, 0.75, 1].map((part) => (
        <text key={part} class="axis" x={width - RIGHT + 6} y={y(part) + 4}>{percent(part, 0)}</text>
      ))}
      {rows.map((row, i) => {
        const chosen = state.graph.selected.value === row.path;
        return kept(row.path, [i, row.index, row.cumulative, width, staying.has(row.path), chosen].join(" "), () => (
          <rect
            key={row.path}
            class={`bar ${staying.has(row.path) ? "" : "below"} ${chosen ? "chosen" : ""}`}
            data-row={row.path}
            x={LEFT + wide * i + 0.5}
            width={Math.max(1, wide - 1)}
            y={y(level(row.index))}
            height={Math.max(0.5, high * level(row.index))}
            fill={staying.has(row.path) ? activityColour(row.index) : "none"}
            onClick={() => state.graph.show(row.path)}
          >
            <title>{`${i + 1}. ${row.path}: ${percent(row.index, 3)}, together ${percent(row.cumulative, 2)}`}</title>
          </rect>
        ));
      })}
      <path class="sum" d={line} />
      <g class="threshold" onPointerDown={(event) => (event.currentTarget as Element).setPointerCapture(event.pointerId)} onPointerMove={drag}>
        <line class="grip" x1={LEFT} x2={width - RIGHT} y1={at} y2={at} />
        <line x1={LEFT} x2={width - RIGHT} y1={at} y2={at} />
      </g>
      <text class="axis" x={LEFT} y={HEIGHT - 6}>activity index (bars, left) and sum (line, right) of {rows.length} elements</text>
    </svg>
  );
}

/** The width of a drawing on the page, px, so that its letters have their size. */
function useWidth(svg: { readonly current: SVGSVGElement | null }): number {
  const [width, setWidth] = useState(900);
  useEffect(() => {
    if (svg.current === null) return;
    const watched = new ResizeObserver(([entry]) => entry !== undefined && setWidth(Math.max(300, Math.round(entry.contentRect.width))));
    watched.observe(svg.current);
    return () => watched.disconnect();
  }, []);
  return width;
}

function Table({ state, canLock }: { state: RankingState; canLock: boolean }) {
  const place = useRef<HTMLTableElement>(null);
  const kept = useKept();
  const staying = state.staying.value;
  const isReduced = state.data.rows.some((row) => row.reason !== "" || row.verdict !== "kept");
  return (
    <>
      <div class="scroll" tabIndex={0} role="region" aria-label="Ranking">
        <table ref={place}>
          <thead>
            <tr>
              <th>rank</th>
              <th>element</th>
              <th>kind</th>
              <th class="number">activity</th>
              <th class="number">index</th>
              <th class="number">sum</th>
              <th>stays</th>
              {canLock && <th>lock</th>}
              {isReduced && <th>decision</th>}
              {isReduced && <th>because</th>}
            </tr>
          </thead>
          <tbody>
            {state.rows.value.map((row, i) => {
              const shown = [i, row.activity, row.index, row.cumulative, staying.has(row.path), i < state.kept.value, state.graph.selected.value === row.path, state.locks.value.get(row.path)];
              return kept(row.path, shown.join(" "), () => <Row key={row.path} state={state} row={row} rank={i} canLock={canLock} isReduced={isReduced} />);
            })}
          </tbody>
        </table>
      </div>
      <div class="tools below-table">
        <button type="button" onClick={() => place.current !== null && saveCsv(csvOf(place.current), `activity of ${state.data.model}`)}>CSV</button>
      </div>
    </>
  );
}

interface RowProps {
  readonly state: RankingState;
  readonly row: RankedRow;
  readonly rank: number;
  readonly canLock: boolean;
  readonly isReduced: boolean;
}

function Row({ state, row, rank, canLock, isReduced }: RowProps) {
  // The table knows when a row changes; the row itself listens to nothing.
  const stays = state.staying.peek().has(row.path);
  const chosen = state.graph.selected.peek() === row.path;
  return (
    <tr
      data-row={row.path}
      data-activity={row.activity}
      class={`${stays ? "" : "below"} ${chosen ? "chosen" : ""}`}
      onClick={() => state.graph.show(row.path)}
    >
      <td class="number">{rank + 1}</td>
      <td class="path">
        <button type="button" class="plain" onClick={() => state.graph.show(row.path)}><PathText path={row.path} /></button>
      </td>
      <td>{row.kind}</td>
      <td class="number" data-value={row.activity}>{significant(row.activity, "J")}</td>
      <td class="number" data-value={row.index}>{percent(row.index, 3)}</td>
      <td class="number" data-value={row.cumulative}>{percent(row.cumulative, 2)}</td>
      <td>{rank < state.kept.peek() ? "keeps" : "below"}</td>
      {canLock && <Locks state={state} row={row.path} />}
      {isReduced && <td class={row.verdict}>{row.verdict}</td>}
      {isReduced && <td>{row.meaning === "" ? row.reason : `${row.meaning}: ${row.reason}`}</td>}
    </tr>
  );
}

/** Make a row stay or go at every threshold; the same again leaves it to the threshold. */
function Locks({ state, row }: { state: RankingState; row: string }) {
  const now = state.locks.peek().get(row);
  const one = (lock: Lock, words: string) => (
    <button
      type="button"
      class="lock"
      aria-pressed={now === lock}
      aria-label={`${words} ${row} at every threshold`}
      onClick={(event) => {
        event.stopPropagation();
        state.lock(row, now === lock ? null : lock);
      }}
    >
      {words}
    </button>
  );
  return (
    <td class="locks">
      {one("keep", "keep")}
      {one("go", "drop")}
    </td>
  );
}
