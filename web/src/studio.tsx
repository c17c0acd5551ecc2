/** The studio: models, runs, plots, activity and reductions in a page served from this computer. */

import "uplot/dist/uPlot.min.css";
import "./views.css";
import "./studio.css";
import { render } from "preact";
import { useEffect } from "preact/hooks";
import { ActivityScreen } from "./studio/activity.tsx";
import type { ModelSheet } from "./studio/api.ts";
import { CompareScreen } from "./studio/compare.tsx";
import { When } from "./studio/fault.tsx";
import { ModelScreen } from "./studio/model.tsx";
import { PlotsScreen } from "./studio/plots.tsx";
import { useResource } from "./studio/resource.ts";
import { RunScreen } from "./studio/run.tsx";
import { Shell } from "./studio/shell.tsx";
import { StartScreen } from "./studio/start.tsx";
import { SCREENS, Studio } from "./studio/studio.ts";

const studio = new Studio();

function App() {
  const screen = studio.screen.value;
  const model = studio.model.value;
  const sheet = useResource(screen === "" ? null : model, (id) => studio.sheet(id));
  useEffect(() => {
    const title = SCREENS.find(([name]) => name === screen)?.[1] ?? "";
    document.title = screen === "" ? "propermodel studio" : `${title}: ${model ?? ""}, propermodel studio`;
    if (screen === "") document.body.dataset.ready = "true";
  }, [screen, model]);
  return (
    <Shell studio={studio} sheet={sheet.state === "there" ? sheet.value : null}>
      {screen === "" ? (
        <StartScreen studio={studio} />
      ) : model === null ? (
        <p class="page-of hint">Choose a model or a run on the <a href={studio.link("")}>start page</a>.</p>
      ) : (
        <When resource={sheet} waiting={`Opening ${model} …`}>{(found) => <ScreenView sheet={found} />}</When>
      )}
    </Shell>
  );
}

function ScreenView({ sheet }: { sheet: ModelSheet }) {
  switch (studio.screen.value) {
    case "model":
      return <ModelScreen key={sheet.id} studio={studio} sheet={sheet} />;
    case "run":
      return <RunScreen key={sheet.id} studio={studio} sheet={sheet} />;
    case "plots":
      return <PlotsScreen key={sheet.id} studio={studio} sheet={sheet} />;
    case "activity":
      return <ActivityScreen key={sheet.id} studio={studio} sheet={sheet} />;
    case "compare":
      return <CompareScreen key={sheet.id} studio={studio} sheet={sheet} />;
    case "":
      return null;
  }
}

studio.jobs.start();
render(<App />, document.getElementById("app") as HTMLElement);
