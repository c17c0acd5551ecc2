/** Taking things along: drawings and plots as SVG and PNG, tables as CSV. */

/** Let the reader save a text or picture as a file. */
export function save(content: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Save a drawing of a size in px. */
export async function savePictureText(text: string, width: number, height: number, name: string, kind: "svg" | "png"): Promise<void> {
  if (kind === "svg") save(new Blob([text], { type: "image/svg+xml" }), `${name}.svg`);
  else save(await painted(text, width, height), `${name}.png`);
}

/** A drawing as a picture with two dots for each px. */
async function painted(svg: string, width: number, height: number): Promise<Blob> {
  const image = new Image(width, height);
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.ceil(2 * width), Math.ceil(2 * height)];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve, reject) =>
    canvas.toBlob((blob) => (blob === null ? reject(new Error("the browser cannot write PNG")) : resolve(blob)), "image/png"),
  );
}

/** Rows of cells as CSV. */
export function csv(rows: readonly (readonly string[])[]): string {
  const cell = (text: string): string => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  return rows.map((row) => row.map(cell).join(",")).join("\n") + "\n";
}

/** A table of the page as CSV. */
export function csvOf(table: HTMLTableElement): string {
  return csv([...table.rows].map((row) => [...row.cells].map((cell) => (cell.dataset.value ?? cell.textContent ?? "").trim())));
}

export const saveCsv = (text: string, name: string): void => save(new Blob([text], { type: "text/csv" }), `${name}.csv`);
