/** The report: one page with everything a reader asks about a reduction, complete in its file. */

import "uplot/dist/uPlot.min.css";
import "./views.css";
import "./report.css";
import { render } from "preact";
import type { ComponentChildren } from "preact";
import { Address } from "./views/address.ts";
import { BOTH, panelsOf } from "./views/compared.ts";
import type { StudyData } from "./views/data.ts";
import { ElementView } from "./views/element.tsx";
import { FrontView } from "./views/front.tsx";
import { LanesView, ownZoom } from "./views/lanes.tsx";
import { placerFrom } from "./views/placer.ts";
import { RankingView } from "./views/ranking.tsx";
import { ReductionGraph } from "./views/reduction.tsx";
import { EmbeddedSource } from "./views/source.ts";
import { RankingState } from "./views/state.ts";
import { Balances, Certificate, Facts, Notes, Outputs, Pairs } from "./views/tables.tsx";
import { Themes } from "./views/theme.ts";

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

const data = JSON.parse(document.getElementById("data")?.textContent ?? "") as StudyData;
const placer = placerFrom(document.getElementById("elk") as HTMLElement);
const source = new EmbeddedSource(data);
const address = new Address();
const themes = new Themes(address);
const state = new RankingState(data, address, "reduction");
const zoom = ownZoom();
const panels = panelsOf(data);

function Report() {
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
          <button type="button" aria-label="Light or dark" onClick={() => themes.turn()}>◐</button>
        </nav>
      </header>
      <main>
        <Section id="summary" title="Summary">
          <Facts facts={data.facts} />
          <Notes notes={data.notes} />
        </Section>
        <Section id="graph" title="Bond graph">
          <ReductionGraph state={state} placer={placer} theme={themes.theme} />
          <ElementView state={state} source={source} run="full" theme={themes.theme} />
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
          <Outputs outputs={data.outputs} />
          <LanesView
            source={source}
            groups={panels}
            runs={BOTH}
            difference="difference"
            whole={data.window}
            zoom={zoom}
            theme={themes.theme}
            name={`${data.model}, full and reduced`}
          />
        </Section>
        <Section id="energy" title="Energy">
          <Balances {...data.balances} />
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

render(<Report />, document.getElementById("app") as HTMLElement);
