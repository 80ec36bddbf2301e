// SPDX-License-Identifier: Apache-2.0
import "./style.css";
import {errorHistogram, errorPlane, noiseSpectrum} from "./analysis";
import {buildBudget} from "./budget";
import {drawHistogram, drawSpectra, stylesOf} from "./charts";
import {buildCost, type CostSection} from "./cost";
import {readReport} from "./data";
import {byId, guarded, h, showError} from "./dom";
import {buildTables} from "./table";
import {setUpTheme} from "./theme";
import {buildControls} from "./view_controls";
import {listen, showProbe} from "./view_input";
import {rivalName} from "./view_state";
import {Viewer} from "./viewer";

function buildViewer(viewer: Viewer): void {
  const update = buildControls(viewer);
  let waits = false;
  viewer.onChange = () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(
      guarded(() => {
        waits = false;
        update();
      }),
    );
  };
  viewer.onProbe = (probe) => showProbe(viewer, probe);
  listen(viewer);
  showProbe(viewer, null);
  byId("painter").textContent = viewer.painter.name;
  update();
  viewer.refresh();
}

// The chosen picture's error and that of the one beside it, or of what is pinned.
function buildAnalysis(viewer: Viewer): void {
  const {report, state} = viewer;
  const draw = guarded(async () => {
    const indices = [...new Set([state.a, state.b, ...state.pinned])].filter(
      (i) => i >= 0 && !report.pictures[i]?.isReference,
    );
    const styles = stylesOf(indices.map(String));
    const histograms = [];
    const spectra = [];
    for (const index of indices) {
      const reference = report.pictures[index]?.reference ?? -1;
      const style = styles.get(String(index));
      if (reference < 0 || !style) continue;
      const test = (await viewer.store.get(index)).pixels;
      const truth = (await viewer.store.get(reference)).pixels;
      if (test.width !== truth.width || test.height !== truth.height) continue;
      const plane = errorPlane(test, truth);
      const name = rivalName(report, index);
      histograms.push({name, style, values: errorHistogram(plane)});
      spectra.push({name, style, values: noiseSpectrum(plane, test.width, test.height)});
    }
    const box = byId("analysis-charts");
    const width = Math.max(320, Math.floor(box.clientWidth / 2) - 16);
    byId("analysis").hidden = histograms.length === 0;
    box.replaceChildren(
      h("figure", {}, h("figcaption", {}, "Errors by size"), drawHistogram(histograms, width)),
      h("figure", {}, h("figcaption", {}, "Errors by frequency"), drawSpectra(spectra, width)),
    );
  });
  let timer = 0;
  let before = "";
  const changed = viewer.onChange;
  viewer.onChange = () => {
    changed();
    const now = [state.a, state.b, ...state.pinned].join();
    if (now === before) return;
    before = now;
    clearTimeout(timer);
    timer = window.setTimeout(draw, 150); // not while somebody flips through
  };
  viewer.onChange();
  window.addEventListener("resize", draw);
}

function start(): void {
  setUpTheme();
  const report = readReport();
  document.body.classList.add("scripted");
  let viewer: Viewer | null = null;
  const shown = (): number => viewer?.state.a ?? -1;
  // On a panel, eight times as large; "": as plain pixels, whole; without a layout, as pictures are shown now.
  const look = (picture: number, layout?: string): void => {
    if (!viewer || picture < 0) return;
    const {view} = viewer.state;
    const isOfTwo = view === "difference" || view === "error"; // no picture is seen there
    if (layout === "") viewer.centre();
    if (layout) viewer.state.zoom = 8;
    viewer.set({
      a: picture,
      view: layout || (layout === "" && isOfTwo) ? "side" : view,
      swapped: false,
      ...(layout === undefined ? {} : {layout, isSeen: false}),
    });
    byId("pictures").scrollIntoView({block: "start"});
    viewer.canvas.focus({preventScroll: true});
  };
  let cost: CostSection | null = null;
  const budget = buildBudget(report, look, shown, (changed) => cost?.setBudget(changed));
  if (report.runs.length > 0 && report.measures.length > 0) {
    cost = buildCost(report, (picture) => look(picture), shown);
    cost.setBudget(budget);
    window.addEventListener("resize", () => cost?.draw());
  } else {
    byId("cost").hidden = true;
  }
  buildTables(report, (picture) => look(picture));
  if (report.pictures.length > 0) {
    const plain = new URLSearchParams(location.search).has("plain") || location.hash === "#plain";
    viewer = new Viewer(report, byId<HTMLCanvasElement>("canvas"), plain);
    buildViewer(viewer);
    buildAnalysis(viewer);
  } else {
    byId("pictures").hidden = true;
    byId("analysis").hidden = true;
  }
  for (const link of document.querySelectorAll<HTMLAnchorElement>("nav a"))
    link.hidden = byId(link.hash.slice(1)).hidden;
}

window.addEventListener("error", (event) => showError(event.error ?? event.message));
window.addEventListener("unhandledrejection", (event) => showError(event.reason));
guarded(start)();
