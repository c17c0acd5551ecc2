/**
 * The picture document that Python makes of a model: what is drawn, without any place on the page.
 *
 * The same document feeds the static drawing, the notebook, the report and the studio. Python's side is
 * `propermodel.drawing.picture`; the two are tested against each other on shared documents.
 */

/** What a node is; modulated kinds carry the M that textbooks give them. */
export type Kind =
  | "0" | "1"
  | "I" | "C" | "R" | "MR"
  | "Se" | "Sf" | "MSe" | "MSf"
  | "TF" | "GY" | "MTF" | "MGY"
  | "controller" | "signal" | "input";

/** One level of the hierarchy; the root has the empty path. */
export interface Group {
  readonly path: string;
  readonly name: string;
  readonly parent: string;
}

/** A junction, an element, or a source or user of signals. */
export interface Node {
  readonly path: string;
  readonly kind: Kind;
  readonly name: string;
  readonly group: string;
  /** The entry of the ranking that its power counts in, for elements that store or dissipate. */
  readonly row?: string;
  /** What stands in its place in the reduced model: a short sign, and the same in words. */
  readonly gone?: { readonly sign: string; readonly meaning: string };
}

/** How the causality of a bond came about. */
export type Causality = "preferred" | "dependent" | "conflict" | "fixed" | "none";

/** A power connection; the half arrow points to `head`, the stroke stands where effort goes in. */
export interface Bond {
  readonly name: string;
  readonly tail: string;
  readonly head: string;
  readonly domain: string;
  readonly effortInto?: string;
  readonly causality: Causality;
  readonly gone?: boolean;
}

/** Information without power. */
export interface Signal {
  readonly from: string;
  readonly to: string;
}

/** Activities, as shares of the total: of rows and of single bonds. */
export interface Activity {
  readonly total: number;
  readonly rows: Readonly<Record<string, number>>;
  readonly bonds: Readonly<Record<string, number>>;
}

export interface Picture {
  readonly format: "propermodel picture";
  readonly version: 1;
  readonly name: string;
  readonly groups: readonly Group[];
  readonly nodes: readonly Node[];
  readonly bonds: readonly Bond[];
  readonly signals: readonly Signal[];
  readonly activity?: Activity;
}

export const isJunction = (node: { readonly kind: Kind }): boolean => node.kind === "0" || node.kind === "1";
export const isStorage = (kind: Kind): boolean => kind === "I" || kind === "C";
export const isEnergetic = (kind: Kind): boolean => isStorage(kind) || kind === "R" || kind === "MR";
export const isSource = (kind: Kind): boolean => kind === "Se" || kind === "Sf" || kind === "MSe" || kind === "MSf";
export const isTwoPort = (kind: Kind): boolean => kind === "TF" || kind === "GY" || kind === "MTF" || kind === "MGY";
export const isInformation = (kind: Kind): boolean => kind === "controller" || kind === "signal" || kind === "input";
