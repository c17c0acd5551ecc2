/** An error for its reader: what is wrong, where, with whom, and what usually helps. */

import type { ComponentChildren } from "preact";
import type { Fault } from "./api.ts";
import { ServerError } from "./client.ts";
import type { Resource } from "./resource.ts";

interface FaultProps {
  readonly error: unknown;
  readonly onElement?: (path: string) => void;
}

export function FaultView({ error, onElement }: FaultProps) {
  if (!(error instanceof ServerError)) {
    const text = error instanceof Error ? error.message : String(error);
    return <div class="fault-box" role="alert"><p class="what">{text}</p></div>;
  }
  return (
    <>
      {[error.fault, ...(error.fault.others ?? [])].map((fault, i) => (
        <FaultBox key={i} fault={fault} {...(onElement === undefined ? {} : { onElement })} />
      ))}
    </>
  );
}

/** One fault or warning. */
export function FaultBox({ fault, onElement, isWarning }: { fault: Fault; onElement?: (path: string) => void; isWarning?: boolean }) {
  const { message, place, elements, help, code } = fault;
  return (
    <div class={isWarning === true ? "fault-box warning" : "fault-box"} role={isWarning === true ? "note" : "alert"}>
      <p class="what">{message}</p>
      {place !== "" && <p class="place">{place}</p>}
      {elements.length > 0 && (
        <ul>
          {elements.map((path) => (
            <li key={path}>
              {onElement === undefined ? path : <button type="button" class="plain link" onClick={() => onElement(path)}>{path}</button>}
            </li>
          ))}
        </ul>
      )}
      {help !== "" && <p class="help">{help}</p>}
      <p class="code">{code}</p>
    </div>
  );
}

interface WhenProps<T> {
  readonly resource: Resource<T>;
  readonly waiting: string;
  readonly children: (value: T) => ComponentChildren;
}

/** What is shown of a resource: itself, that it is awaited, or why it is not there. */
export function When<T>({ resource, waiting, children }: WhenProps<T>) {
  if (resource.state === "waiting") return <p class="waiting" role="status">{waiting}</p>;
  if (resource.state === "failed") return <FaultView error={resource.error} />;
  return <>{children(resource.value)}</>;
}
