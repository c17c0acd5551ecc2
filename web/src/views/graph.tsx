/** The drawn graph: groups open and close, elements can be chosen, the threshold repaints it. */

import { useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import { draw } from "../graph/draw.ts";
import { noteOf } from "../graph/figures.ts";
import { fold, openTo } from "../graph/fold.ts";
import { place, type Layout, type Placer } from "../graph/layout.ts";
import type { Picture } from "../graph/picture.ts";
import type { State } from "./state.ts";

const READABLE = 0.85; // of the size in which a drawing is made

export function GraphView({ state, placer }: { state: State; placer: Placer }) {
  const page = useRef<HTMLDivElement>(null);
  const layouts = useRef(new Map<string, Promise<Layout>>());
  const bare = withoutRemovals(state.data.picture);
  const turn = useRef(0);

  const pictureNow = (): Picture => {
    const picture = state.shown.value === "reduction" ? state.data.picture : bare;
    if (state.window.value === null || picture.activity === undefined) return picture;
    const rows = Object.fromEntries(state.rows.value.map((row) => [row.path, row.index]));
    return { ...picture, activity: { ...picture.activity, rows } };
  };

  useSignalEffect(() => {
    const open = state.open.value;
    const picture = pictureNow();
    const below = state.shown.value === "threshold" ? rowsBelow(state) : new Set<string>();
    const theme = state.theme.value;
    const key = [...open].sort().join(" ");
    let layout = layouts.current.get(key);
    if (layout === undefined) {
      layout = place(fold(state.data.picture, open), placer);
      layouts.current.set(key, layout);
    }
    turn.current += 1;
    const mine = turn.current;
    void layout.then((placed) => {
      if (mine !== turn.current || page.current === null) return;
      const visible = fold(picture, open, below);
      // What is gone differs between the two ways to look; where things are does not.
      const shown = refreshed(placed, visible);
      page.current.innerHTML = draw(picture, shown, { theme, legend: true, below });
      // Letters stay readable: a wide drawing is scrolled, not shrunk.
      page.current.firstElementChild?.setAttribute("style", `min-width: ${Math.round(READABLE * shown.width)}px`);
      mark(page.current, state.selected.value);
      document.body.dataset.ready = "true";
    });
  });
  useSignalEffect(() => {
    if (page.current !== null) mark(page.current, state.selected.value);
  });

  const chosen = (event: Event): void => {
    const target = event.target as Element;
    const group = target.closest<SVGElement>("[data-group]");
    const node = target.closest<SVGElement>("[data-id]");
    if (node !== null) state.selected.value = node.dataset.id ?? null;
    else if (group !== null) state.toggle(group.dataset.group ?? "");
    else state.selected.value = null;
  };
  const typed = (event: KeyboardEvent): void => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    chosen(event);
  };
  const depth = (levels: number): void => {
    state.open.value = openTo(state.data.picture, levels);
  };
  return (
    <div class="graph">
      <div class="tools" role="toolbar" aria-label="Graph">
        <span>Open</span>
        <button type="button" onClick={() => depth(0)}>nothing</button>
        <button type="button" onClick={() => depth(1)}>one level</button>
        <button type="button" onClick={() => depth(2)}>two levels</button>
        <button type="button" onClick={() => depth(99)}>all</button>
        <span class="gap" />
        <label>
          <input
            type="radio"
            name="shown"
            checked={state.shown.value === "reduction"}
            onChange={() => (state.shown.value = "reduction")}
          />
          the reduction
        </label>
        <label>
          <input
            type="radio"
            name="shown"
            checked={state.shown.value === "threshold"}
            onChange={() => (state.shown.value = "threshold")}
          />
          what the threshold keeps
        </label>
      </div>
      <div class="page" ref={page} onClick={chosen} onKeyDown={typed} />
    </div>
  );
}

function rowsBelow(state: State): Set<string> {
  return new Set(state.rows.value.slice(state.kept.value).map((row) => row.path));
}

/** The picture as if nothing had been removed. */
function withoutRemovals(picture: Picture): Picture {
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

function mark(page: HTMLElement, selected: string | null): void {
  for (const old of page.querySelectorAll(".chosen")) old.classList.remove("chosen");
  if (selected === null) return;
  for (const node of page.querySelectorAll(`[data-id="${CSS.escape(selected)}"], [data-row="${CSS.escape(selected)}"]`)) {
    node.classList.add("chosen");
  }
}
