/** The report: one page with everything a reader asks about a reduction, complete in its file. */

import "uplot/dist/uPlot.min.css";
import "./report.css";
import { render } from "preact";
import type { ComponentChildren } from "preact";
import type { StudyData } from "./views/data.ts";
import { Element } from "./views/element.tsx";
import { FrontView } from "./views/front.tsx";
import { GraphView } from "./views/graph.tsx";
import { LanesView } from "./views/lanes.tsx";
import { placerFrom } from "./views/placer.ts";
import { RankingView } from "./views/ranking.tsx";
import { State } from "./views/state.ts";
import { Balances, Certificate, Facts, Outputs, Pairs } from "./views/tables.tsx";

const SECTIONS = [
  ["summary", "Summary"],
  ["graph", "Bond graph"],
  ["search", "Search"],
  ["ranking", "Activity"],
  ["outputs", "Full and reduced"],
  ["energy", "Energy"],
  ["certificate", "Certificate"],
  ["made", "How it was made"],
] as const;

function Section({ id, title, children }: { id: string; title: string; children: ComponentChildren }) {
  return (
    <section id={id} aria-labelledby={`${id}-title`}>
      <h2 id={`${id}-title`}>{title}</h2>
      {children}
    </section>
  );
}

function Report({ state, elk }: { state: State; elk: HTMLElement }) {
  const { data } = state;
  const placer = placerFrom(elk);
  const there = SECTIONS.filter(([id]) => id !== "search" || data.tried !== null);
  return (
    <>
      <header>
        <h1>
          {data.model} <small>reduced for {data.scenario}, {data.window[0]} to {data.window[1]} s</small>
        </h1>
        <nav aria-label="Sections">
          {there.map(([id, title]) => (
            <button key={id} type="button" onClick={() => document.getElementById(id)?.scrollIntoView()}>{title}</button>
          ))}
          <button
            type="button"
            aria-label="Light or dark"
            onClick={() => (state.theme.value = state.theme.value === "dark" ? "light" : "dark")}
          >
            ◐
          </button>
        </nav>
      </header>
      <main>
        <Section id="summary" title="Summary">
          <Facts data={data} />
          {data.notes.length > 0 && (
            <details class="notes" open={data.notes.length <= 4}>
              <summary>{data.notes.length} {data.notes.length === 1 ? "thing" : "things"} not to be overlooked</summary>
              <ul>
                {data.notes.map((note) => (
                  <li key={note}>{note}</li>
                ))}
              </ul>
            </details>
          )}
        </Section>
        <Section id="graph" title="Bond graph">
          <GraphView state={state} placer={placer} />
          <Element state={state} />
        </Section>
        {data.tried !== null && (
          <Section id="search" title="Models tried">
            <FrontView tried={data.tried} />
          </Section>
        )}
        <Section id="ranking" title="Activity and decisions">
          <RankingView state={state} />
        </Section>
        <Section id="outputs" title="Full model against reduced model">
          <Outputs data={data} />
          <LanesView state={state} />
        </Section>
        <Section id="energy" title="Energy">
          <Balances data={data} />
        </Section>
        <Section id="certificate" title="Certificate">
          <Certificate lines={data.certificate} />
        </Section>
        <Section id="made" title="How it was made">
          <Pairs pairs={data.made} />
        </Section>
      </main>
    </>
  );
}

const data = JSON.parse(document.getElementById("data")?.textContent ?? "") as StudyData;
const elk = document.getElementById("elk") as HTMLElement;
render(<Report state={new State(data)} elk={elk} />, document.getElementById("app") as HTMLElement);
