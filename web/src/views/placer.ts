/** ELK in a worker, made from a text inside the page, so that placing never holds up the page. */

import ELK, { type ElkNode } from "elkjs/lib/elk-api.js";
import type { Placer } from "../graph/layout.ts";

/** A placer whose engine is a compressed script in an element of the page. */
export function placerFrom(element: HTMLElement): Placer {
  let made: Promise<Placer> | undefined;
  return {
    async layout(graph: ElkNode): Promise<ElkNode> {
      made ??= start(element.textContent ?? "");
      return (await made).layout(graph);
    },
  };
}

async function start(packed: string): Promise<Placer> {
  const bytes = Uint8Array.from(atob(packed.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = new Blob([await new Response(stream).arrayBuffer()], { type: "text/javascript" });
  const address = URL.createObjectURL(script);
  return new ELK({ workerFactory: () => new Worker(address) }) as unknown as Placer;
}
