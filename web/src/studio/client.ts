/** Asking the server. */

import { numbers } from "../views/data.ts";
import type { Histories, Series, Source, Span } from "../views/source.ts";
import type { Fault, RowHistory } from "./api.ts";

/** The server's answer was an error. */
export class ServerError extends Error {
  constructor(
    readonly status: number,
    readonly fault: Fault,
  ) {
    super(fault.message);
  }
}

type Query = Readonly<Record<string, string | number | null | readonly string[]>>;

export function addressOf(path: string, query: Query = {}): string {
  const words = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    if (value === null) continue;
    if (typeof value === "object") for (const one of value) words.append(name, one);
    else words.set(name, String(value));
  }
  const text = words.toString();
  return `/api${path}${text === "" ? "" : `?${text}`}`;
}

async function answered(path: string, query: Query, init: RequestInit = {}): Promise<Response> {
  const response = await fetch(addressOf(path, query), init);
  if (response.ok) return response;
  const text = await response.text();
  throw new ServerError(response.status, faultIn(text, response.status));
}

/** What an answer says went wrong; one that is no JSON is shown as it is. */
function faultIn(text: string, status: number): Fault {
  const plain: Fault = { code: `http/${status}`, message: text.trim() || `the server answered ${status}`, place: "", elements: [], help: "" };
  try {
    const found = (JSON.parse(text) as { readonly error?: Partial<Fault> }).error;
    return found === undefined ? plain : { ...plain, ...found };
  } catch {
    return plain;
  }
}

export async function get<T>(path: string, query: Query = {}): Promise<T> {
  return (await (await answered(path, query)).json()) as T;
}

export async function getText(path: string, query: Query = {}): Promise<string> {
  return (await answered(path, query)).text();
}

export async function post<T>(path: string, body: unknown): Promise<T> {
  const init = { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  return (await (await answered(path, {}, init)).json()) as T;
}

export async function remove(path: string): Promise<void> {
  await answered(path, {}, { method: "DELETE", headers: { "Content-Type": "application/json" } });
}

/** What the difference of two runs (the second less the first) is called where a run is asked for. */
export const differenceOf = (a: string, b: string): string => `difference:${a}:${b}`;

/** Columns from the server. */
export class ServerSource implements Source {
  async series(run: string, signals: readonly string[], [from, to]: Span, count: number): Promise<Series> {
    const query = { signal: signals, from, to, count };
    const [kind, a, b] = run.split(":");
    const response =
      kind === "difference"
        ? await answered("/compare/series", { a: a ?? "", b: b ?? "", ...query })
        : await answered(`/runs/${encodeURIComponent(run)}/series`, query);
    return unpacked(await response.arrayBuffer(), signals);
  }

  async histories(run: string, row: string): Promise<Histories> {
    const found = await get<RowHistory>(`/runs/${encodeURIComponent(run)}/history`, { row });
    return { times: numbers(found.times), items: found.items };
  }

  async values(run: string, signals: readonly string[], time: number): Promise<ReadonlyMap<string, number>> {
    const found = await get<{ readonly values: Readonly<Record<string, number | null>> }>(`/runs/${encodeURIComponent(run)}/values`, { signal: signals, time });
    return new Map(Object.entries(found.values).filter((entry): entry is [string, number] => entry[1] !== null));
  }
}

/** Instants as 8-byte numbers, then for each signal its column of 4-byte ones; all little-endian. */
export function unpacked(bytes: ArrayBuffer, signals: readonly string[]): Series {
  const rows = bytes.byteLength / (8 + 4 * signals.length);
  const times = new Float64Array(bytes, 0, rows);
  const columns = new Map(signals.map((path, i) => [path, new Float32Array(bytes, 8 * rows + 4 * rows * i, rows)] as const));
  return { times, columns };
}
