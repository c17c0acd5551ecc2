/** The graph of a reduction: what was taken away, or what a threshold would take away. */

import { useComputed, type ReadonlySignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Placer } from "../graph/layout.ts";
import type { Theme } from "../graph/notation.ts";
import type { Picture } from "../graph/picture.ts";
import { GraphView, withoutRemovals } from "./graph.tsx";
import type { RankingState, Shown } from "./state.ts";

interface ReductionGraphProps {
  readonly state: RankingState;
  readonly placer: Placer;
  readonly theme: ReadonlySignal<Theme>;
}

export function ReductionGraph({ state, placer, theme }: ReductionGraphProps) {
  const picture = usePicture(state);
  const below = useComputed(() => (state.shown.value === "threshold" ? state.below.value : NOTHING));
  const way = (shown: Shown, words: string) => (
    <label>
      <input type="radio" name="shown" checked={state.shown.value === shown} onChange={() => state.setShown(shown)} />
      {words}
    </label>
  );
  return (
    <GraphView choices={state.graph} picture={picture} placer={placer} theme={theme} below={below} grows>
      <span class="gap" />
      {way("reduction", "the reduction")}
      {way("threshold", "what the threshold keeps")}
    </GraphView>
  );
}

const NOTHING: ReadonlySet<string> = new Set();

/** The picture of a ranking, with the activities of the part of the run that is ranked. */
export function usePicture(state: RankingState): ReadonlySignal<Picture> {
  const bare = useMemo(() => withoutRemovals(state.data.picture), [state]);
  return useComputed(() => {
    const picture = state.shown.value === "reduction" ? state.data.picture : bare;
    if (state.window.value === null || picture.activity === undefined) return picture;
    const rows = Object.fromEntries(state.rows.value.map((row) => [row.path, row.index]));
    return { ...picture, activity: { ...picture.activity, rows } };
  });
}
