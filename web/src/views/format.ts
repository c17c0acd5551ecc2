/** Numbers for readers. */

const PREFIXES: readonly [number, string][] = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
];

/** A share as a percentage with some digits behind the point, or with so many significant ones. */
export function percent(share: number | null, digits: number, significantDigits?: number): string {
  if (share === null) return "–";
  const value = 100 * share;
  return `${significantDigits === undefined ? value.toFixed(digits) : Number(value.toPrecision(significantDigits))} %`;
}

/** A value with four significant digits and a prefix of its unit. */
export function significant(value: number | null, unit: string): string {
  if (value === null) return "–";
  if (value === 0) return `0 ${unit}`.trim();
  const size = Math.abs(value);
  // Prefixes are for units of one symbol; rad/s stays as it is.
  const [factor, prefix] = /^[A-Za-z]{1,2}$/.test(unit)
    ? (PREFIXES.find(([least]) => size >= least) ?? ([1e-6, "µ"] as const))
    : ([1, ""] as const);
  return `${Number((value / factor).toPrecision(4))} ${prefix}${unit}`.trim();
}
