import { describe, expect, test } from "vitest";
import { changed, hashOf, placeOf } from "../src/views/address.ts";

describe("an address", () => {
  test.each([
    "#/model?model=truck&open=engine,chassis.front_axle&selected=chassis.drag",
    "#/plots?run=12&run=13&signal=body.flange.flow",
    "#/model?model=models/rig.py:Rig",
    "#threshold=0.97&shown=threshold",
    "#/",
  ])("%s is what it says", (hash) => {
    expect(hashOf(placeOf(hash)) || "#/").toBe(hash);
  });

  test("has a screen, or words alone", () => {
    expect(placeOf("#/activity?run=12").screen).toBe("activity");
    expect(placeOf("#/activity").screen).toBe("activity");
    expect(placeOf("#threshold=0.9").screen).toBe("");
    expect(placeOf("#threshold=0.9").words.get("threshold")).toBe("0.9");
    expect(placeOf("").words.size).toBe(0);
  });

  test("holds names with signs that addresses use themselves", () => {
    const words = changed(new URLSearchParams(), { selected: "a&b=c#d", model: "models/x y.py" });
    const found = placeOf(hashOf({ screen: "model", words })).words;
    expect(found.get("selected")).toBe("a&b=c#d");
    expect(found.get("model")).toBe("models/x y.py");
  });

  test("a word changes, repeats, or goes", () => {
    const words = changed(new URLSearchParams("run=1&open=a"), { run: ["2", "3"], open: null, mark: "x" });
    expect(words.getAll("run")).toEqual(["2", "3"]);
    expect(words.has("open")).toBe(false);
    expect(words.get("mark")).toBe("x");
  });
});
