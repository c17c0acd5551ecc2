/**
 * Where views get their columns: from a server, or from the data inside the page. Everything above this interface is the same
 * in the studio and in a report.
 */

import { numbers, type History, type StudyData } from "./data.ts";

/** A part of the time, s. */
export type Span = readonly [number, number];

/** Signals of one run on common instants: least and greatest value of every interval, in turn. */
export interface Series {
  readonly times: ArrayLike<number>;
  readonly columns: ReadonlyMap<string, ArrayLike<number>>;
}

/** What an element did: effort, flow and power at its ports. */
export interface Histories {
  readonly times: ArrayLike<number>;
  readonly items: readonly History[];
}

export interface Source {
  /** Signals of a run within a span, in about so many intervals; signals that a run has not are missing. */
  series(run: string, signals: readonly string[], span: Span, count: number): Promise<Series>;
  /** Effort, flow and power at the ports of a row of a run. */
  histories(run: string, row: string): Promise<Histories>;
  /** The sample of each signal next to a time, where there is more than what is drawn. */
  values?(run: string, signals: readonly string[], time: number): Promise<ReadonlyMap<string, number>>;
}

/** The runs of a reduction, as a report has them inside: `full`, `reduced`, and `difference` of the two. */
export class EmbeddedSource implements Source {
  private readonly times: Float32Array;

  constructor(private readonly data: StudyData) {
    this.times = numbers(data.signals.times);
  }

  series(run: string, signals: readonly string[]): Promise<Series> {
    const wanted = new Set(signals);
    const columns = new Map<string, ArrayLike<number>>();
    for (const item of this.data.signals.items) {
      const packed = run === "full" ? item.full : run === "reduced" ? item.reduced : item.difference;
      if (wanted.has(item.path) && packed !== null) columns.set(item.path, numbers(packed));
    }
    return Promise.resolve({ times: this.times, columns });
  }

  histories(_run: string, row: string): Promise<Histories> {
    const { times, rows } = this.data.histories;
    return Promise.resolve({ times: numbers(times), items: rows[row] ?? [] });
  }
}
