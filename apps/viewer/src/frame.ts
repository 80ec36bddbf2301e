// SPDX-License-Identifier: Apache-2.0
// What a view shows, before either way of drawing it.
import {interpolateMagma, rgb as parseColour} from "d3";
import type {Panel} from "./panel";
import type {Light} from "./pictures";

export interface Shown {
  light: Light;
  asPanel: boolean; // drives, to be drawn as emitters
  gain: number; // of light
}
export type Mode = "picture" | "difference" | "error";
export interface Pane {
  mode: Mode;
  a: Shown;
  b: Shown | null; // what is subtracted
  // Part of the canvas, and where in it the picture's upper left corner lies; device pixels.
  x: number;
  y: number;
  width: number;
  height: number;
  left: number;
  top: number;
}
export interface Frame {
  panes: Pane[];
  zoom: number; // device pixels of a display pixel
  exposure: number; // stops
  gamma: number; // 0: the sRGB curve
  errorMost: number; // the end of the error's colour scale
  panel: Panel | null;
  background: [number, number, number]; // 0..1, encoded
}
export interface Painter {
  readonly name: string;
  draw(frame: Frame): void;
}

// Emitters are drawn from this zoom on.
export const kEmitterZoom = 3;

export function makeMagma(size: number): Uint8Array {
  const table = new Uint8Array(4 * size);
  for (let i = 0; i < size; ++i) {
    const colour = parseColour(interpolateMagma(i / (size - 1)));
    table.set([colour.r, colour.g, colour.b, 255], 4 * i);
  }
  return table;
}
export const kMagma = makeMagma(256);

// The mean of |a - b| over the channels.
export function errorOf(a: ArrayLike<number>, b: ArrayLike<number>): number {
  let sum = 0;
  for (let c = 0; c < 3; ++c) sum += Math.abs((a[c] as number) - (b[c] as number));
  return sum / 3;
}

// Samples a side that a device pixel takes where the picture is made smaller.
export const samplesOf = (zoom: number): number => (zoom >= 1 ? 1 : Math.min(8, Math.ceil(1 / zoom)));
