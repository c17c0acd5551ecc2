/** Compare: a reduced model with the full one, or any two runs. */

import { useEffect } from "preact/hooks";
import type { ComparisonData, Job, ModelSheet, ReductionData } from "./api.ts";
import { Beside } from "./beside.tsx";
import { get, post } from "./client.ts";
import { When } from "./fault.tsx";
import { StateMark } from "./joblist.tsx";
import { hasData, isOver, made } from "./jobs.ts";
import { useResource } from "./resource.ts";
import type { Studio } from "./studio.ts";

export function CompareScreen({ studio, sheet }: { studio: Studio; sheet: ModelSheet }) {
  const { address, jobs } = studio;
  const all = jobs.byId.value;
  const [wanted, first, second] = [address.word("reduction"), address.word("a"), address.word("b")];
  // Who has chosen nothing sees the last reduction.
  const last = jobs.all.value.find((job) => job.kind === "reduction" && job.model === sheet.id);
  const isOpen = wanted === null && first === null && second === null;
  const reduction = isOpen ? last : all.get(wanted ?? "");
  const a = all.get(first ?? "");
  const b = all.get(second ?? "");
  useEffect(() => void (document.body.dataset.ready = "true"), []);
  return (
    <div class="page-of compare">
      <Pickers studio={studio} sheet={sheet} reduction={reduction} a={a} b={b} />
      {reduction !== undefined ? (
        <OfReduction key={reduction.id} studio={studio} job={reduction} />
      ) : a !== undefined && b !== undefined ? (
        <OfRuns key={`${a.id} ${b.id}`} studio={studio} a={a} b={b} />
      ) : (
        <p class="hint">
          Choose a reduction, or two runs. A reduced model is built on the <a href={studio.link("activity")}>activity screen</a>.
        </p>
      )}
    </div>
  );
}

interface PickersProps {
  readonly studio: Studio;
  readonly sheet: ModelSheet;
  readonly reduction: Job | undefined;
  readonly a: Job | undefined;
  readonly b: Job | undefined;
}

function Pickers({ studio, sheet, reduction, a, b }: PickersProps) {
  const { address, jobs } = studio;
  const mine = jobs.all.value.filter((job) => job.model === sheet.id);
  const reductions = mine.filter((job) => job.kind === "reduction");
  const runs = mine.filter((job) => hasData(job) && job.state !== "running");
  const option = (job: Job) => <option key={job.id} value={job.id}>{`${job.scenario}, ${made(job)}${job.state === "complete" ? "" : `, ${job.state}`}`}</option>;
  const pick = (word: "a" | "b") => (event: { currentTarget: HTMLSelectElement }) =>
    address.write({ [word]: event.currentTarget.value === "" ? null : event.currentTarget.value, reduction: null }, "step");
  return (
    <div class="tools pickers">
      <label>
        reduction{" "}
        <select
          value={reduction?.id ?? ""}
          onChange={(event) => address.write({ reduction: event.currentTarget.value === "" ? null : event.currentTarget.value, a: null, b: null }, "step")}
        >
          <option value="">{reductions.length === 0 ? "none" : "choose …"}</option>
          {reductions.map(option)}
        </select>
      </label>
      <span class="gap">or</span>
      <label>run <select value={a?.id ?? ""} onChange={pick("a")}><option value="">choose …</option>{runs.map(option)}</select></label>
      <label>with <select value={b?.id ?? ""} onChange={pick("b")}><option value="">choose …</option>{runs.map(option)}</select></label>
      {reduction?.state === "complete" && <a class="report" href={`/api/reductions/${reduction.id}/report.html`} download={`${reduction.name}.html`}>Download the report</a>}
    </div>
  );
}

function OfReduction({ studio, job }: { studio: Studio; job: Job }) {
  const isDone = job.state === "complete";
  const data = useResource(isDone ? job.id : null, (id) => get<ReductionData>(`/reductions/${id}`));
  if (isDone) {
    return (
      <When resource={data} waiting="Reading the comparison …">
        {(found) => (
          <Beside
            studio={studio}
            sides={[{ name: "full", run: job.run ?? "" }, { name: "reduced", run: job.id }]}
            facts={found.facts}
            outputs={found.outputs}
            balances={found.balances}
            pictures={[null, found.picture]}
            window={found.window}
            study={found}
          />
        )}
      </When>
    );
  }
  const { progress } = job;
  const share = progress === null || progress.end === 0 ? undefined : Math.min(1, progress.time / progress.end);
  return (
    <section class="job-now" data-job={job.id} data-state={job.state} aria-live="polite">
      <div class="head">
        <h2>Building the reduced model</h2>
        <StateMark job={job} />
        {!isOver(job.state) && <button type="button" onClick={() => void post<Job>(`/jobs/${job.id}/cancel`, {}).then((now) => studio.jobs.take(now))}>Cancel</button>}
      </div>
      {!isOver(job.state) && <progress max="1" {...(share === undefined ? {} : { value: share })} aria-label="Part that is done" />}
      {job.state === "failed" || job.state === "lost" ? (
        <div class="fault-box" role="alert">
          <p class="what">{job.message}</p>
          <ul>{job.elements.map((path) => <li key={path}>{path}</li>)}</ul>
        </div>
      ) : (
        <p class="hint">{job.message}</p>
      )}
    </section>
  );
}

function OfRuns({ studio, a, b }: { studio: Studio; a: Job; b: Job }) {
  const data = useResource(`${a.id} ${b.id}`, () => get<ComparisonData>("/compare", { a: a.id, b: b.id }));
  const name = (job: Job): string => `${job.scenario}, ${made(job)}`;
  return (
    <When resource={data} waiting="Comparing the runs …">
      {(found) => (
        <Beside
          studio={studio}
          sides={[{ name: name(a), run: a.id }, { name: name(b), run: b.id }]}
          facts={found.facts}
          outputs={found.outputs}
          balances={found.balances}
          pictures={[found.pictures.a, found.pictures.b]}
          window={[Math.max(a.window[0], b.window[0]), Math.min(a.window[1], b.window[1])]}
          study={null}
        />
      )}
    </When>
  );
}
