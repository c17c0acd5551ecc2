/** The models that a search has tried: size against error over tolerance, with those to take marked. */

import type { Tried } from "./data.ts";

const WIDTH = 900;
const HEIGHT = 260;
const LEFT = 60;
const BOTTOM = 40;
const TOP = 16;
const RIGHT = 20;

export function FrontView({ tried }: { tried: readonly Tried[] }) {
  const measured = tried.filter((one): one is Tried & { score: number } => one.score !== null);
  const failed = tried.length - measured.length;
  if (measured.length === 0) return <p class="hint">No model that was tried could be run.</p>;
  const sizes = measured.map((one) => one.rows);
  const [least, most] = [Math.min(...sizes), Math.max(...sizes)];
  const logs = measured.map((one) => Math.log10(Math.max(one.score, 1e-3)));
  const [low, high] = [Math.min(-1, Math.floor(Math.min(...logs))), Math.max(1, Math.ceil(Math.max(...logs)))];
  const x = (rows: number): number => LEFT + ((WIDTH - LEFT - RIGHT) * (rows - least + 0.5)) / (most - least + 1);
  const y = (log: number): number => TOP + ((HEIGHT - TOP - BOTTOM) * (high - log)) / (high - low);
  const decades = Array.from({ length: high - low + 1 }, (_, i) => low + i);
  return (
    <figure>
      <svg class="front" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label="Error over tolerance against size">
        {decades.map((log) => (
          <g key={log} class="axis">
            <line x1={LEFT} x2={WIDTH - RIGHT} y1={y(log)} y2={y(log)} />
            <text x={LEFT - 6} y={y(log) + 4} text-anchor="end">{Number((10 ** log).toPrecision(1))}</text>
          </g>
        ))}
        <line class="limit" x1={LEFT} x2={WIDTH - RIGHT} y1={y(0)} y2={y(0)} />
        {[...new Set(sizes)].map((rows) => (
          <text key={rows} class="axis" x={x(rows)} y={HEIGHT - BOTTOM + 16} text-anchor="middle">{rows}</text>
        ))}
        {measured.map((one, i) => (
          <circle
            key={i}
            class={`tried ${one.score <= 1 ? "within" : "outside"} ${one.mark}`}
            cx={x(one.rows)}
            cy={y(Math.log10(Math.max(one.score, 1e-3)))}
            r={one.mark === "" ? 4 : 7}
          >
            <title>{`${one.rows} elements, ${one.states} states: ${one.score.toFixed(2)} of the tolerance, predicted ${one.predicted?.toFixed(2) ?? "–"}${one.mark === "" ? "" : ` (${one.mark})`}`}</title>
          </circle>
        ))}
        <text class="axis" x={LEFT} y={HEIGHT - 6}>elements that stay; up: largest error over its tolerance</text>
      </svg>
      <figcaption class="hint">
        {tried.length} models tried{failed === 0 ? "" : `, ${failed} of them without equations or without an end of the run`}. Filled: within
        the tolerances. Large: {measured.some((one) => one.mark === "recommended") ? "recommended, with a margin" : "none recommended"}
        {measured.some((one) => one.mark === "smallest") ? ", and the smallest" : ""}.
      </figcaption>
    </figure>
  );
}
