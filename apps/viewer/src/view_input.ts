// SPDX-License-Identifier: Apache-2.0
// Pointer, wheel and keyboard on the view.
import {byId, h, number} from "./dom";
import {groupsOf, rivalName} from "./view_state";
import type {Probe, Viewer} from "./viewer";

export function listen(viewer: Viewer): void {
  const {canvas, state} = viewer;
  const at = (event: MouseEvent): {x: number; y: number} => {
    const box = canvas.getBoundingClientRect();
    return {x: (event.clientX - box.left) * viewer.ratio, y: (event.clientY - box.top) * viewer.ratio};
  };
  let last: {x: number; y: number} | null = null;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    last = at(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const here = at(event);
    if (last) {
      viewer.pan(here.x - last.x, here.y - last.y);
      last = here;
    }
    viewer.pointTo(here.x, here.y);
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => (last = null));
  // The wheel alone scrolls the page, which would end here otherwise.
  const hint = byId("wheel-hint");
  let fades = 0;
  byId("stage").addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey && !event.metaKey) {
        hint.hidden = false;
        clearTimeout(fades);
        fades = window.setTimeout(() => (hint.hidden = true), 1200);
        return;
      }
      hint.hidden = true;
      event.preventDefault();
      const here = at(event);
      viewer.zoomTo(viewer.zoom * 2 ** (-event.deltaY / 240), here.x, here.y);
      viewer.pointTo(here.x, here.y);
    },
    {passive: false},
  );
  canvas.addEventListener("dblclick", () => {
    viewer.centre();
    viewer.set({});
  });

  const handle = byId("handle");
  const slide = (split: number): void => viewer.set({split: Math.min(1, Math.max(0, split))});
  handle.addEventListener("pointerdown", (event) => handle.setPointerCapture(event.pointerId));
  handle.addEventListener("pointermove", (event) => {
    if (!handle.hasPointerCapture(event.pointerId)) return;
    const box = canvas.getBoundingClientRect();
    slide((event.clientX - box.left) / box.width);
  });
  // Who drags it has not come for its keys.
  handle.addEventListener("pointerup", () => canvas.focus({preventScroll: true}));
  handle.addEventListener("keydown", (event) => {
    const step = {ArrowLeft: -0.02, ArrowRight: 0.02}[event.key];
    if (step === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    slide(state.split + step);
  });

  document.addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (isKeyOf(target, event.key)) return;
    if (press(viewer, event.key, event.shiftKey)) event.preventDefault();
  });
}

// Whether the element has its own use for the key.
function isKeyOf(element: HTMLElement, key: string): boolean {
  const moves = /^(Arrow|Page|Home|End)/.test(key);
  const control = element.closest("input, select, textarea, .scroll, [contenteditable]");
  if (!control) return false;
  if (control.matches("select, .scroll, input[type=range]")) return moves;
  return !control.matches("input[type=checkbox]");
}

// Whether the key means something here.
function press(viewer: Viewer, key: string, shift: boolean): boolean {
  const {state, report} = viewer;
  const pictures = groupsOf(report).find((group) => group.pictures.includes(state.a))?.pictures ?? [];
  const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[key];
  if (step && shift) {
    viewer.stepPointer(step[0] as number, step[1] as number);
    return true;
  }
  if (key === "ArrowLeft" || key === "ArrowRight") {
    const next = pictures.indexOf(state.a) + (key === "ArrowRight" ? 1 : -1);
    viewer.set({a: pictures[(next + pictures.length) % pictures.length] ?? state.a, swapped: false});
    return true;
  }
  if (/^[1-9]$/.test(key)) {
    const picture = pictures[Number(key) - 1];
    if (picture !== undefined) viewer.set({a: picture, swapped: false});
    return picture !== undefined;
  }
  const click = (id: string): void => byId(id).click();
  const actions: Record<string, () => void> = {
    "0": () => click("zoom-fit"),
    "+": () => viewer.set({exposure: Math.min(8, state.exposure + 0.5)}),
    "=": () => viewer.set({exposure: Math.min(8, state.exposure + 0.5)}),
    "-": () => viewer.set({exposure: Math.max(-8, state.exposure - 0.5)}),
    r: () => viewer.set({b: report.pictures[state.a]?.reference ?? state.b, view: "one", swapped: !state.swapped}),
    f: () => click("flicker"),
    s: () => click("view-split"),
    d: () => click("view-difference"),
    m: () => click("view-error"),
    e: () => click("seen"),
    z: () => click("zoom-in"),
    x: () => click("zoom-out"),
  };
  const action = actions[key.toLowerCase()];
  action?.();
  return action !== undefined;
}

const triple = (values: number[], digits: number): string[] => values.map((v) => number(v, digits));

// The values under the pointer, as a table.
export function showProbe(viewer: Viewer, probe: Probe | null): void {
  const box = byId("probe");
  if (!probe) {
    box.replaceChildren(
      h("p", {class: "note"}, "Point at a picture, or press Shift and an arrow key, to read its values."),
    );
    return;
  }
  const row = (name: string, cells: string[], swatch = ""): HTMLElement => {
    const line = h("tr", {}, h("th", {scope: "row"}, name), ...cells.map((text) => h("td", {}, text)));
    if (swatch) {
      const chip = h("span", {class: "chip"});
      chip.style.background = swatch;
      line.firstElementChild?.prepend(chip);
    }
    return line;
  };
  const body = probe.rows.map(({index, linear, encoded}) =>
    row(rivalName(viewer.report, index), [...triple(linear, 6), ...encoded.map(String)], `rgb(${encoded.join(" ")})`),
  );
  const [one, two] = probe.rows;
  if (one && two) {
    const difference = one.linear.map((v, i) => v - (two.linear[i] as number));
    const codes = one.encoded.map((v, i) => v - (two.encoded[i] as number));
    body.push(row("difference", [...triple(difference, 4), ...codes.map((v) => number(v))]));
  }
  box.replaceChildren(
    h("p", {}, `Pixel ${probe.x}, ${probe.y}`, Number.isNaN(probe.error) ? "" : ` · error ${number(probe.error)}`),
    h(
      "table",
      {class: "probe"},
      h(
        "thead",
        {},
        h(
          "tr",
          {},
          h("th", {}, ""),
          ...["R", "G", "B"].map((c) => h("th", {scope: "col"}, `${c} linear`)),
          ...["R", "G", "B"].map((c) => h("th", {scope: "col"}, `${c} sRGB 8-bit`)),
        ),
      ),
      h("tbody", {}, ...body),
    ),
  );
}
