/** Start: models to open, and the last runs. */

import { useSignal } from "@preact/signals";
import type { ModelEntry, Start } from "./api.ts";
import { get, post } from "./client.ts";
import { Dialog } from "./dialog.tsx";
import { When } from "./fault.tsx";
import { JobTable } from "./joblist.tsx";
import { useResource } from "./resource.ts";
import type { Studio } from "./studio.ts";

export function StartScreen({ studio }: { studio: Studio }) {
  const turn = useSignal(0);
  const start = useResource(`start ${turn.value}`, () => get<Start>("/start"));
  return (
    <div class="page-of start">
      <When resource={start} waiting="Looking for models …">
        {(found) => <Models studio={studio} start={found} again={() => (turn.value += 1)} />}
      </When>
    </div>
  );
}

const KINDS = [
  ["library", "Examples", "Models that come with propermodel"],
  ["document", "Documents", "Models saved as data in this folder"],
  ["python", "Python files", "Models written in Python in this folder"],
] as const;

function Models({ studio, start, again }: { studio: Studio; start: Start; again: () => void }) {
  const asked = useSignal<ModelEntry | null>(null);
  const open = (event: MouseEvent, entry: ModelEntry): void => {
    if (entry.kind !== "python" || start.trusted) return;
    event.preventDefault();
    asked.value = entry;
  };
  const models = (kind: ModelEntry["kind"]): ModelEntry[] => start.models.filter((entry) => entry.kind === kind);
  return (
    <>
      <header class="title">
        <h1>propermodel studio</h1>
        <p class="hint">
          {start.folder}, propermodel {start.version}
        </p>
      </header>
      {KINDS.map(([kind, title, note]) => (
        <>
          {models(kind).length > 0 && (
            <section key={kind} aria-labelledby={`models-${kind}`}>
              <h2 id={`models-${kind}`}>
                {title} <small>{note}{kind === "python" && !start.trusted ? "; opening one runs it, for which you are asked once" : ""}</small>
              </h2>
              <ul class="cards">
                {models(kind).map((entry) => (
                  <li key={entry.id} class="card" data-model={entry.id}>
                    <a class="name" href={studio.link("model", { model: entry.id })} onClick={(event) => open(event, entry)}>{entry.name}</a>
                    <p class="hint">{entry.note !== "" ? entry.note : (entry.file ?? "")}</p>
                    <p class="more">
                      <a href={studio.link("run", { model: entry.id })} onClick={(event) => open(event, entry)} aria-label={`Run ${entry.name}`}>run</a>
                      {entry.scenarios.length > 0 && <span class="hint">{entry.scenarios.join(", ")}</span>}
                    </p>
                  </li>
                ))}
              </ul>
            </section>
          )}
          {kind === "library" && (
            <section key="runs" aria-labelledby="last-runs">
              <h2 id="last-runs">Runs and reductions</h2>
              <JobTable studio={studio} jobs={studio.jobs.all.value} empty="Nothing has been run in this folder." />
            </section>
          )}
        </>
      ))}
      {asked.value !== null && (
        <TrustDialog
          folder={start.folder}
          entry={asked.value}
          onClose={() => (asked.value = null)}
          onTrust={async () => {
            const entry = asked.value;
            await post<unknown>("/trust", {});
            again();
            if (entry !== null) studio.go("model", { model: entry.id });
          }}
        />
      )}
    </>
  );
}

interface TrustProps {
  readonly folder: string;
  readonly entry: ModelEntry;
  readonly onClose: () => void;
  readonly onTrust: () => Promise<void>;
}

/** Opening a Python file runs it: asked once for a folder. */
function TrustDialog({ folder, entry, onClose, onTrust }: TrustProps) {
  const fault = useSignal("");
  return (
    <Dialog title="Run the Python files of this folder?" onClose={onClose}>
      <p>
        <b>{entry.file ?? entry.id}</b> is a program. To open the model, propermodel runs it, and it can do whatever you can do on this computer.
      </p>
      <p>Agree only if you trust everyone who can write into</p>
      <pre>{folder}</pre>
      {fault.value !== "" && <p class="fault" role="alert">{fault}</p>}
      <div class="dialog-foot">
        <button type="button" onClick={onClose}>Do not run it</button>
        <button
          type="button"
          class="primary"
          onClick={() => onTrust().catch((error: unknown) => (fault.value = error instanceof Error ? error.message : String(error)))}
        >
          Trust this folder
        </button>
      </div>
    </Dialog>
  );
}

