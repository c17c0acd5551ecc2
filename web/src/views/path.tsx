/** A path that breaks between its names, where there is no room for it in one line. */

export function PathText({ path }: { path: string }) {
  const names = path.split(".");
  return (
    <span class="path">
      {names.map((name, i) => (
        <>
          {i > 0 && <>.<wbr /></>}
          {name}
        </>
      ))}
    </span>
  );
}
