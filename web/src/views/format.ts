/** Numbers for readers. */

const PREFIXES: readonly [number, string][] = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
];
const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** A share as a percentage with some digits behind the point, or with so many significant ones. */
export function percent(share: number | null, digits: number, significantDigits?: number): string {
  if (share === null) return "–";
  const value = 100 * share;
  return `${significantDigits === undefined ? value.toFixed(digits) : Number(value.toPrecision(significantDigits))} %`;
}

/** Units that are written with a prefix; rad/s or Pa.s2/m6 stay as they are, and so do bar, rpm or km/h. */
const takesPrefix = (unit: string): boolean => /^(m|s|N|Pa|J|W|V|A|C|F|H|Hz|Wb|T|N\.m)$/.test(unit);

/** How a unit is written: a plain number has none. */
export const unitText = (unit: string): string => (unit === "1" ? "" : unit);

/** A value with four significant digits and a prefix of its unit. */
export function significant(value: number | null, unit: string, digits = 4): string {
  if (value === null) return "–";
  if (value === 0) return `0 ${unitText(unit)}`.trim();
  if (!takesPrefix(unit)) return `${Number(value.toPrecision(digits))} ${unitText(unit)}`.trim();
  const size = Math.abs(value);
  const [factor, prefix] = PREFIXES.find(([least]) => size >= least) ?? ([1e-6, "µ"] as const);
  return `${Number((value / factor).toPrecision(digits))} ${prefix}${unit}`;
}

/** How an axis is written: its unit in words, and what values are divided by. */
export interface AxisUnit {
  readonly text: string;
  readonly factor: number;
}

/** The unit of an axis whose greatest value has a size, so that its numbers stay short: MPa, or 10⁶ Pa.s/m3. */
export function axisUnit(size: number, of: string): AxisUnit {
  const unit = unitText(of);
  if (!Number.isFinite(size) || size === 0) return { text: unit, factor: 1 };
  if (takesPrefix(unit)) {
    const found = PREFIXES.find(([least]) => size >= least * 0.9999) ?? ([1e-6, "µ"] as const);
    return { text: `${found[1]}${unit}`, factor: found[0] };
  }
  const exponent = size >= 1e4 || size < 1e-2 ? 3 * Math.floor(Math.log10(size) / 3) : 0;
  return exponent === 0 ? { text: unit, factor: 1 } : { text: `10${raised(exponent)} ${unit}`.trim(), factor: 10 ** exponent };
}

function raised(exponent: number): string {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPT[Number(digit)]).join("");
  return exponent < 0 ? `⁻${digits}` : digits;
}

/** A duration for readers. */
export function duration(seconds: number | null): string {
  if (seconds === null || !Number.isFinite(seconds)) return "–";
  if (seconds < 60) return `${seconds < 10 ? seconds.toFixed(1) : Math.round(seconds)} s`;
  const minutes = Math.floor(seconds / 60);
  if (minutes < 60) return `${minutes} min ${Math.round(seconds - 60 * minutes)} s`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** A time of a run. */
export const instant = (time: number): string => `${Number(time.toPrecision(6))} s`;
