/**
 * Widths of text without a browser, so that a page, a notebook and a static file place everything alike.
 *
 * Widths are those of Helvetica and of the fonts that share its metrics (Arial, Liberation Sans), in thousandths of the
 * size, from Adobe's font metrics. Every text is drawn with its length, so another font is fitted to the place.
 */

export const FONT = "Helvetica, Arial, 'Liberation Sans', sans-serif";

const REGULAR: Readonly<Record<string, number>> = {
  " ": 278, "!": 278, '"': 355, "#": 556, $: 556, "%": 889, "&": 667, "'": 191, "(": 333, ")": 333, "*": 389, "+": 584,
  ",": 278, "-": 333, ".": 278, "/": 278, ":": 278, ";": 278, "<": 584, "=": 584, ">": 584, "?": 556, "@": 1015,
  A: 667, B: 667, C: 722, D: 722, E: 667, F: 611, G: 778, H: 722, I: 278, J: 500, K: 667, L: 556, M: 833, N: 722,
  O: 778, P: 667, Q: 778, R: 722, S: 667, T: 611, U: 722, V: 667, W: 944, X: 667, Y: 667, Z: 611, "[": 278, "]": 278,
  _: 556, a: 556, b: 556, c: 500, d: 556, e: 556, f: 278, g: 556, h: 556, i: 222, j: 222, k: 500, l: 222, m: 833,
  n: 556, o: 556, p: 556, q: 556, r: 333, s: 500, t: 278, u: 556, v: 500, w: 722, x: 500, y: 500, z: 500, "…": 1000,
};
const OTHER = 600;
const BOLD = 1.06;

/** The width of a text in px. */
export function widthOf(text: string, size: number, bold = false): number {
  let sum = 0;
  for (const letter of text) sum += REGULAR[letter] ?? (letter >= "0" && letter <= "9" ? 556 : OTHER);
  return (sum * size * (bold ? BOLD : 1)) / 1000;
}

/** The text, shortened in the middle where it is longer than some letters. */
export function shortened(text: string, most: number): string {
  if (text.length <= most) return text;
  const head = Math.ceil((most - 1) / 2);
  return `${text.slice(0, head)}…${text.slice(text.length - (most - 1 - head))}`;
}
