/** Activity and reduction: the ranking of a run, what a threshold keeps, and the reduced model made of it. */

import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { ElementView } from "../views/element.tsx";
import { GraphView } from "../views/graph.tsx";
import { RankingView } from "../views/ranking.tsx";
import { usePicture } from "../views/reduction.tsx";
import { RankingState } from "../views/state.ts";
import { Balances, Facts, Notes } from "../views/tables.tsx";
import type { ActivityData, Job, ModelSheet, SignalEntry } from "./api.ts";
import { get, post } from "./client.ts";
import { FaultView, When } from "./fault.tsx";
import { made } from "./jobs.ts";
import { SignalPicker } from "./picker.tsx";
import { useResource } from "./resource.ts";
import type { Studio } from "./studio.ts";

export function ActivityScreen({ studio, sheet }: { studio: Studio; sheet: ModelSheet }) {
  const run = studio.run.value;
  const data = useResource(run?.state === "complete" ? run.id : null, (id) => get<ActivityData>(`/runs/${id}/activity`));
  const runs = studio.jobs.runs.value.filter((job) => job.model === sheet.id && job.state === "complete");
  useEffect(() => {
    if (run === null) document.body.dataset.ready = "true";
  }, [run]);
  if (run === null || run.state !== "complete") {
    return (
      <div class="page-of">
        <p class="hint">
          {run === null ? "No run to rank." : `This run is ${run.state}; a run is ranked when it is complete.`} <a href={studio.link("run")}>Run the model</a>.
        </p>
        {runs.length > 0 && <RunPicker studio={studio} runs={runs} run={null} />}
      </div>
    );
  }
  return (
    <When resource={data} waiting="Ranking the run …">
      {(found) => <Activity key={run.id} studio={studio} run={run} runs={runs} data={found} />}
    </When>
  );
}

function RunPicker({ studio, runs, run }: { studio: Studio; runs: readonly Job[]; run: Job | null }) {
  return (
    <label>
      run{" "}
      <select value={run?.id ?? ""} onChange={(event) => studio.address.write({ run: event.currentTarget.value, threshold: null, from: null, to: null, keep: null, go: null }, "step")}>
        {run === null && <option value="">choose …</option>}
        {runs.map((job) => <option key={job.id} value={job.id}>{`${job.scenario}, ${made(job)}`}</option>)}
      </select>
    </label>
  );
}

interface ActivityProps {
  readonly studio: Studio;
  readonly run: Job;
  readonly runs: readonly Job[];
  readonly data: ActivityData;
}

function Activity({ studio, run, runs, data }: ActivityProps) {
  const state = useMemo(() => new RankingState(data, studio.address, "threshold"), [data]);
  const picture = usePicture(state);
  const below = useComputed(() => state.below.value);
  const { theme } = studio.themes;
  return (
    <div class="activity-screen">
      <div class="head tools">
        <RunPicker studio={studio} runs={runs} run={run} />
        <OutputPicker studio={studio} run={run} />
        <span class="gap" />
        <Build studio={studio} run={run} state={state} />
      </div>
      <div class="left">
        <div class="graph-box">
          <GraphView choices={state.graph} picture={picture} placer={studio.placer} theme={theme} below={below} fits />
        </div>
        <ElementView state={state} source={studio.source} run={run.id} theme={theme} />
      </div>
      <div class="right">
        <RankingView state={state} canLock />
        <section aria-labelledby="energy">
          <h2 id="energy">Energy</h2>
          <Balances full={data.balances.full} />
        </section>
        {data.facts.length > 0 && <Facts facts={data.facts} />}
        <Notes notes={data.notes} />
      </div>
    </div>
  );
}

/** What both models are compared by. */
function outputsOf(studio: Studio, run: Job): readonly string[] {
  const wanted = studio.address.all("output");
  return wanted.length > 0 ? wanted : run.outputs;
}

function OutputPicker({ studio, run }: { studio: Studio; run: Job }) {
  const signals = useResource(run.id, (id) => get<SignalEntry[]>(`/runs/${id}/signals`));
  const all = signals.state === "there" ? signals.value.map(({ path }) => path) : run.outputs;
  return <SignalPicker id="outputs" label="compared by" all={all} chosen={outputsOf(studio, run)} onChoose={(paths) => studio.address.write({ output: paths })} />;
}

/** Make the reduced model of what is chosen, and go where it is compared. */
function Build({ studio, run, state }: { studio: Studio; run: Job; state: RankingState }) {
  const fault = useSignal<unknown>(null);
  const isAsking = useSignal(false);
  const build = async (): Promise<void> => {
    isAsking.value = true;
    fault.value = null;
    const window = state.window.peek();
    const locked = (lock: "keep" | "go"): string[] => [...state.locks.peek()].filter(([, found]) => found === lock).map(([path]) => path);
    try {
      const job = await post<Job>("/reductions", {
        run: run.id,
        threshold: state.threshold.peek(),
        from: window === null ? null : state.times[window[0]],
        to: window === null ? null : state.times[window[1]],
        keep: locked("keep"),
        go: locked("go"),
        outputs: outputsOf(studio, run),
      });
      studio.jobs.take(job);
      studio.go("compare", { reduction: job.id });
    } catch (error) {
      fault.value = error;
    } finally {
      isAsking.value = false;
    }
  };
  const going = state.below.value.size;
  return (
    <>
      <span class="hint">{going === 0 ? "nothing would go" : `${going} of ${state.rows.value.length} elements would go`}</span>
      <button type="button" class="primary" disabled={isAsking.value || going === 0} onClick={() => void build()}>Build reduced model</button>
      {fault.value !== null && <FaultView error={fault.value} onElement={(path) => state.graph.show(path)} />}
    </>
  );
}
