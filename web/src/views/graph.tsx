/** The drawn graph: groups open and close, things are selected, it is zoomed, and what a threshold takes away is repainted. */

import { useComputed, useSignal, useSignalEffect, type ReadonlySignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { draw, drawnParts, type DrawingOptions } from "../graph/draw.ts";
import { noteOf } from "../graph/figures.ts";
import { fold } from "../graph/fold.ts";
import { place, type Layout, type Placer } from "../graph/layout.ts";
import { legendAlone, LEGEND_HEIGHT } from "../graph/legend.ts";
import type { Theme } from "../graph/notation.ts";
import type { Picture } from "../graph/picture.ts";
import { tag } from "../graph/xml.ts";
import { bring, LEGIBLE_SCALE, mark, nameOf, neighbour, reachable, repaint, sized } from "./canvas.ts";
import type { GraphChoices } from "./choices.ts";
import { savePictureText } from "./saving.ts";

const READABLE = 0.85; // of the size in which a drawing is made
const LARGEST = 1.5;
const STEP = 1.25;
const IDLE = 400; // ms without a change until layouts are made in advance
const NOTHING: ReadonlySet<string> = new Set();

interface GraphProps {
  readonly choices: GraphChoices;
  /** What is drawn now: the picture of the choices, with other activities or without removals. */
  readonly picture: ReadonlySignal<Picture>;
  readonly placer: Placer;
  readonly theme: ReadonlySignal<Theme>;
  readonly below?: ReadonlySignal<ReadonlySet<string>>;
  readonly marked?: ReadonlySignal<ReadonlySet<string>>;
  readonly label?: string;
  /** The page around the drawing has no height of its own, but grows with it. */
  readonly grows?: boolean;
  /** The whole drawing is shown at first where its letters can still be read. */
  readonly fits?: boolean;
  readonly children?: ComponentChildren; // more tools
}

/** What stands on the page, and how the same is drawn with its legend: its text and its size. */
interface Painted {
  readonly layout: Layout;
  readonly parts: readonly string[];
  readonly whole: () => [text: string, width: number, height: number];
}

export function GraphView({ choices, picture, placer, theme, below, marked, label, grows, fits, children }: GraphProps) {
  const page = useRef<HTMLDivElement>(null);
  const layouts = useRef(new Map<string, Promise<Layout>>());
  const turn = useRef(0);
  const isFirst = useRef(true);
  const painted = useRef<Painted | null>(null);
  /** px for a unit of the drawing; null chooses the usual one. */
  const scale = useSignal<number | "fit" | null>(null);

  const least = fits === true ? LEGIBLE_SCALE : READABLE;
  const svgNow = (): SVGSVGElement | null => page.current?.querySelector("svg") ?? null;
  const resize = (): void => {
    const svg = svgNow();
    if (svg !== null && page.current !== null) sized(svg, scaleOf(scale.peek(), svg, page.current, least));
  };
  const layoutOf = (open: ReadonlySet<string>): Promise<Layout> => {
    const key = [...open].sort().join(" ");
    let layout = layouts.current.get(key);
    if (layout === undefined) {
      layout = place(fold(choices.picture, open), placer);
      layouts.current.set(key, layout);
    }
    return layout;
  };
  /** What is likely to be opened next is placed while nobody waits for it. */
  const foresee = async (open: ReadonlySet<string>, mine: number): Promise<void> => {
    await new Promise((resolve) => setTimeout(resolve, IDLE));
    if (mine !== turn.current) return;
    for (const group of fold(choices.picture, open).closed) {
      if (mine !== turn.current || page.current === null) return;
      await layoutOf(new Set([...open, group.path]));
    }
  };
  useSignalEffect(() => {
    const open = choices.open.value;
    const shown = picture.value;
    const gone = below?.value ?? NOTHING;
    const colours = theme.value;
    turn.current += 1;
    const mine = turn.current;
    void layoutOf(open).then((placed) => {
      if (mine !== turn.current || page.current === null) return;
      // What is gone differs between two ways to look; where things are does not.
      const options: DrawingOptions = { theme: colours, legend: false, below: gone };
      const now = refreshed(placed, fold(shown, open, gone));
      const { attributes, parts } = drawnParts(shown, now, options);
      const before = painted.current;
      painted.current = { layout: placed, parts, whole: () => [draw(shown, now, { ...options, legend: true }), now.width, now.height + LEGEND_HEIGHT] };
      const svg = svgNow();
      if (svg !== null && before?.layout === placed && before.parts.length === parts.length) repaint(svg, before.parts, parts);
      else paint(page.current, tag("svg", attributes, parts.join("\n")), shown.name);
      document.body.dataset.ready = "true";
      void foresee(open, mine);
    });
  });
  useSignalEffect(() => {
    const selected = choices.selected.value;
    const seen = marked?.value ?? NOTHING;
    const svg = svgNow();
    if (svg === null || page.current === null) return;
    mark(svg, selected, seen);
    const chosen = svg.querySelector(".chosen");
    if (chosen !== null) bring(page.current, chosen);
  });
  useSignalEffect(() => {
    scale.value;
    resize();
  });
  useEffect(() => {
    if (page.current === null) return;
    const watched = new ResizeObserver(resize);
    watched.observe(page.current);
    return () => watched.disconnect();
  }, []);

  /** Draw everything anew. */
  const paint = (box: HTMLDivElement, drawing: string, name: string): void => {
    const focused = box.contains(document.activeElement) ? nameOf(document.activeElement as SVGElement) : undefined;
    box.innerHTML = drawing;
    const svg = svgNow() as SVGSVGElement;
    resize();
    reachable(svg, name, focused ?? choices.selected.peek());
    mark(svg, choices.selected.peek(), marked?.peek() ?? NOTHING);
    if (isFirst.current) {
      isFirst.current = false;
      box.scrollTop = (box.scrollHeight - box.clientHeight) / 2;
    }
    const chosen = svg.querySelector(".chosen");
    if (chosen !== null) bring(box, chosen);
    if (focused !== undefined) svg.querySelector<SVGElement>('[tabindex="0"]')?.focus();
  };

  const chosen = (event: Event): void => {
    const target = event.target as Element;
    const node = target.closest<SVGElement>("[data-id]");
    const group = target.closest<SVGElement>("[data-group]");
    if (node !== null) choices.select(node.dataset.id ?? null);
    else if (group !== null) {
      const path = group.dataset.group ?? "";
      if (path !== "") choices.toggle(path);
    } else choices.select(null);
  };
  const zoom = (factor: number): void => {
    const svg = svgNow();
    if (svg === null || page.current === null) return;
    scale.value = Math.min(4, Math.max(0.1, scaleOf(scale.peek(), svg, page.current, least) * factor));
  };
  const typed = (event: KeyboardEvent): void => {
    const svg = svgNow();
    const target = (event.target as Element).closest<SVGElement>("[role=button]");
    if (svg === null || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "f") scale.value = "fit";
    else if (event.key === "+") zoom(STEP);
    else if (event.key === "-") zoom(1 / STEP);
    else if (event.key === "Escape") choices.select(null);
    else if (target === null) return;
    else if (event.key === "Enter" || event.key === " ") chosen(event);
    else if (event.key === "e") choices.toggle(groupOf(choices.picture, nameOf(target) ?? ""));
    else if (event.key.startsWith("Arrow")) {
      const next = neighbour(svg, target, event.key);
      if (next !== null) {
        target.setAttribute("tabindex", "-1");
        next.setAttribute("tabindex", "0");
        next.focus();
      }
    } else return;
    event.preventDefault();
    event.stopPropagation();
  };
  const wheel = (event: WheelEvent): void => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoom(event.deltaY < 0 ? 1.1 : 1 / 1.1);
  };
  const saved = (kind: "svg" | "png"): void => {
    if (painted.current === null) return;
    const [text, width, height] = painted.current.whole();
    void savePictureText(text, width, height, choices.picture.name, kind);
  };
  const explained = useComputed(() => ({ __html: legendAlone(picture.value, theme.value) }));
  const name = label ?? "Graph";
  return (
    <div class="graph">
      <div class="tools" role="toolbar" aria-label={name}>
        <span>Open</span>
        <button type="button" onClick={() => choices.openDepth(0)}>nothing</button>
        <button type="button" onClick={() => choices.openDepth(1)}>one level</button>
        <button type="button" onClick={() => choices.openDepth(2)}>two levels</button>
        <button type="button" onClick={() => choices.openDepth(99)}>all</button>
        <span class="gap" />
        <button type="button" aria-label="Smaller" title="Smaller (-)" onClick={() => zoom(1 / STEP)}>−</button>
        <button type="button" title="The whole graph (f)" data-fit onClick={() => (scale.value = "fit")}>fit</button>
        <button type="button" title="Letters at their usual size" onClick={() => (scale.value = null)}>readable</button>
        <button type="button" aria-label="Larger" title="Larger (+)" onClick={() => zoom(STEP)}>+</button>
        <span class="gap" />
        <button type="button" onClick={() => saved("svg")}>SVG</button>
        <button type="button" onClick={() => saved("png")}>PNG</button>
        {children}
      </div>
      <div class={grows === true ? "page grows" : "page"} ref={page} onClick={chosen} onKeyDown={typed} onWheel={wheel} />
      <div class="legend-box" dangerouslySetInnerHTML={explained.value} />
    </div>
  );
}

/** How large a drawing is shown: letters stay readable, and a wide drawing is scrolled, unless the reader wants all of it. */
function scaleOf(wanted: number | "fit" | null, svg: SVGSVGElement, page: HTMLElement, least: number): number {
  if (typeof wanted === "number") return wanted;
  const { width, height } = svg.viewBox.baseVal;
  const room = page.matches(".grows") ? innerHeight * 0.78 : page.clientHeight - 2;
  const wide = Math.min((page.clientWidth - 2) / width, LARGEST);
  const fit = Math.min(wide, room / height);
  return wanted === "fit" ? fit : Math.max(least, page.matches(".grows") ? wide : fit);
}

/** The group that a key on a thing opens or closes: a group itself, or the one around an element. */
function groupOf(picture: Picture, path: string): string {
  return picture.nodes.find((node) => node.path === path)?.group ?? path;
}

/** The picture as if nothing had been removed. */
export function withoutRemovals(picture: Picture): Picture {
  return {
    ...picture,
    nodes: picture.nodes.map(({ gone: _gone, ...node }) => node),
    bonds: picture.bonds.map(({ gone: _gone, ...bond }) => bond),
  };
}

/** The same places with the things of another picture of the same graph. */
function refreshed(layout: Layout, visible: ReturnType<typeof fold>): Layout {
  const nodes = new Map(visible.nodes.map((node) => [node.path, node]));
  const closed = new Map(visible.closed.map((group) => [`group:${group.path}`, group]));
  const bonds = new Map(visible.bonds.map((shown) => [shown.bond.name, shown]));
  return {
    ...layout,
    spots: layout.spots.map((spot) => {
      const group = closed.get(spot.id);
      return { ...spot, node: nodes.get(spot.id), closed: group, note: group === undefined ? spot.note : noteOf(group) };
    }),
    bonds: layout.bonds.map((line) => ({ ...line, shown: bonds.get(line.shown.bond.name) ?? line.shown })),
  };
}
