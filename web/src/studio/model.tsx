/** Model: the drawn graph, the tree of its groups, and what is known of what is selected. */

import { useComputed } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { GraphChoices } from "../views/choices.ts";
import { GraphView } from "../views/graph.tsx";
import type { ModelSheet } from "./api.ts";
import { Details } from "./details.tsx";
import { Equations, Parameters } from "./lists.tsx";
import type { Studio } from "./studio.ts";
import { Tree, type Branch } from "./tree.tsx";

const TABS = [
  ["graph", "Graph"],
  ["equations", "Equations"],
  ["parameters", "Parameters"],
] as const;

export function ModelScreen({ studio, sheet }: { studio: Studio; sheet: ModelSheet }) {
  const { address } = studio;
  const choices = useMemo(() => new GraphChoices(sheet.picture, address), [sheet]);
  const picture = useComputed(() => sheet.picture);
  const marked = useComputed<ReadonlySet<string>>(() => {
    const wanted = address.word("mark");
    return new Set(sheet.counts.find((count) => count.name === wanted)?.paths ?? []);
  });
  const tab = address.word("tab") ?? "graph";
  useEffect(() => {
    if (tab !== "graph") document.body.dataset.ready = "true";
  }, [tab]);
  return (
    <div class="model-screen">
      <Counts studio={studio} sheet={sheet} choices={choices} />
      <div class="tabs" role="tablist" aria-label="Views of the model">
        {TABS.map(([name, title], i) => (
          <button
            key={name}
            type="button"
            role="tab"
            id={`tab-${name}`}
            aria-selected={tab === name}
            aria-controls="tab-panel"
            tabIndex={tab === name ? 0 : -1}
            onClick={() => address.write({ tab: name === "graph" ? null : name })}
            onKeyDown={(event) => {
              const by = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
              const next = TABS[(i + by + TABS.length) % TABS.length]?.[0];
              if (by === 0 || next === undefined) return;
              address.write({ tab: next === "graph" ? null : next });
              document.getElementById(`tab-${next}`)?.focus();
            }}
          >
            {title}
          </button>
        ))}
      </div>
      <aside class="side" aria-label="Groups and elements">
        <ModelTree choices={choices} sheet={sheet} />
      </aside>
      <div class="middle" id="tab-panel" role="tabpanel" aria-labelledby={`tab-${tab}`}>
        {tab === "equations" ? (
          <Equations sheet={sheet} />
        ) : tab === "parameters" ? (
          <Parameters sheet={sheet} />
        ) : (
          <GraphView choices={choices} picture={picture} placer={studio.placer} theme={studio.themes.theme} marked={marked} />
        )}
      </div>
      <aside class="details" aria-label="Details">
        <Details sheet={sheet} choices={choices} marked={marked} />
      </aside>
    </div>
  );
}

/** What there is how many of; a click marks it in the graph. */
function Counts({ studio, sheet, choices }: { studio: Studio; sheet: ModelSheet; choices: GraphChoices }) {
  const wanted = studio.address.word("mark");
  return (
    <div class="counts" role="toolbar" aria-label="Counts: a click marks the elements">
      {sheet.counts.map((count) => (
        <button
          key={count.name}
          type="button"
          data-count={count.name}
          aria-pressed={wanted === count.name}
          disabled={count.paths.length === 0}
          onClick={() => {
            if (wanted === count.name) studio.address.write({ mark: null });
            else {
              studio.address.write({ mark: count.name, tab: null });
              if (count.paths.length <= FEW) choices.reveal(count.paths);
            }
          }}
        >
          <b>{count.count}</b> {count.name}
        </button>
      ))}
    </div>
  );
}

const FEW = 8; // marked elements whose groups open for them; more would unfold the whole model

function ModelTree({ choices, sheet }: { choices: GraphChoices; sheet: ModelSheet }) {
  const roots = useMemo(() => branches(sheet), [sheet]);
  return (
    <Tree
      label="Groups and elements"
      roots={roots}
      open={choices.open.value}
      onToggle={(group) => choices.toggle(group)}
      selected={choices.selected.value}
      onSelect={(path) => choices.show(path)}
    />
  );
}

/** Groups with what is in them; junctions are left to the graph. */
function branches(sheet: ModelSheet): Branch[] {
  const { groups, nodes } = sheet.picture;
  const inside = (parent: string): Branch[] => [
    ...groups
      .filter((group) => group.parent === parent && group.path !== "")
      .map((group): Branch => ({ key: group.path, label: group.name, note: "", children: inside(group.path) })),
    ...nodes
      .filter((node) => node.group === parent && node.kind !== "0" && node.kind !== "1")
      .map((node): Branch => ({ key: node.path, label: relative(node.path, parent), note: node.kind, children: [] })),
  ];
  return inside("");
}

const relative = (path: string, group: string): string => (group !== "" && path.startsWith(`${group}.`) ? path.slice(group.length + 1) : path);
