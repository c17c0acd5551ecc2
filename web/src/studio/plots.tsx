/** Plots: signals of runs, chosen from a tree, in lanes with one cursor and one zoom. */

import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { LanesView, PENS, type Zoom } from "../views/lanes.tsx";
import type { Span } from "../views/source.ts";
import type { Job, ModelSheet, SignalEntry } from "./api.ts";
import { addressOf, get } from "./client.ts";
import { FaultView } from "./fault.tsx";
import { hasData, isOver, made } from "./jobs.ts";
import { useResource } from "./resource.ts";
import { laneGroups, panelGroups, usualSignals } from "./signals.ts";
import type { Studio } from "./studio.ts";
import { branchesOf, Tree } from "./tree.tsx";

// Heights in px: of what stands above the lanes, of a lane's title, and of lanes, which fill the window where they can.
const ABOVE = 170;
const TITLE = 26;
const LOWEST = 120;
const TALLEST = 280;

export function PlotsScreen({ studio, sheet }: { studio: Studio; sheet: ModelSheet }) {
  const { address, jobs } = studio;
  useEffect(() => void (document.body.dataset.ready = "true"), []);
  const asked = address.all("run").map((id) => jobs.byId.value.get(id)).filter((job) => job !== undefined);
  const first = studio.run.value;
  const runs = asked.length > 0 ? asked : first === null ? [] : [first];
  if (runs.length === 0) {
    return <p class="page-of hint">No run to plot. <a href={studio.link("run")}>Run the model</a>, and its signals are drawn here.</p>;
  }
  return <Plots studio={studio} sheet={sheet} runs={runs} />;
}

/** The part of the time that the address says. */
function useAddressZoom(studio: Studio): Zoom {
  const { address } = studio;
  const words = useComputed(() => `${address.word("from") ?? ""} ${address.word("to") ?? ""}`);
  const span = useComputed<Span | null>(() => {
    const [from, to] = words.value.split(" ");
    return from === "" || to === "" || !(Number(from) < Number(to)) ? null : [Number(from), Number(to)];
  });
  return useMemo(
    () => ({
      span,
      set: (wanted) =>
        address.write({
          from: wanted === null ? null : String(Number(wanted[0].toPrecision(9))),
          to: wanted === null ? null : String(Number(wanted[1].toPrecision(9))),
        }),
    }),
    [],
  );
}

function Plots({ studio, sheet, runs }: { studio: Studio; sheet: ModelSheet; runs: readonly Job[] }) {
  const { address } = studio;
  const first = runs[0] as Job;
  const signals = useResource(hasData(first) ? first.id : null, () => get<SignalEntry[]>(`/runs/${first.id}/signals`));
  const zoom = useAddressZoom(studio);
  const entries = signals.state === "there" ? signals.value : [];
  const known = useMemo(() => new Map(entries.map((entry) => [entry.path, entry])), [signals.state, first.id]);
  const ticked = address.all("signal");
  const isUsual = ticked.length === 0 && address.word("none") === null;
  const panels = useMemo(() => panelGroups(sheet.panels, known), [known]);
  const usual = panels.length > 0 ? panels.flatMap((panel) => panel.signals.map(({ path }) => path)) : usualSignals(first.outputs, sheet.picture, known);
  const chosen = isUsual ? usual : ticked;
  const isTogether = address.word("together") !== null;
  const key = chosen.join(" ");
  const groups = useMemo(() => (isUsual && !isTogether && panels.length > 0 ? panels : laneGroups(chosen, known, isTogether)), [key, known, isTogether, isUsual]);
  const ids = runs.map((job) => job.id).join(" ");
  const laid = useMemo(() => runs.map((job, i) => ({ id: job.id, name: `${i + 1}. ${job.scenario}` })), [ids]);
  const whole: Span = [Math.min(...runs.map((job) => job.window[0])), Math.max(...runs.map((job) => job.window[1]))];
  // Runs that go on are drawn anew whenever they have come a fiftieth further.
  const seen = runs.map((job) => `${job.state} ${isOver(job.state) ? "" : Math.floor((job.progress?.time ?? 0) / Math.max(1e-9, (job.window[1] - job.window[0]) / 50))}`).join(" ");
  const version = useSignal(0);
  const before = useRef(seen);
  useEffect(() => {
    if (before.current !== seen) version.value += 1;
    before.current = seen;
  }, [seen]);
  const height = Math.min(TALLEST, Math.max(LOWEST, (innerHeight - ABOVE) / Math.max(1, groups.length) - TITLE));
  const choose = (paths: readonly string[]): void => address.write({ signal: paths, none: paths.length === 0 ? "yes" : null });
  return (
    <div class="plots-screen">
      <aside class="side" aria-label="Runs and signals">
        <Runs studio={studio} runs={runs} />
        <SignalTree entries={entries} chosen={chosen} onChoose={choose} />
        {signals.state === "failed" && <FaultView error={signals.error} />}
      </aside>
      <div class="lanes-side">
        <div class="tools">
          <label>
            <input type="checkbox" checked={isTogether} onChange={() => address.write({ together: isTogether ? null : "yes" })} />
            one lane for each unit
          </label>
          <span class="gap" />
          {runs.map((job, i) => (
            <a key={job.id} href={addressOf(`/runs/${job.id}/csv`, { signal: chosen })} download>
              {runs.length === 1 ? "all samples as CSV" : `samples of ${i + 1} as CSV`}
            </a>
          ))}
          {chosen.length > 0 && <button type="button" onClick={() => choose([])}>no signals</button>}
        </div>
        {groups.length === 0 ? (
          <p class="hint">{signals.state === "waiting" ? "Reading the signals …" : "Tick signals in the tree to draw them."}</p>
        ) : (
          <LanesView source={studio.source} groups={groups} runs={laid} whole={whole} zoom={zoom} theme={studio.themes.theme} name={`${first.name}, ${first.scenario}`} height={Math.round(height)} version={version} />
        )}
      </div>
    </div>
  );
}

/** The runs that are laid over one another, each with its pen. */
function Runs({ studio, runs }: { studio: Studio; runs: readonly Job[] }) {
  const { address, jobs } = studio;
  const ids = runs.map((job) => job.id);
  const all = jobs.runs.value.filter((job) => hasData(job) || ids.includes(job.id));
  const turn = (job: Job): void => {
    const next = ids.includes(job.id) ? ids.filter((id) => id !== job.id) : [...ids, job.id];
    if (next.length > 0) address.write({ run: next });
  };
  return (
    <fieldset class="runs">
      <legend>Runs</legend>
      {all.map((job) => {
        const pen = ids.indexOf(job.id);
        return (
          <label key={job.id} data-run={job.id}>
            <input type="checkbox" checked={pen >= 0} disabled={pen >= 0 && ids.length === 1} onChange={() => turn(job)} />
            <svg class="pen" width="26" height="8" aria-hidden="true">
              {pen >= 0 && <line x1="1" x2="25" y1="4" y2="4" stroke="currentColor" stroke-dasharray={(PENS[pen % PENS.length] ?? []).join(" ")} />}
            </svg>
            <span class="label" title={`${job.name}, ${job.scenario}, ${job.state}`}>{pen >= 0 ? `${pen + 1}. ` : ""}{job.model === runs[0]?.model ? "" : `${job.name}, `}{job.scenario}</span>
            <span class="note">{made(job)}</span>
          </label>
        );
      })}
    </fieldset>
  );
}

interface SignalTreeProps {
  readonly entries: readonly SignalEntry[];
  readonly chosen: readonly string[];
  readonly onChoose: (paths: readonly string[]) => void;
}

function SignalTree({ entries, chosen, onChoose }: SignalTreeProps) {
  const text = useSignal("");
  const opened = useSignal<ReadonlySet<string>>(new Set());
  const words = text.value.toLowerCase().split(/\s+/).filter((word) => word !== "");
  const found = words.length === 0 ? entries : entries.filter(({ path }) => words.every((word) => path.toLowerCase().includes(word)));
  const roots = useMemo(() => branchesOf(found.map(({ path, display }) => ({ path, note: display.unit }))), [found]);
  // What is searched for, and what is ticked, is in view.
  const open = useMemo(() => {
    const levels = (paths: readonly string[]): string[] => paths.flatMap((path) => path.split(".").slice(0, -1).map((_, i, parts) => `${parts.slice(0, i + 1).join(".")}.`));
    return new Set([...opened.value, ...(words.length > 0 ? levels(found.map(({ path }) => path)) : [])]);
  }, [found, opened.value]);
  const toggle = (key: string): void => {
    const next = new Set(opened.value);
    if (!next.delete(key)) next.add(key);
    opened.value = next;
  };
  const select = (key: string): void => {
    if (key.endsWith(".")) toggle(key);
    else onChoose(chosen.includes(key) ? chosen.filter((path) => path !== key) : [...chosen, key]);
  };
  return (
    <div class="signals">
      <div class="filter">
        <input type="search" placeholder="Find a signal" aria-label="Find a signal" value={text.value} onInput={(event) => (text.value = event.currentTarget.value)} />
        <span class="hint">{found.length === entries.length ? `${entries.length} signals` : `${found.length} of ${entries.length}`}, {chosen.length} drawn</span>
      </div>
      {words.length > 0 && found.length > 0 && found.length <= 60 && (
        <button type="button" onClick={() => onChoose([...new Set([...chosen, ...found.map(({ path }) => path)])])}>tick all {found.length}</button>
      )}
      <Tree label="Signals" roots={roots} open={open} onToggle={toggle} onSelect={select} ticked={new Set(chosen)} />
    </div>
  );
}
