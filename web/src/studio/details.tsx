/** What is known of what is selected in a model: an element, a junction, or a group. */

import type { ReadonlySignal } from "@preact/signals";
import type { Bond } from "../graph/picture.ts";
import type { GraphChoices } from "../views/choices.ts";
import type { ElementSheet, ModelSheet } from "./api.ts";
import { FaultBox } from "./fault.tsx";
import { ParameterTable } from "./lists.tsx";

interface DetailsProps {
  readonly sheet: ModelSheet;
  readonly choices: GraphChoices;
  readonly marked: ReadonlySignal<ReadonlySet<string>>;
}

export function Details({ sheet, choices, marked }: DetailsProps) {
  const selected = choices.selected.value;
  const { picture } = sheet;
  const node = picture.nodes.find((found) => found.path === selected) ?? picture.nodes.find((found) => found.row === selected);
  const group = picture.groups.find((found) => found.path === selected && found.path !== "");
  return (
    <>
      {marked.value.size > 0 && <Marked paths={[...marked.value]} choices={choices} />}
      {node !== undefined ? (
        <ElementDetails path={node.path} kind={node.kind} known={sheet.elements[node.path]} sheet={sheet} choices={choices} />
      ) : group !== undefined ? (
        <GroupDetails path={group.path} sheet={sheet} choices={choices} />
      ) : (
        <Overview sheet={sheet} choices={choices} />
      )}
    </>
  );
}

function Overview({ sheet, choices }: { sheet: ModelSheet; choices: GraphChoices }) {
  return (
    <>
      <h3>{sheet.name}</h3>
      <p class="hint">Select an element for its law, parameters and equations. A box opens, a frame closes.</p>
      {sheet.warnings.map((warning, i) => (
        <FaultBox key={i} fault={warning} isWarning onElement={(path) => choices.show(path)} />
      ))}
      <Part title="Outputs">
        {sheet.outputs.length === 0 ? <p class="hint">none named</p> : <ul class="plain">{sheet.outputs.map((path) => <li key={path}>{path}</li>)}</ul>}
      </Part>
      <Part title="Scenarios">
        <ul class="plain">{sheet.scenarios.map((name) => <li key={name}>{name}</li>)}</ul>
      </Part>
      <Part title="Keys">
        <dl class="keys">
          <dt><kbd>/</kbd></dt><dd>find an element</dd>
          <dt><kbd>e</kbd></dt><dd>open or close the group</dd>
          <dt><kbd>f</kbd></dt><dd>fit the whole graph</dd>
          <dt><kbd>Esc</kbd></dt><dd>select nothing</dd>
        </dl>
      </Part>
    </>
  );
}

interface ElementDetailsProps {
  readonly path: string;
  readonly kind: string;
  readonly known: ElementSheet | undefined;
  readonly sheet: ModelSheet;
  readonly choices: GraphChoices;
}

function ElementDetails({ path, kind, known, sheet, choices }: ElementDetailsProps) {
  const bonds = sheet.picture.bonds.filter((bond) => bond.tail === path || bond.head === path);
  const givers = sheet.picture.signals.filter((signal) => signal.to === path);
  return (
    <>
      <h3>
        {path} <small>{kind}</small>
      </h3>
      {known !== undefined && known.place !== "" && <p class="place">{known.place}</p>}
      {known !== undefined && known.laws.length > 0 && (
        <Part title="Law">{known.laws.map((law) => <code key={law} class="block">{law}</code>)}</Part>
      )}
      {known !== undefined && known.parameters.length > 0 && (
        <Part title="Parameters"><ParameterTable rows={known.parameters} base={path} /></Part>
      )}
      {known !== undefined && known.equations.length > 0 && (
        <Part title="Equations, in causal form">{known.equations.map((line) => <code key={line} class="block">{line}</code>)}</Part>
      )}
      {bonds.length > 0 && (
        <Part title="Bonds">
          <table class="bonds">
            <thead>
              <tr>
                <th>bond</th>
                <th>effort</th>
                <th>flow</th>
                <th>with</th>
              </tr>
            </thead>
            <tbody>
              {bonds.map((bond) => {
                const units = known?.bonds.find((found) => found.name === bond.name);
                const other = bond.tail === path ? bond.head : bond.tail;
                return (
                  <tr key={bond.name}>
                    <td>
                      {bond.name}
                      <div class="hint">{causalityOf(bond, path)}</div>
                    </td>
                    <td>{units?.effort ?? ""}</td>
                    <td>{units?.flow ?? ""}</td>
                    <td><button type="button" class="plain link" onClick={() => choices.show(other)}>{other}</button></td>
                  </tr>
                );
              })}
            </tbody>
          </table>
        </Part>
      )}
      {givers.length > 0 && (
        <Part title="Has information from">
          <ul class="plain">
            {givers.map((signal) => (
              <li key={signal.from}><button type="button" class="plain link" onClick={() => choices.show(signal.from)}>{signal.from}</button></li>
            ))}
          </ul>
        </Part>
      )}
    </>
  );
}

/** What a stroke says, in words. */
function causalityOf(bond: Bond, path: string): string {
  const sense = `${bond.domain.replaceAll("_", " ")}, power ${bond.head === path ? "in" : "out"}`;
  if (bond.effortInto === undefined) return sense;
  const side = bond.effortInto === path ? "is given the effort, answers with the flow" : "gives the effort, is given the flow";
  return `${sense}; ${side}${bond.causality === "preferred" ? "" : ` (${bond.causality})`}`;
}

function GroupDetails({ path, sheet, choices }: { path: string; sheet: ModelSheet; choices: GraphChoices }) {
  const { groups, nodes } = sheet.picture;
  const inside = nodes.filter((node) => node.group === path || node.group.startsWith(`${path}.`));
  const elements = inside.filter((node) => node.kind !== "0" && node.kind !== "1");
  const parts = groups.filter((group) => group.parent === path && group.path !== "");
  const isOpen = choices.open.value.has(path);
  return (
    <>
      <h3>
        {path} <small>group</small>
      </h3>
      <p class="hint">
        {elements.length} elements, {inside.length - elements.length} junctions
      </p>
      <p><button type="button" onClick={() => choices.toggle(path)}>{isOpen ? "Close" : "Open"} in the graph</button></p>
      {parts.length > 0 && (
        <Part title="Groups in it">
          <ul class="plain">{parts.map((group) => <li key={group.path}><button type="button" class="plain link" onClick={() => choices.show(group.path)}>{group.name}</button></li>)}</ul>
        </Part>
      )}
      <Part title="Elements in it">
        <ul class="plain">
          {elements.map((node) => (
            <li key={node.path}>
              <button type="button" class="plain link" onClick={() => choices.show(node.path)}>{node.path.slice(path.length + 1)}</button> <span class="hint">{node.kind}</span>
            </li>
          ))}
        </ul>
      </Part>
    </>
  );
}

const MOST_MARKED = 40;

function Marked({ paths, choices }: { paths: readonly string[]; choices: GraphChoices }) {
  return (
    <Part title={`Marked: ${paths.length}`}>
      <ul class="plain marked-list">
        {paths.slice(0, MOST_MARKED).map((path) => (
          <li key={path}><button type="button" class="plain link" onClick={() => choices.show(path)}>{path}</button></li>
        ))}
        {paths.length > MOST_MARKED && <li class="hint">and {paths.length - MOST_MARKED} more</li>}
      </ul>
    </Part>
  );
}

function Part({ title, children }: { title: string; children: preact.ComponentChildren }) {
  return (
    <section class="part">
      <h4>{title}</h4>
      {children}
    </section>
  );
}
