/** What is to be run: scenario, duration, method, and parameters that differ. The address holds it. */

import { useSignal } from "@preact/signals";
import type { ModelSheet, RunRequest, ScenarioSheet } from "./api.ts";
import { get } from "./client.ts";
import { When } from "./fault.tsx";
import { useResource } from "./resource.ts";
import { Preview } from "./preview.tsx";
import type { Studio } from "./studio.ts";

interface FormProps {
  readonly studio: Studio;
  readonly sheet: ModelSheet;
  readonly onRun: (request: RunRequest) => void;
  readonly isAsking: boolean;
}

export function RunForm({ studio, sheet, onRun, isAsking }: FormProps) {
  const { address } = studio;
  const name = address.word("scenario") ?? sheet.scenarios[0] ?? "";
  const scenario = useResource(`${sheet.id} ${name}`, () => get<ScenarioSheet>("/scenario", { model: sheet.id, scenario: name }));
  const settings = address.all("set").map(parsed);
  const number = (word: string): number | null => {
    const text = address.word(word);
    return text === null || text.trim() === "" || !Number.isFinite(Number(text)) ? null : Number(text);
  };
  const method = address.word("method") ?? sheet.method;
  const run = (event: Event): void => {
    event.preventDefault();
    onRun({
      model: sheet.id,
      scenario: name,
      until: number("until"),
      method,
      step: number("step") ?? (method === sheet.method ? sheet.step : null),
      tolerance: number("tolerance"),
      settings: Object.fromEntries(settings.filter(([path, value]) => path !== "" && value !== "")),
      outputs: [...sheet.outputs],
    });
  };
  const adjust = (word: string) => (event: { currentTarget: HTMLInputElement | HTMLSelectElement }) => {
    const { value } = event.currentTarget;
    address.write({ [word]: value === "" ? null : value });
  };
  return (
    <form class="run-form" onSubmit={run} aria-label="What to run">
      <label for="scenario">Scenario</label>
      <select id="scenario" value={name} onChange={adjust("scenario")}>
        {sheet.scenarios.map((one) => <option key={one} value={one}>{one}</option>)}
      </select>
      <div class="wide">
        <When resource={scenario} waiting="Reading the scenario …">{(found) => <Preview scenario={found} until={number("until")} />}</When>
      </div>
      <label for="until">Until</label>
      <Amount id="until" unit="s" value={address.word("until")} usual={scenario.state === "there" ? String(scenario.value.duration) : ""} onInput={adjust("until")} />
      <label for="method">Method</label>
      <select id="method" value={method} onChange={adjust("method")}>
        {sheet.methods.map((one) => <option key={one} value={one}>{one.replaceAll("_", " ")}</option>)}
      </select>
      <label for="step">Step</label>
      <Amount id="step" unit="s" value={address.word("step")} usual={sheet.step === null ? "chosen by the method" : String(sheet.step)} onInput={adjust("step")} />
      <label for="tolerance">Tolerance</label>
      <Amount id="tolerance" unit="" value={address.word("tolerance")} usual="usual" onInput={adjust("tolerance")} />
      <Settings sheet={sheet} settings={settings} onChange={(changed) => address.write({ set: changed.map(([path, value]) => `${path}=${value}`) })} />
      <div class="wide foot">
        <button type="submit" class="primary" disabled={isAsking}>{isAsking ? "Asking …" : "Run"}</button>
      </div>
    </form>
  );
}

interface AmountProps {
  readonly id: string;
  readonly unit: string;
  readonly value: string | null;
  readonly usual: string;
  readonly onInput: (event: { currentTarget: HTMLInputElement }) => void;
}

function Amount({ id, unit, value, usual, onInput }: AmountProps) {
  const isWrong = value !== null && value !== "" && !(Number(value) > 0);
  return (
    <span class="amount">
      <input id={id} inputMode="decimal" value={value ?? ""} placeholder={usual} aria-invalid={isWrong} onInput={onInput} />
      <span class="unit">{unit}</span>
      {isWrong && <span class="fault">a positive number</span>}
    </span>
  );
}

type Setting = readonly [path: string, value: string];

function parsed(text: string): Setting {
  const mark = text.indexOf("=");
  return mark < 0 ? [text, ""] : [text.slice(0, mark), text.slice(mark + 1)];
}

interface SettingsProps {
  readonly sheet: ModelSheet;
  readonly settings: readonly Setting[];
  readonly onChange: (settings: readonly Setting[]) => void;
}

/** Parameters with other values than the model's. */
function Settings({ sheet, settings, onChange }: SettingsProps) {
  const added = useSignal("");
  const usual = new Map(sheet.parameters.map((row) => [row.path, row]));
  const add = (): void => {
    const row = usual.get(added.value);
    if (row === undefined || settings.some(([path]) => path === row.path)) return;
    onChange([...settings, [row.path, `${row.value} ${row.unit}`.trim()]]);
    added.value = "";
  };
  return (
    <fieldset class="wide settings">
      <legend>Parameters that differ</legend>
      {settings.map(([path, value], i) => (
        <div class="setting" key={path} data-setting={path}>
          <label for={`set-${i}`} title={path}>{path}</label>
          <input
            id={`set-${i}`}
            value={value}
            title="a number, and a unit if it is not the one of the model"
            onInput={(event) => onChange(settings.map((one, k) => (k === i ? [path, event.currentTarget.value] : one)))}
          />
          <button type="button" class="quiet" aria-label={`Leave ${path} as it is`} onClick={() => onChange(settings.filter((_, k) => k !== i))}>✕</button>
          <span class="hint">model: {usual.get(path)?.value ?? "?"} {usual.get(path)?.unit ?? ""}</span>
        </div>
      ))}
      <div class="setting adding">
        <input
          list="parameters"
          aria-label="Parameter to change"
          placeholder="Add a parameter"
          value={added.value}
          onInput={(event) => (added.value = event.currentTarget.value)}
          onKeyDown={(event) => {
            if (event.key !== "Enter") return;
            event.preventDefault();
            add();
          }}
        />
        <button type="button" disabled={!usual.has(added.value)} onClick={add}>Add</button>
        <datalist id="parameters">{sheet.parameters.map((row) => <option key={row.path} value={row.path}>{`${row.value} ${row.unit}`}</option>)}</datalist>
      </div>
    </fieldset>
  );
}
