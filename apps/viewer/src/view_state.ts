// SPDX-License-Identifier: Apache-2.0
// What is looked at, and how it lies on the canvas. Pure functions.
import type {PictureInfo, Report} from "./data";
import type {Mode, Pane, Shown} from "./frame";
import {rivalAxis} from "./statistics";

export type View = "one" | "side" | "split" | "difference" | "error";
export interface ViewState {
  a: number; // the picture chosen
  b: number; // what it is beside, the reference as a rule
  pinned: number[]; // more, side by side
  view: View;
  swapped: boolean; // b in a's place, to flicker
  exposure: number;
  gamma: number;
  zoom: number; // CSS pixels of a display pixel; 0: as large as fits
  x: number; // the picture's point in the middle of a pane, display pixels
  y: number;
  split: number; // the handle's place, 0..1
  layout: string; // "": no emitters
  isSeen: boolean; // as an eye sees it
  ppd: number;
  errorMost: number;
}

export const sizeOf = (info: PictureInfo): {width: number; height: number} => ({
  width: Math.floor(info.width / info.cells[0]),
  height: Math.floor(info.height / info.cells[1]),
});

// Pictures that are rivals of each other: the same scene, and the same on all axes but that of the rivals.
export interface Group {
  name: string;
  pictures: number[];
}
export function groupsOf(report: Report): Group[] {
  const rivals = rivalAxis(report);
  const groups = new Map<string, number[]>();
  report.pictures.forEach((picture, index) => {
    if (picture.isReference) return;
    const name =
      report.axes
        .filter((axis) => axis !== rivals)
        .map((axis) => picture.settings[axis] ?? "")
        .join(" · ") || "all";
    groups.set(name, [...(groups.get(name) ?? []), index]);
  });
  return [...groups].map(([name, pictures]) => ({name, pictures}));
}

export function rivalName(report: Report, index: number): string {
  const picture = report.pictures[index];
  if (!picture) return "";
  return picture.isReference ? "reference" : picture.settings[rivalAxis(report)] || picture.name;
}

// How many panes lie side by side, and which pictures are in them.
export function picturesShown(state: ViewState): number[] {
  const {a, b} = state;
  if (state.view === "one") return [state.swapped ? b : a];
  if (state.view === "side") return [...new Set([b, a, ...state.pinned])].filter((i) => i >= 0);
  if (state.view === "split") return [b, a];
  return [a, b];
}

export interface Placed {
  panes: Pane[];
  width: number; // of one pane, device pixels
  zoom: number; // device pixels
}

const kGap = 2; // device pixels between panes

// `shown[i]` is picturesShown(state)[i]. width, height: the canvas, device pixels; ratio: of those to CSS pixels.
export function place(
  state: ViewState,
  shown: (Shown | null)[],
  size: {width: number; height: number},
  canvas: {width: number; height: number},
  ratio: number,
): Placed {
  const there = shown.filter((one): one is Shown => one !== null);
  const count = state.view === "side" ? Math.max(1, there.length) : 1;
  const width = Math.floor((canvas.width - kGap * (count - 1)) / count);
  const fit = Math.min(width / size.width, canvas.height / size.height);
  const zoom = state.zoom > 0 ? state.zoom * ratio : fit;
  const pane = (mode: Mode, a: Shown, b: Shown | null, index: number): Pane => {
    const x = index * (width + kGap);
    // Whole device pixels, so that picture pixels of a whole zoom have sharp edges.
    const left = Math.round(x + width / 2 - state.x * zoom);
    const top = Math.round(canvas.height / 2 - state.y * zoom);
    return {mode, a, b, x, y: 0, width, height: canvas.height, left, top};
  };
  const panes: Pane[] = [];
  const [first, second] = there;
  if (state.view === "difference" || state.view === "error") {
    if (first && second) panes.push(pane(state.view === "error" ? "error" : "difference", first, second, 0));
  } else if (state.view === "split" && first && second) {
    const at = Math.round(state.split * width);
    panes.push({...pane("picture", first, null, 0), width: at});
    panes.push({...pane("picture", second, null, 0), x: at, width: width - at});
  } else {
    there.forEach((one, index) => panes.push(pane("picture", one, null, index)));
  }
  return {panes, width, zoom};
}

// The display pixel under a device pixel of the canvas.
export function pixelAt(placed: Placed, x: number, y: number): {x: number; y: number} | null {
  const pane = placed.panes.find((p) => x >= p.x && x < p.x + p.width);
  return pane ? {x: Math.floor((x - pane.left) / placed.zoom), y: Math.floor((y - pane.top) / placed.zoom)} : null;
}

// The middle of a 96 dpi screen's pixels seen at this many a degree lies as far as this.
export const distanceCm = (ppd: number): number => (ppd * 2.54) / 96 / (2 * Math.tan(Math.PI / 360));
