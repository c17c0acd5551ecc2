/** A tree that is walked by keys: of groups and elements, or of signals with boxes to tick. */

import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";

export interface Branch {
  readonly key: string;
  readonly label: string;
  readonly note: string;
  readonly children: readonly Branch[];
}

interface TreeProps {
  readonly label: string;
  readonly roots: readonly Branch[];
  readonly open: ReadonlySet<string>;
  readonly onToggle: (key: string) => void;
  readonly selected?: string | null;
  readonly onSelect: (key: string) => void;
  /** Ticked leaves; without it there are no boxes. */
  readonly ticked?: ReadonlySet<string>;
}

interface Shown {
  readonly branch: Branch;
  readonly depth: number;
  readonly parent: string | null;
}

export function Tree({ label, roots, open, onToggle, selected, onSelect, ticked }: TreeProps) {
  const place = useRef<HTMLUListElement>(null);
  const at = useSignal<string | null>(null);
  const shown = visible(roots, open);
  const current = shown.some((one) => one.branch.key === at.value) ? at.value : (shown.find((one) => one.branch.key === selected) ?? shown[0])?.branch.key;
  const go = (key: string | undefined | null): void => {
    if (key === undefined || key === null) return;
    at.value = key;
    place.current?.querySelector<HTMLElement>(`[data-key="${CSS.escape(key)}"]`)?.focus();
  };
  const typed = (event: KeyboardEvent): void => {
    const i = shown.findIndex((one) => one.branch.key === current);
    const here = shown[i];
    if (here === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    const isOpen = open.has(here.branch.key);
    const hasInside = here.branch.children.length > 0;
    if (event.key === "ArrowDown") go(shown[i + 1]?.branch.key);
    else if (event.key === "ArrowUp") go(shown[i - 1]?.branch.key);
    else if (event.key === "Home") go(shown[0]?.branch.key);
    else if (event.key === "End") go(shown.at(-1)?.branch.key);
    else if (event.key === "ArrowRight" && hasInside) isOpen ? go(shown[i + 1]?.branch.key) : onToggle(here.branch.key);
    else if (event.key === "ArrowLeft") hasInside && isOpen ? onToggle(here.branch.key) : go(here.parent);
    else if (event.key === "Enter" || event.key === " ") onSelect(here.branch.key);
    else if (event.key === "e" && hasInside) onToggle(here.branch.key);
    else return;
    event.preventDefault();
  };
  return (
    <ul class="tree" role="tree" aria-label={label} aria-multiselectable={ticked !== undefined} ref={place} onKeyDown={typed}>
      {shown.map(({ branch, depth }) => {
        const hasInside = branch.children.length > 0;
        const isTicked = ticked?.has(branch.key) ?? false;
        return (
          <li
            key={branch.key}
            role="treeitem"
            data-key={branch.key}
            aria-level={depth + 1}
            {...(hasInside ? { "aria-expanded": open.has(branch.key) } : {})}
            {...(ticked !== undefined && !hasInside ? { "aria-checked": isTicked } : {})}
            {...(ticked === undefined ? { "aria-selected": selected === branch.key } : {})}
            tabIndex={branch.key === current ? 0 : -1}
            style={{ paddingLeft: `${6 + 14 * depth}px` }}
            onFocus={() => (at.value = branch.key)}
            onClick={() => onSelect(branch.key)}
          >
            <span
              class="twig"
              aria-hidden="true"
              onClick={(event) => {
                if (!hasInside) return;
                event.stopPropagation();
                onToggle(branch.key);
              }}
            >
              {hasInside ? (open.has(branch.key) ? "▾" : "▸") : ""}
            </span>
            {ticked !== undefined && !hasInside && <span class={isTicked ? "box ticked" : "box"} aria-hidden="true" />}
            <span class="label" title={branch.key}>{branch.label}</span>
            <span class="note">{branch.note}</span>
          </li>
        );
      })}
    </ul>
  );
}

function visible(roots: readonly Branch[], open: ReadonlySet<string>): Shown[] {
  const found: Shown[] = [];
  const walk = (branches: readonly Branch[], depth: number, parent: string | null): void => {
    for (const branch of branches) {
      found.push({ branch, depth, parent });
      if (open.has(branch.key)) walk(branch.children, depth + 1, branch.key);
    }
  };
  walk(roots, 0, null);
  return found;
}

/** Paths in dots as a tree of their parts; a leaf's key is its path, a level's key ends in a dot. */
export function branchesOf(entries: readonly { readonly path: string; readonly note: string }[]): Branch[] {
  interface Level { levels: Map<string, Level>; leaves: Branch[] }
  const root: Level = { levels: new Map(), leaves: [] };
  for (const { path, note } of entries) {
    const parts = path.split(".");
    let level = root;
    for (const part of parts.slice(0, -1)) {
      let next = level.levels.get(part);
      if (next === undefined) level.levels.set(part, (next = { levels: new Map(), leaves: [] }));
      level = next;
    }
    level.leaves.push({ key: path, label: parts.at(-1) ?? path, note, children: [] });
  }
  const written = (level: Level, prefix: string): Branch[] => [
    ...[...level.levels].map(([name, inside]): Branch => {
      const children = written(inside, `${prefix}${name}.`);
      return { key: `${prefix}${name}.`, label: name, note: "", children };
    }),
    ...level.leaves,
  ];
  return written(root, "");
}
