/** The frame around every screen: the rail, where we are, finding, light and dark. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { GraphChoices } from "../views/choices.ts";
import type { ModelSheet } from "./api.ts";
import { PythonDialog } from "./dialog.tsx";
import { SCREENS, type Screen, type Studio } from "./studio.ts";

interface ShellProps {
  readonly studio: Studio;
  readonly sheet: ModelSheet | null;
  readonly children: ComponentChildren;
}

export function Shell({ studio, sheet, children }: ShellProps) {
  const screen = studio.screen.value;
  const showsPython = useSignal(false);
  const query = pythonQuery(studio);
  useEffect(() => {
    const typed = (event: KeyboardEvent): void => {
      const target = event.target as HTMLElement;
      const isWriting = target.matches("input:not([type=range]):not([type=checkbox]):not([type=radio]), textarea, select");
      if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]") !== null) return;
      if (event.key === "/" && !isWriting) {
        event.preventDefault();
        document.getElementById("find")?.focus();
      } else if (event.key === "Escape" && !isWriting) studio.address.write({ selected: null, mark: null });
      else if (event.key === "f" && !isWriting) document.querySelector<HTMLElement>("[data-fit]")?.click();
      else if (event.key === "e" && !isWriting && sheet !== null) {
        const choices = new GraphChoices(sheet.picture, studio.address);
        const selected = choices.selected.peek();
        const node = sheet.picture.nodes.find((found) => found.path === selected || found.row === selected);
        const group = node?.group ?? selected;
        if (group !== null && group !== "") choices.toggle(group);
      }
    };
    addEventListener("keydown", typed);
    return () => removeEventListener("keydown", typed);
  }, [sheet]);
  return (
    <>
      <a class="skip" href="#main" onClick={(event) => { event.preventDefault(); document.getElementById("main")?.focus(); }}>To the content</a>
      <nav class="rail" aria-label="Screens">
        {SCREENS.map(([name, title]) => (
          <a key={name} href={studio.link(name)} aria-current={screen === name ? "page" : undefined}>
            <Icon screen={name} />
            <span>{title}</span>
          </a>
        ))}
        <span class="gap" />
        <button type="button" aria-label="Light or dark" title="Light or dark" onClick={() => studio.themes.turn()}>◐</button>
      </nav>
      <header class="bar">
        <Crumbs studio={studio} sheet={sheet} />
        {!studio.jobs.isConnected.value && <span class="offline" role="alert">The server does not answer. Is it still running?</span>}
        {sheet !== null && screen !== "" && <Find studio={studio} sheet={sheet} />}
        {query !== null && <button type="button" onClick={() => (showsPython.value = true)}>Show the Python for this</button>}
      </header>
      <main id="main" tabIndex={-1} data-screen={screen}>{children}</main>
      {showsPython.value && query !== null && <PythonDialog query={query} onClose={() => (showsPython.value = false)} />}
    </>
  );
}

/** What the Python of this screen depends on. */
function pythonQuery(studio: Studio): Readonly<Record<string, string | readonly string[]>> | null {
  const { address } = studio;
  const model = studio.model.value;
  switch (studio.screen.value) {
    case "":
      return null;
    case "model":
      return model === null ? null : { model };
    case "run": {
      if (model === null) return null;
      const found: Record<string, string | readonly string[]> = { model, run: "yes" };
      for (const name of ["scenario", "until", "method", "step", "tolerance"]) {
        const value = address.word(name);
        if (value !== null) found[name] = value;
      }
      const settings = address.all("set");
      return settings.length === 0 ? found : { ...found, set: settings };
    }
    case "compare": {
      const last = studio.jobs.all.value.find((job) => job.kind === "reduction" && job.model === model)?.id;
      const job = address.word("reduction") ?? address.word("b") ?? address.word("a") ?? last;
      return job === undefined ? null : { job };
    }
    case "activity": {
      const run = studio.run.value;
      if (run === null) return null;
      const threshold = address.word("threshold");
      return threshold === null ? { job: run.id, activity: "yes" } : { job: run.id, activity: "yes", threshold };
    }
    case "plots": {
      const run = studio.run.value;
      return run === null ? null : { job: run.id, signal: address.all("signal") };
    }
  }
}

/** Model, and the levels down to what is selected. */
function Crumbs({ studio, sheet }: { studio: Studio; sheet: ModelSheet | null }) {
  const screen = studio.screen.value;
  const selected = studio.address.word("selected");
  if (screen === "" || sheet === null) return <div class="crumbs"><b>propermodel studio</b></div>;
  const parts = selected === null ? [] : selected.split(".");
  return (
    <nav class="crumbs" aria-label="Where we are">
      <ol>
        <li>
          <a href={studio.link("model", { selected: null })}>{sheet.name}</a>
        </li>
        {parts.map((part, i) => {
          const path = parts.slice(0, i + 1).join(".");
          return (
            <li key={path}>
              <button type="button" class="plain link" aria-current={i === parts.length - 1 ? "true" : undefined} onClick={() => new GraphChoices(sheet.picture, studio.address).show(path)}>
                {part}
              </button>
            </li>
          );
        })}
      </ol>
    </nav>
  );
}

const MOST = 12; // things offered

function Find({ studio, sheet }: { studio: Studio; sheet: ModelSheet }) {
  const text = useSignal("");
  const at = useSignal(0);
  const isOpen = useSignal(false);
  const field = useRef<HTMLInputElement>(null);
  const things = useMemo(
    () => [
      ...sheet.picture.groups.filter((group) => group.path !== "").map((group) => ({ path: group.path, kind: "group" })),
      ...sheet.picture.nodes.map((node) => ({ path: node.path, kind: node.kind })),
    ],
    [sheet],
  );
  const words = text.value.toLowerCase().split(/\s+/).filter((word) => word !== "");
  const found = words.length === 0 ? [] : things.filter(({ path }) => words.every((word) => path.toLowerCase().includes(word)));
  // What is named so comes before what is inside.
  found.sort((a, b) => a.path.length - b.path.length);
  const offered = found.slice(0, MOST);
  const take = (path: string): void => {
    new GraphChoices(sheet.picture, studio.address).show(path);
    text.value = "";
    isOpen.value = false;
    field.current?.blur();
  };
  const typed = (event: KeyboardEvent): void => {
    if (event.key === "ArrowDown") at.value = Math.min(offered.length - 1, at.value + 1);
    else if (event.key === "ArrowUp") at.value = Math.max(0, at.value - 1);
    else if (event.key === "Enter" && offered[at.value] !== undefined) take(offered[at.value]?.path ?? "");
    else if (event.key === "Escape") {
      text.value = "";
      field.current?.blur();
    } else return;
    event.preventDefault();
  };
  return (
    <div class="find">
      <input
        id="find"
        ref={field}
        type="text"
        placeholder="Find an element  /"
        aria-label="Find an element or group"
        role="combobox"
        aria-expanded={isOpen.value && offered.length > 0}
        aria-controls="found"
        aria-autocomplete="list"
        {...(isOpen.value && offered.length > 0 ? { "aria-activedescendant": `found-${at.value}` } : {})}
        autocomplete="off"
        value={text.value}
        onInput={(event) => {
          text.value = event.currentTarget.value;
          at.value = 0;
          isOpen.value = true;
        }}
        onKeyDown={typed}
        onBlur={() => setTimeout(() => (isOpen.value = false), 150)}
        onFocus={() => (isOpen.value = true)}
      />
      <ul id="found" role="listbox" aria-label="Found" hidden={!isOpen.value || words.length === 0}>
        {offered.map(({ path, kind }, i) => (
          <li key={path} id={`found-${i}`} role="option" aria-selected={i === at.value} onMouseDown={() => take(path)}>
            <span class="path">{path}</span> <span class="note">{kind}</span>
          </li>
        ))}
        {words.length > 0 && found.length === 0 && <li role="option" aria-selected="false" aria-disabled="true">nothing is called so</li>}
        {found.length > MOST && <li role="option" aria-selected="false" aria-disabled="true" class="note">and {found.length - MOST} more</li>}
      </ul>
    </div>
  );
}

const DRAWINGS: Readonly<Record<Screen, string>> = {
  "": "M4 11 12 4l8 7M6 10v10h12V10",
  model: "M4 6v12M4 12h16M20 12l-6 5",
  run: "M7 4l12 8-12 8z",
  plots: "M4 4v16h16M7 15l4-6 4 4 4-7",
  activity: "M5 20V5M10 20V9M15 20v-7M20 20v-3",
  compare: "M4 8c4-6 8 6 16 0M4 16c4-6 8 6 16 0",
};

function Icon({ screen }: { screen: Screen }) {
  return (
    <svg class="icon" viewBox="0 0 24 24" width="22" height="22" aria-hidden="true">
      <path d={DRAWINGS[screen]} fill="none" stroke="currentColor" stroke-width="1.7" stroke-linecap="round" stroke-linejoin="round" />
    </svg>
  );
}
