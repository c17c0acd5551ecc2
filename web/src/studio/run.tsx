/** Run: what to run, how it goes, and its signals while it goes. */

import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { GraphChoices } from "../views/choices.ts";
import { duration } from "../views/format.ts";
import { GraphView } from "../views/graph.tsx";
import { LanesView, ownZoom } from "../views/lanes.tsx";
import type { Job, ModelSheet, RunRequest, SignalEntry } from "./api.ts";
import { get, post } from "./client.ts";
import { FaultView } from "./fault.tsx";
import { RunForm } from "./form.tsx";
import { JobTable, Links, StateMark } from "./joblist.tsx";
import { hasData, isOver } from "./jobs.ts";
import { SignalPicker } from "./picker.tsx";
import { useResource } from "./resource.ts";
import { laneGroups, usualSignals } from "./signals.ts";
import type { Studio } from "./studio.ts";

export function RunScreen({ studio, sheet }: { studio: Studio; sheet: ModelSheet }) {
  const { address, jobs } = studio;
  const fault = useSignal<unknown>(null);
  const isAsking = useSignal(false);
  const mine = jobs.all.value.filter((job) => job.model === sheet.id);
  const wanted = address.word("job");
  const job = mine.find((one) => one.id === wanted) ?? mine.find((one) => one.kind === "run" && !isOver(one.state)) ?? null;
  const run = async (request: RunRequest): Promise<void> => {
    isAsking.value = true;
    fault.value = null;
    try {
      const made = await post<Job>("/runs", request);
      jobs.take(made);
      address.write({ job: made.id });
    } catch (error) {
      fault.value = error;
    } finally {
      isAsking.value = false;
    }
  };
  useEffect(() => void (document.body.dataset.ready = "true"), []);
  return (
    <div class="run-screen">
      <aside class="side" aria-label="What to run">
        <RunForm studio={studio} sheet={sheet} onRun={(request) => void run(request)} isAsking={isAsking.value} />
        {fault.value !== null && <FaultView error={fault.value} onElement={(path) => studio.go("model", { selected: path })} />}
      </aside>
      <div class="course">
        {job === null ? <p class="hint">Choose a scenario and run it; what happens is drawn here.</p> : <Course key={job.id} studio={studio} sheet={sheet} job={job} />}
        <section aria-labelledby="queue">
          <h2 id="queue">Runs of {sheet.name}</h2>
          <JobTable studio={studio} jobs={mine} empty="This model has not been run." isOneModel />
        </section>
      </div>
    </div>
  );
}

/** How a job goes. */
function Course({ studio, sheet, job }: { studio: Studio; sheet: ModelSheet; job: Job }) {
  const { progress } = job;
  const share = progress === null || progress.end <= job.window[0] ? 0 : Math.min(1, (progress.time - job.window[0]) / (progress.end - job.window[0]));
  const cancel = (): void => void post<Job>(`/jobs/${job.id}/cancel`, {}).then((now) => studio.jobs.take(now));
  return (
    <section class="job-now" aria-label="How the run goes" data-job={job.id} data-state={job.state}>
      <div class="head">
        <h2>{job.scenario} <small>{job.kind}</small></h2>
        <StateMark job={job} />
        <span class="gap" />
        {!isOver(job.state) && <button type="button" onClick={cancel}>Cancel</button>}
        <Links studio={studio} job={job} isHere />
      </div>
      <progress max="1" value={job.state === "complete" ? 1 : share} aria-label="Part that is done" />
      {progress !== null && (
        <dl class="figures">
          <div><dt>time</dt><dd data-time={progress.time}>{Number(progress.time.toPrecision(5))} of {Number(progress.end.toPrecision(5))} s</dd></div>
          {job.summary.length === 0 && <div><dt>x real time</dt><dd>{Number(progress.rate.toPrecision(3))}</dd></div>}
          <div><dt>steps</dt><dd>{progress.steps.toLocaleString("en")}</dd></div>
          <div><dt>rejected</dt><dd>{progress.rejected.toLocaleString("en")}</dd></div>
          {!isOver(job.state) && <div><dt>left</dt><dd>{duration(progress.left)}</dd></div>}
          {job.summary.filter((fact) => fact.name !== "steps").map((fact) => <div key={fact.name} title={fact.note}><dt>{fact.name}</dt><dd>{fact.value}</dd></div>)}
        </dl>
      )}
      {(job.state === "failed" || job.state === "lost") && <Failure studio={studio} sheet={sheet} job={job} />}
      {job.state !== "failed" && job.message !== "" && <p class="hint">{job.message}</p>}
      {hasData(job) && <Live studio={studio} sheet={sheet} job={job} />}
    </section>
  );
}

/** Why a run did not reach its end, and where in the model. */
function Failure({ studio, sheet, job }: { studio: Studio; sheet: ModelSheet; job: Job }) {
  const choices = useMemo(() => new GraphChoices(sheet.picture, studio.address), [sheet]);
  const picture = useComputed(() => sheet.picture);
  const marked = useComputed<ReadonlySet<string>>(() => new Set(job.elements));
  useEffect(() => choices.reveal(job.elements), [job.id]);
  return (
    <>
      <div class="fault-box" role="alert">
        <p class="what">{job.message}</p>
        {job.elements.length > 0 && (
          <ul>
            {job.elements.map((path) => (
              <li key={path} data-element={path}>
                <button type="button" class="plain link" onClick={() => studio.go("model", { selected: path })}>{path}</button>
              </li>
            ))}
          </ul>
        )}
      </div>
      {job.elements.length > 0 && (
        <div class="failure-graph">
          <GraphView choices={choices} picture={picture} placer={studio.placer} theme={studio.themes.theme} marked={marked} label="Where it failed" fits />
        </div>
      )}
    </>
  );
}

const PAUSE = 700; // ms between two looks at a run that goes on

/** Signals of a run, drawn while it goes. */
function Live({ studio, sheet, job }: { studio: Studio; sheet: ModelSheet; job: Job }) {
  const { address, source } = studio;
  const signals = useResource(`${job.id} ${isOver(job.state)}`, () => get<SignalEntry[]>(`/runs/${job.id}/signals`));
  const zoom = useMemo(ownZoom, [job.id]);
  const version = useSignal(0);
  const last = useRef(0);
  const waiting = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const time = job.progress?.time;
  useEffect(() => {
    clearTimeout(waiting.current);
    const look = (): void => {
      last.current = performance.now();
      version.value += 1;
    };
    const wait = isOver(job.state) ? 0 : Math.max(0, PAUSE - (performance.now() - last.current));
    waiting.current = setTimeout(look, wait);
    return () => clearTimeout(waiting.current);
  }, [time, job.state]);
  const known = useMemo(() => new Map((signals.state === "there" ? signals.value : []).map((entry) => [entry.path, entry])), [signals.state]);
  const asked = address.all("signal");
  const chosen = asked.length > 0 ? asked : usualSignals(job.outputs, sheet.picture, known);
  const groups = useMemo(() => laneGroups(chosen, known, false), [chosen.join(" "), known]);
  const runs = useMemo(() => [{ id: job.id, name: job.scenario }], [job.id]);
  if (signals.state === "failed") return <FaultView error={signals.error} />;
  if (signals.state === "waiting") return <p class="waiting" role="status">Reading its signals …</p>;
  return (
    <>
      <div class="tools">
        <SignalPicker id="live" label="Signals drawn" all={[...known.keys()]} chosen={chosen} onChoose={(paths) => address.write({ signal: paths })} />
        <a href={studio.link("plots", { model: job.model, run: job.id, signal: chosen })}>all plots</a>
      </div>
      <LanesView source={source} groups={groups} runs={runs} whole={job.window} zoom={zoom} theme={studio.themes.theme} name={`${job.name}, ${job.scenario}`} height={104} version={version} />
    </>
  );
}
