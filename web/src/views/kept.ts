/** Parts of a long list that are made anew only where what they show has changed. */

import type { VNode } from "preact";
import { useRef } from "preact/hooks";

/** Gives the same node for the same things to show, so that Preact passes over it; `of` names all that it depends on. */
export function useKept(): (name: string, of: string, make: () => VNode) => VNode {
  const kept = useRef(new Map<string, { readonly of: string; readonly node: VNode }>());
  return (name, of, make) => {
    const known = kept.current.get(name);
    if (known !== undefined && known.of === of) return known.node;
    const node = make();
    kept.current.set(name, { of, node });
    return node;
  };
}
