// SPDX-License-Identifier: Apache-2.0
// What a report holds, as the program writes it (apps/triad/report_page.cpp).

export interface Emitter {
  name: string;
  primary: [number, number, number];
  pixel: [number, number];
  channel: number; // 0 red, 1 green, 2 blue, 3 the white that the panel derives
  cells: [number, number, number][]; // x, y, share
}
export interface Layout {
  name: string;
  summary: string;
  cells: [number, number];
  tile: [number, number];
  derivesWhite: boolean;
  emitters: Emitter[];
}
// Opponent channels of an eye and the two Gaussians of each: weight and spread, exp(-(r / spread)^2), in degrees.
export interface Vision {
  toOpponent: number[];
  toRgb: number[];
  gaussians: [number, number][][];
}
export type Format = "u8" | "f16" | "f32";
export interface PictureInfo {
  name: string;
  file: string;
  isReference: boolean;
  reference: number; // the picture that it is judged by, -1: none
  width: number; // as stored, in cells
  height: number;
  cells: [number, number]; // of a display pixel
  format: Format; // of what the page holds
  side: string; // a script beside the page that holds the float data; "": the page has it all
  sideFormat: Format;
  settings: Record<string, string>;
}
export type Measures = Record<string, number | null>;
export interface Run {
  settings: Record<string, string>;
  whole: Record<string, string>;
  shown: Measures;
  around: Measures; // half a confidence interval or a quartile range, see aroundIs
  values: Record<string, (number | null)[]>;
  pareto: boolean | null;
  picture: number;
}
export interface Report {
  kind: "study" | "comparison";
  title: string;
  facts: [string, string][];
  axes: string[];
  measures: string[]; // all, those that the plan names first
  plain: string[]; // what the plan names
  higherIsBetter: string[];
  pareto: {measures: string[]; within: string[]};
  along: string[]; // axes of the same work at several prices
  aroundIs: string;
  layout: string;
  ppd: number;
  runs: Run[];
  pictures: PictureInfo[];
  layouts: Layout[];
  vision: Vision;
}

export function readReport(): Report {
  const text = document.getElementById("triad-report")?.textContent;
  if (!text) throw new Error("the report's data is missing from this page");
  return JSON.parse(text) as Report;
}

export const isTime = (measure: string): boolean => measure.endsWith("seconds");
const isCount = (measure: string): boolean =>
  measure === "samples" || measure === "spp" || measure.endsWith("rays") || measure === "iterations";
export const isCost = (measure: string): boolean => isTime(measure) || isCount(measure);
export const unitOf = (measure: string): string =>
  isTime(measure) ? "s" : measure === "spp" ? "samples/pixel" : measure.endsWith("psnr") ? "dB" : "";
export const withUnit = (measure: string): string => {
  const unit = unitOf(measure);
  return unit ? `${measure} (${unit})` : measure;
};
// Axes whose values are places to look at, over which a mean says something. Scores of different distances do not mix.
export const canAverage = (axis: string): boolean => ["source", "scene", "picture"].includes(axis);
