/** A drawing on a page: its size, what is marked in it, and how it is reached by keys. */

/** Letters of this height, px, can be read; smaller ones are left out and only fills remain. */
const LEGIBLE = 8;
const LETTERS = 12;
export const LEGIBLE_SCALE = LEGIBLE / LETTERS;
const THINGS = ".node, .closed, .group";

/** Show a drawing at a scale; its letters disappear where they could not be read. */
export function sized(svg: SVGSVGElement, scale: number): void {
  const { width, height } = svg.viewBox.baseVal;
  svg.style.width = `${Math.round(width * scale)}px`;
  svg.style.height = `${Math.round(height * scale)}px`;
  svg.classList.toggle("far", scale < LEGIBLE_SCALE - 1e-9);
}

/**
 * Make the things of a drawing reachable: one of them by the tabulator, the others from it by arrow keys. What they are called
 * says their title.
 */
export function reachable(svg: SVGSVGElement, name: string, first: string | null): void {
  svg.setAttribute("role", "group");
  svg.setAttribute("aria-label", `Bond graph of ${name}; arrow keys move, Enter selects or opens`);
  const things = [...svg.querySelectorAll<SVGElement>(THINGS)];
  const start = things.find((thing) => nameOf(thing) === first) ?? things.find((thing) => !thing.matches(".group")) ?? things[0];
  for (const thing of things) reach(thing, thing === start);
}

function reach(thing: SVGElement, isFirst: boolean): void {
  thing.setAttribute("tabindex", isFirst ? "0" : "-1");
  thing.setAttribute("role", "button");
  if (thing.matches(".closed")) thing.setAttribute("aria-expanded", "false");
  if (thing.matches(".group")) thing.setAttribute("aria-expanded", "true");
}

const SVG = "http://www.w3.org/2000/svg";

/** Put parts of a drawing in the place of those that differ; everything else, and the focus, stays as it is. */
export function repaint(svg: SVGSVGElement, before: readonly string[], after: readonly string[]): void {
  const changed = after.map((_, i) => i).filter((i) => after[i] !== before[i]);
  const made = document.createElementNS(SVG, "svg");
  made.innerHTML = changed.map((i) => after[i]).join("");
  const parts = [...made.children];
  const old = [...svg.children];
  changed.forEach((at, i) => {
    const [from, to] = [old[at] as SVGElement, parts[i] as SVGElement];
    if (from.hasAttribute("tabindex")) {
      reach(to, from.getAttribute("tabindex") === "0");
      for (const kind of ["chosen", "marked"]) to.classList.toggle(kind, from.classList.contains(kind));
      to.setAttribute("aria-pressed", from.getAttribute("aria-pressed") ?? "false");
    }
    const isFocused = from === document.activeElement;
    from.replaceWith(to);
    if (isFocused) to.focus();
  });
}

export const nameOf = (thing: SVGElement): string | undefined => thing.dataset.id ?? thing.dataset.group;

/** The thing next to another one in a direction, by the middles of their boxes. */
export function neighbour(svg: SVGSVGElement, from: SVGElement, key: string): SVGElement | null {
  const along = key === "ArrowLeft" || key === "ArrowRight" ? "x" : "y";
  const sense = key === "ArrowRight" || key === "ArrowDown" ? 1 : -1;
  const here = middle(from);
  let best: SVGElement | null = null;
  let least = Infinity;
  for (const thing of svg.querySelectorAll<SVGElement>(THINGS)) {
    if (thing === from) continue;
    const there = middle(thing);
    const ahead = sense * (there[along] - here[along]);
    const aside = Math.abs(along === "x" ? there.y - here.y : there.x - here.x);
    if (ahead < 2 || aside > 2 * ahead) continue;
    const far = ahead + 2 * aside;
    if (far < least) [best, least] = [thing, far];
  }
  return best;
}

function middle(thing: SVGElement): { x: number; y: number } {
  // A frame is reached by its name, not by the middle of what is in it.
  const box = (thing.matches(".group") ? (thing.querySelector("text") ?? thing) : thing).getBoundingClientRect();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}

/** Mark what is selected, and what else is to be seen. */
export function mark(svg: SVGSVGElement, selected: string | null, marked: ReadonlySet<string>): void {
  for (const thing of svg.querySelectorAll<SVGElement>(THINGS)) {
    const { id, row, group } = thing.dataset;
    const holds = (path: string): boolean => group !== undefined && thing.matches(".closed") && path.startsWith(`${group}.`);
    // A closed group stands for what is in it.
    const isChosen = selected !== null && (id === selected || row === selected || group === selected || holds(selected));
    thing.classList.toggle("chosen", isChosen);
    thing.setAttribute("aria-pressed", String(isChosen));
    thing.classList.toggle("marked", [...marked].some(holds) || (id !== undefined && marked.has(id)) || (row !== undefined && marked.has(row)));
  }
}

/** Scroll the page around a drawing so that a thing is in view; nothing else moves. */
export function bring(page: HTMLElement, thing: Element): void {
  const [around, box] = [page.getBoundingClientRect(), thing.getBoundingClientRect()];
  if (box.left < around.left || box.right > around.right) page.scrollLeft += box.left + box.width / 2 - (around.left + around.width / 2);
  if (box.top < around.top || box.bottom > around.bottom) page.scrollTop += box.top + box.height / 2 - (around.top + around.height / 2);
}
