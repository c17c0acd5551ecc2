import { copyFileSync } from "node:fs";
import { defineConfig } from "vite";

const OUT = "../src/propermodel/drawing/assets";

/** The layout engine goes along as it was published, with its licence. */
const withLayoutEngine = {
  name: "with-layout-engine",
  closeBundle(): void {
    copyFileSync("node_modules/elkjs/lib/elk.bundled.js", `${OUT}/elk.bundled.js`);
    copyFileSync("node_modules/elkjs/LICENSE.md", `${OUT}/elk.LICENSE.md`);
  },
};

// The built script is committed with the Python package, so its users need no Node.
export default defineConfig({
  plugins: [withLayoutEngine],
  build: {
    outDir: OUT,
    emptyOutDir: false,
    minify: false,
    lib: { entry: "src/static.ts", formats: ["iife"], name: "propermodelDrawing", fileName: () => "drawing.js" },
  },
});
