/** Two runs beside one another: figures, graphs, measures, lanes with their difference, energy. */

import { useComputed } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Picture } from "../graph/picture.ts";
import { GraphChoices } from "../views/choices.ts";
import type { BalanceData, Fact, OutputRow } from "../views/data.ts";
import { GraphView, withoutRemovals } from "../views/graph.tsx";
import { LanesView, ownZoom, type LaneGroup } from "../views/lanes.tsx";
import type { Span } from "../views/source.ts";
import { Balances, Certificate, Facts, Notes, Outputs, Pairs } from "../views/tables.tsx";
import type { ReductionData, SignalEntry } from "./api.ts";
import { differenceOf, get } from "./client.ts";
import { When } from "./fault.tsx";
import { useResource } from "./resource.ts";
import { lastOf } from "./signals.ts";
import type { Studio } from "./studio.ts";

export interface Side {
  readonly name: string;
  readonly run: string;
}

interface BesideProps {
  readonly studio: Studio;
  readonly sides: readonly [Side, Side];
  readonly facts: readonly Fact[];
  readonly outputs: readonly OutputRow[];
  readonly balances: { readonly full: BalanceData; readonly reduced: BalanceData };
  /** The graphs; without a first one, the second as if nothing had been removed. */
  readonly pictures: readonly [Picture | null, Picture];
  readonly window: Span;
  /** What else is known of a reduction. */
  readonly study: ReductionData | null;
}

const USUAL_TOLERANCE = 0.01; // of the range, rms

export function Beside({ studio, sides, facts, outputs, balances, pictures, window, study }: BesideProps) {
  const { address } = studio;
  const names: readonly [string, string] = [sides[0].name, sides[1].name];
  const wanted = Number(address.word("tolerance"));
  const tolerance = address.word("tolerance") !== null && wanted > 0 ? wanted : USUAL_TOLERANCE;
  return (
    <>
      <Facts facts={facts} />
      {study !== null && <Notes notes={study.notes} />}
      <Graphs studio={studio} names={names} pictures={pictures} />
      <section aria-labelledby="measures">
        <h2 id="measures">Outputs</h2>
        <div class="tools">
          <label>
            passes with an rms error up to{" "}
            <input
              class="short"
              inputMode="decimal"
              value={String(Number((100 * tolerance).toPrecision(6)))}
              onChange={(event) => {
                const share = Number(event.currentTarget.value) / 100;
                if (share > 0) address.write({ tolerance: share === USUAL_TOLERANCE ? null : String(share) });
              }}
            />{" "}
            % of the range
          </label>
        </div>
        <Outputs outputs={outputs} names={names} tolerance={tolerance} />
      </section>
      <Lanes studio={studio} sides={sides} outputs={outputs} window={window} />
      <section aria-labelledby="balances">
        <h2 id="balances">Energy</h2>
        <Balances full={balances.full} reduced={balances.reduced} names={names} />
      </section>
      {study !== null && (
        <>
          <section aria-labelledby="certificate">
            <h2 id="certificate">Certificate</h2>
            <Certificate lines={study.certificate} />
          </section>
          <section aria-labelledby="made">
            <h2 id="made">How it was made</h2>
            <Pairs pairs={study.made} />
          </section>
        </>
      )}
    </>
  );
}

function Graphs({ studio, names, pictures }: { studio: Studio; names: readonly [string, string]; pictures: readonly [Picture | null, Picture] }) {
  const [whole, reduced] = pictures;
  const first = useMemo(() => whole ?? withoutRemovals(reduced), [whole, reduced]);
  const choices = useMemo(() => [new GraphChoices(first, studio.address), new GraphChoices(reduced, studio.address)] as const, [first, reduced]);
  const shown = [useComputed(() => first), useComputed(() => reduced)] as const;
  return (
    <section class="beside" aria-label="Graphs">
      {([0, 1] as const).map((side) => (
        <div key={side} class="graph-box">
          <h3>{names[side]}</h3>
          <GraphView choices={choices[side]} picture={shown[side]} placer={studio.placer} theme={studio.themes.theme} label={`Graph, ${names[side]}`} fits />
        </div>
      ))}
    </section>
  );
}

interface LanesProps {
  readonly studio: Studio;
  readonly sides: readonly [Side, Side];
  readonly outputs: readonly OutputRow[];
  readonly window: Span;
}

function Lanes({ studio, sides, outputs, window }: LanesProps) {
  const signals = useResource(sides[0].run, (id) => get<SignalEntry[]>(`/runs/${id}/signals`));
  const zoom = useMemo(ownZoom, [sides[0].run, sides[1].run]);
  const runs = useMemo(() => sides.map(({ name, run }) => ({ id: run, name })), [sides[0].run, sides[1].run]);
  const groups = useMemo(() => {
    const known = new Map((signals.state === "there" ? signals.value : []).map((entry) => [entry.path, entry]));
    return outputs.flatMap((row): LaneGroup[] => {
      const entry = known.get(row.path);
      if (entry === undefined) return [];
      return [{ title: row.path, unit: entry.display.unit, signals: [{ path: row.path, label: lastOf(row.path), factor: entry.display.factor }] }];
    });
  }, [signals.state, outputs]);
  return (
    <section aria-labelledby="courses">
      <h2 id="courses">Over time</h2>
      <When resource={signals} waiting="Reading the signals …">
        {() => (
          <LanesView
            source={studio.source}
            groups={groups}
            runs={runs}
            difference={differenceOf(sides[0].run, sides[1].run)}
            whole={window}
            zoom={zoom}
            theme={studio.themes.theme}
            name={`${sides[0].name} and ${sides[1].name}`}
          />
        )}
      </When>
    </section>
  );
}
