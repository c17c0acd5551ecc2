import { copyFileSync } from "node:fs";
import { defineConfig } from "vite";

const PACKAGE = "../src/propermodel";

/** The layout engine goes along as it was published, with its licence. */
const withLayoutEngine = {
  name: "with-layout-engine",
  closeBundle(): void {
    copyFileSync("node_modules/elkjs/lib/elk-worker.min.js", `${PACKAGE}/drawing/assets/elk-worker.min.js`);
    copyFileSync("node_modules/elkjs/LICENSE.md", `${PACKAGE}/drawing/assets/elk.LICENSE.md`);
  },
};

const BUILDS = {
  drawing: { entry: "src/static.ts", outDir: `${PACKAGE}/drawing/assets`, minify: false },
  report: { entry: "src/report.tsx", outDir: `${PACKAGE}/report/assets`, minify: true },
  studio: { entry: "src/studio.tsx", outDir: `${PACKAGE}/studio/assets`, minify: true },
} as const;

// What is built is committed with the Python package, so its users need no Node.
export default defineConfig(({ mode }) => {
  const { entry, outDir, minify } = BUILDS[mode as keyof typeof BUILDS];
  return {
    plugins: mode === "drawing" ? [withLayoutEngine] : [],
    define: { "process.env.NODE_ENV": '"production"' },
    build: {
      outDir,
      emptyOutDir: false,
      minify,
      lib: { entry, formats: ["iife"], name: "propermodel", fileName: () => `${mode}.js`, cssFileName: mode },
    },
  };
});
