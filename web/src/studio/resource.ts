/** Something that is asked for, and shown when it is there. */

import { useEffect, useState } from "preact/hooks";

export type Resource<T> =
  | { readonly state: "waiting" }
  | { readonly state: "there"; readonly value: T }
  | { readonly state: "failed"; readonly error: unknown };

/** Ask anew whenever a key changes; without a key there is nothing to ask for. */
export function useResource<T>(key: string | null, ask: (key: string) => Promise<T>): Resource<T> {
  const [found, setFound] = useState<{ readonly key: string | null; readonly resource: Resource<T> }>({ key: null, resource: { state: "waiting" } });
  useEffect(() => {
    if (key === null) return;
    let isWanted = true;
    const take = (resource: Resource<T>): void => {
      if (isWanted) setFound({ key, resource });
    };
    ask(key).then(
      (value) => take({ state: "there", value }),
      (error: unknown) => take({ state: "failed", error }),
    );
    return () => {
      isWanted = false;
    };
  }, [key]);
  return found.key === key ? found.resource : { state: "waiting" };
}
