/** Windows over the page. */

import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { getText } from "./client.ts";
import { When } from "./fault.tsx";
import { useResource } from "./resource.ts";

interface DialogProps {
  readonly title: string;
  readonly onClose: () => void;
  readonly children: ComponentChildren;
}

export function Dialog({ title, onClose, children }: DialogProps) {
  const place = useRef<HTMLDialogElement>(null);
  useEffect(() => place.current?.showModal(), []);
  return (
    <dialog ref={place} aria-labelledby="dialog-title" onClose={onClose} onClick={(event) => event.target === place.current && place.current?.close()}>
      <div class="dialog-head">
        <h2 id="dialog-title">{title}</h2>
        <button type="button" aria-label="Close" onClick={() => place.current?.close()}>✕</button>
      </div>
      {children}
    </dialog>
  );
}

/** The Python that does what the screen shows. */
export function PythonDialog({ query, onClose }: { query: Readonly<Record<string, string | readonly string[]>>; onClose: () => void }) {
  const text = useResource(JSON.stringify(query), () => getText("/python", query));
  return (
    <Dialog title="The Python for this" onClose={onClose}>
      <When resource={text} waiting="Writing it …">
        {(written) => (
          <>
            <pre class="python" tabIndex={0}>{written}</pre>
            <button type="button" onClick={() => void navigator.clipboard.writeText(written)}>Copy</button>
          </>
        )}
      </When>
    </Dialog>
  );
}
