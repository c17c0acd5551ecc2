/** Runs and reductions as a table: how each went, and where it leads. */

import { useSignal } from "@preact/signals";
import { duration } from "../views/format.ts";
import type { Job } from "./api.ts";
import { post, remove } from "./client.ts";
import { hasData, isOver, made } from "./jobs.ts";
import type { Studio } from "./studio.ts";

interface JobTableProps {
  readonly studio: Studio;
  readonly jobs: readonly Job[];
  readonly empty: string;
  /** All are of one model, which need not be named. */
  readonly isOneModel?: boolean;
}

export function JobTable({ studio, jobs, empty, isOneModel }: JobTableProps) {
  const fault = useSignal("");
  if (jobs.length === 0) return <p class="hint">{empty}</p>;
  const tell = (error: unknown): void => void (fault.value = error instanceof Error ? error.message : String(error));
  const drop = (job: Job): void => {
    remove(`/jobs/${job.id}`).then(() => studio.jobs.drop(job.id), tell);
  };
  return (
    <>
      {fault.value !== "" && <p class="fault" role="alert">{fault}</p>}
      <table class="jobs">
        <thead>
          <tr>
            {isOneModel !== true && <th>model</th>}
            <th>scenario</th>
            <th>what</th>
            <th>state</th>
            <th class="number">simulated</th>
            <th class="number">x real time</th>
            <th>course</th>
            <th>made</th>
            <th>go to</th>
            <th><span class="unseen">remove</span></th>
          </tr>
        </thead>
        <tbody>
          {jobs.map((job) => (
            <tr key={job.id} data-job={job.id} data-state={job.state}>
              {isOneModel !== true && <td>{job.name}</td>}
              <td>{job.scenario}</td>
              <td>{job.kind}</td>
              <td><StateMark job={job} /></td>
              <td class="number">{job.progress === null ? "–" : `${Number(job.progress.time.toPrecision(5))} s`}</td>
              <td class="number">{speedOf(job)}</td>
              <td>{job.spark !== null && <Spark values={job.spark} />}</td>
              <td class="when">{made(job)}</td>
              <td class="links"><Links studio={studio} job={job} /></td>
              <td>
                {isOver(job.state) ? (
                  <button type="button" class="quiet" aria-label={`Remove ${job.kind} of ${job.name}, made ${made(job)}`} title="Remove, with what it recorded" onClick={() => drop(job)}>✕</button>
                ) : (
                  <button type="button" onClick={() => post<Job>(`/jobs/${job.id}/cancel`, {}).then((now) => studio.jobs.take(now), tell)}>cancel</button>
                )}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

/** How many times as fast as the reality: of the whole run when it is over, of the last moments before. */
function speedOf(job: Job): string {
  const whole = job.summary.find((fact) => fact.name === "speed");
  if (whole !== undefined) return whole.value.replace(" x real time", "");
  return job.progress === null ? "–" : String(Number(job.progress.rate.toPrecision(3)));
}

/** Where a job leads; `isHere` where it is shown already. */
export function Links({ studio, job, isHere }: { studio: Studio; job: Job; isHere?: boolean }) {
  if (job.kind === "reduction") {
    return <a href={studio.link("compare", { model: job.model, reduction: job.id })}>compare</a>;
  }
  return (
    <>
      {isHere !== true && <a href={studio.link("run", { model: job.model, job: job.id })}>run</a>}
      {hasData(job) && <a href={studio.link("plots", { model: job.model, run: job.id })}>plots</a>}
      {job.state === "complete" && <a href={studio.link("activity", { model: job.model, run: job.id })}>activity</a>}
    </>
  );
}

const SIGNS: Readonly<Record<Job["state"], string>> = {
  queued: "◌",
  running: "▶",
  complete: "✓",
  failed: "✗",
  cancelled: "■",
  lost: "?",
};

export function StateMark({ job }: { job: Job }) {
  const { progress } = job;
  const share = progress === null || progress.end === 0 ? null : Math.min(1, progress.time / progress.end);
  return (
    <span class={`state ${job.state}`} title={job.message}>
      <span aria-hidden="true">{SIGNS[job.state]}</span> {job.state}
      {job.state === "running" && share !== null && ` ${Math.floor(100 * share)} %`}
      {job.state === "running" && progress !== null && progress.left !== null && <small>, {duration(progress.left)} left</small>}
    </span>
  );
}

const WIDE = 60;
const HIGH = 18;

/** The course of a signal in 60 px. */
export function Spark({ values }: { values: readonly number[] }) {
  const known = values.filter((value) => Number.isFinite(value));
  const [low, high] = [Math.min(...known), Math.max(...known)];
  const y = (value: number): number => (high > low ? 1 + ((HIGH - 2) * (high - value)) / (high - low) : HIGH / 2);
  const d = values
    .map((value, i) => `${i === 0 ? "M" : "L"}${((WIDE * i) / Math.max(1, values.length - 1)).toFixed(1)} ${y(value).toFixed(1)}`)
    .join("");
  return (
    <svg class="spark" width={WIDE} height={HIGH} viewBox={`0 0 ${WIDE} ${HIGH}`} role="img" aria-label={`from ${low.toPrecision(3)} to ${high.toPrecision(3)}`}>
      <path d={d} />
    </svg>
  );
}
