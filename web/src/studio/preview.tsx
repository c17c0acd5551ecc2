/** What a scenario does to a model: its inputs over time. */

import { axisUnit } from "../views/format.ts";
import { ticks } from "../views/strip.ts";
import type { ScenarioSheet } from "./api.ts";

const WIDTH = 320;
const HEIGHT = 92;
const LEFT = 46;
const RIGHT = 8;
const TOP = 18;
const BOTTOM = 18;
const MOST = 4; // inputs that are drawn

interface PreviewProps {
  readonly scenario: ScenarioSheet;
  readonly until: number | null;
}

export function Preview({ scenario, until }: PreviewProps) {
  if (scenario.inputs.length === 0) return <p class="hint">{scenario.name}: no inputs; what moves the model is in the model.</p>;
  return (
    <div class="previews">
      {scenario.inputs.slice(0, MOST).map((input) => (
        <Input key={input.path} input={input} until={until} />
      ))}
      {scenario.inputs.length > MOST && <p class="hint">and {scenario.inputs.length - MOST} more inputs</p>}
    </div>
  );
}

function Input({ input, until }: { input: ScenarioSheet["inputs"][number]; until: number | null }) {
  const { times, values } = input;
  const [from, to] = [times[0] ?? 0, times.at(-1) ?? 1];
  let [low, high] = [Math.min(...values), Math.max(...values)];
  if (low === high) [low, high] = [low - 1, high + 1];
  const unit = axisUnit(Math.max(Math.abs(low), Math.abs(high)), input.unit);
  const x = (time: number): number => LEFT + ((WIDTH - LEFT - RIGHT) * (time - from)) / (to - from || 1);
  const y = (value: number): number => TOP + ((HEIGHT - TOP - BOTTOM) * (high - value)) / (high - low);
  const d = times.map((time, i) => `${i === 0 ? "M" : "L"}${x(time).toFixed(1)} ${y(values[i] ?? 0).toFixed(1)}`).join("");
  const text = `${input.path}${unit.text === "" ? "" : ` [${unit.text}]`}`;
  return (
    <svg class="preview" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={`${text}, from ${low} to ${high}`}>
      <text class="head" x={LEFT} y="11">{text}</text>
      {ticks(low, high, 3).map((value) => (
        <g key={value}>
          <line x1={LEFT} x2={WIDTH - RIGHT} y1={y(value)} y2={y(value)} />
          <text x={LEFT - 5} y={y(value) + 3.5} text-anchor="end">{Number((value / unit.factor).toPrecision(4))}</text>
        </g>
      ))}
      {ticks(from, to, 4).map((time) => (
        <text key={time} x={x(time)} y={HEIGHT - 5} text-anchor="middle">{Number(time.toPrecision(6))}</text>
      ))}
      <path d={d} />
      {until !== null && until < to && <rect class="beyond" x={x(until)} y={TOP} width={WIDTH - RIGHT - x(until)} height={HEIGHT - TOP - BOTTOM} />}
    </svg>
  );
}
