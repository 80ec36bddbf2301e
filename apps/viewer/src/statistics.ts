// SPDX-License-Identifier: Apache-2.0
// What a study's runs say: lines, means over scenes, Pareto fronts, slopes, the best for a budget. Pure functions.
import {canAverage, isCost, type Report, type Run} from "./data";

// One setting at one place of the chart; over several scenes a geometric mean.
export interface Point {
  label: string; // what tells it from the other points
  line: string;
  x: number;
  y: number;
  low: number; // of y
  high: number;
  runs: number[];
  picture: number; // of the first run
  isBest: boolean;
}
export interface Line {
  name: string;
  points: Point[]; // by x
  slope: number; // of log y over log x, least squares; NaN for a single point
}
// Chosen values by axis; "" is the mean over all.
export type Choice = Record<string, string>;

const present = (v: number | null | undefined): v is number => typeof v === "number" && Number.isFinite(v);

// The axis whose values are rivals.
export function rivalAxis(report: Report): string {
  for (const name of ["method", "filter", "strategy", "effects", "picture"])
    if (report.axes.includes(name) && (name !== "picture" || report.kind === "comparison")) return name;
  return report.axes[report.axes.length - 1] ?? "";
}

export function valuesOf(report: Report, axis: string): string[] {
  return [...new Set(report.runs.map((run) => run.settings[axis] ?? ""))];
}

// Axes that neither are rivals nor lie along a line: one of their values, or the mean, is looked at.
export function chosenAxes(report: Report): string[] {
  const rivals = rivalAxis(report);
  return report.axes.filter((axis) => axis !== rivals && !report.along.includes(axis));
}

export function firstChoice(report: Report): Choice {
  const choice: Choice = {};
  for (const axis of chosenAxes(report)) choice[axis] = canAverage(axis) ? "" : (valuesOf(report, axis)[0] ?? "");
  return choice;
}

// Parameters that buy accuracy: settings that differ in these alone are one line.
const kPrices = /^(spp|n|depth|over|frames|iterations|least|taps|threshold|precision)$/;

function withoutPrices(text: string): string {
  return text
    .split(" ")
    .map((stage) => {
      const colon = stage.indexOf(":");
      if (colon < 0) return stage;
      const kept = stage
        .slice(colon + 1)
        .split(",")
        .filter((parameter) => !kPrices.test(parameter.split("=")[0] ?? ""));
      return stage.slice(0, colon) + (kept.length ? ":" + kept.join(",") : "");
    })
    .join(" ");
}

// The line that each value of the rival axis belongs to.
export function linesOf(report: Report): Map<string, string> {
  const rivals = rivalAxis(report);
  const keys = new Map<string, string[]>(); // what they share -> labels
  for (const run of report.runs) {
    const label = run.settings[rivals] ?? "";
    const work = ["strategy", "filter", "cells"].map((name) => withoutPrices(run.whole[name] ?? "")).join("|");
    const key = report.along.length || work === "||" ? label : work;
    const labels = keys.get(key) ?? [];
    if (!labels.includes(label)) labels.push(label);
    keys.set(key, labels);
  }
  const lines = new Map<string, string>();
  for (const labels of keys.values()) {
    const first = labels[0] ?? "";
    const name = labels.length === 1 ? first : commonName(labels);
    for (const label of labels) if (!lines.has(label)) lines.set(label, name);
  }
  return lines;
}

function commonName(labels: string[]): string {
  let common = labels[0] ?? "";
  for (const label of labels) while (!label.startsWith(common)) common = common.slice(0, -1);
  common = common.replace(/[\s,:=]*[\w-]*=?$|[\s,:=\d.]+$/, (tail) => (/^[\s,:=\d.]*$|=$/.test(tail) ? "" : tail));
  return common.length >= 2 ? common : labels.join(" / ");
}

function geometricMean(values: number[]): number {
  return values.some((v) => v <= 0)
    ? values.reduce((a, b) => a + b, 0) / values.length
    : Math.exp(values.reduce((a, b) => a + Math.log(b), 0) / values.length);
}

// What geometricMean() makes of these runs' measures.
export function meanOf(report: Report, runs: number[], measures: string[]): string {
  const isPositive = runs.every((i) => measures.every((name) => (report.runs[i]?.shown[name] ?? 0) > 0));
  return isPositive ? "geometric mean" : "mean";
}

// The picture of one of these runs: of the scene that picture `shown` is of, if there is one. -1: they have none.
export function pictureOf(report: Report, runs: number[], shown: number): number {
  const now = report.pictures[shown]?.settings;
  const axes = report.axes.filter((axis) => axis !== rivalAxis(report) && !report.along.includes(axis));
  const pictures = runs.map((i) => report.runs[i]?.picture ?? -1).filter((picture) => picture >= 0);
  const same = pictures.find((picture) => {
    const settings = report.pictures[picture]?.settings;
    return now && settings && axes.every((axis) => now[axis] === settings[axis]);
  });
  return same ?? pictures[0] ?? -1;
}

// A run's setting with what its {places} stand for; "" if one of them stands for nothing.
export function filledSetting(run: Run, name: string): string {
  let text = run.whole[name] ?? "";
  for (let depth = 0; depth < 4 && text.includes("{"); ++depth)
    text = text.replace(/\{([\w-]+)\}/g, (place, key: string) => run.whole[key] ?? place);
  return text.includes("{") ? "" : text;
}

// The points of a chart: one for each combination of the axes that are not averaged over. Left out: runs without both
// measures, and settings that lack a scene that others have, as their mean would be of other scenes.
export function pointsOf(report: Report, choice: Choice, xName: string, yName: string): Point[] {
  const lines = linesOf(report);
  const rivals = rivalAxis(report);
  const groups = new Map<string, number[]>();
  report.runs.forEach((run, index) => {
    if (!Object.entries(choice).every(([axis, value]) => value === "" || run.settings[axis] === value)) return;
    if (!present(run.shown[xName]) || !present(run.shown[yName])) return;
    const key = [rivals, ...report.along].map((axis) => run.settings[axis] ?? "").join(" · ");
    groups.set(key, [...(groups.get(key) ?? []), index]);
  });
  const most = Math.max(0, ...[...groups.values()].map((runs) => runs.length));
  const points: Point[] = [];
  for (const [label, indices] of groups) {
    if (indices.length < most) continue;
    const runs = indices.map((i) => report.runs[i] as Run);
    const y = geometricMean(runs.map((run) => run.shown[yName] as number));
    // Relative half widths of independent means: their squares add up.
    const share =
      Math.sqrt(runs.reduce((sum, run) => sum + ((run.around[yName] ?? 0) / (run.shown[yName] || 1)) ** 2, 0)) /
      runs.length;
    points.push({
      label,
      line: lines.get(runs[0]?.settings[rivals] ?? "") ?? label,
      x: geometricMean(runs.map((run) => run.shown[xName] as number)),
      y,
      low: y * Math.max(1 - share, 0.02),
      high: y * (1 + share),
      runs: indices,
      picture: runs.find((run) => run.picture >= 0)?.picture ?? -1,
      isBest: false,
    });
  }
  const higher = report.higherIsBetter.includes(yName);
  for (const point of points) point.isBest = isParetoOptimal(point, points, higher);
  return points;
}

// Whether none is as good in both and better in one. Equal ones do not beat each other.
export function isParetoOptimal(point: Point, all: Point[], higher: boolean): boolean {
  const sign = higher ? -1 : 1;
  return !all.some(
    (other) =>
      other.x <= point.x && sign * other.y <= sign * point.y && (other.x < point.x || sign * other.y < sign * point.y),
  );
}

export function frontOf(points: Point[]): Point[] {
  return points.filter((point) => point.isBest).sort((a, b) => a.x - b.x);
}

export function groupLines(points: Point[]): Line[] {
  const names = [...new Set(points.map((point) => point.line))];
  return names.map((name) => {
    const own = points.filter((point) => point.line === name).sort((a, b) => a.x - b.x);
    return {name, points: own, slope: slopeOf(own)};
  });
}

export function slopeOf(points: {x: number; y: number}[]): number {
  const logs = points.filter((p) => p.x > 0 && p.y > 0).map((p) => [Math.log(p.x), Math.log(p.y)] as const);
  const mx = logs.reduce((s, p) => s + p[0], 0) / logs.length;
  const my = logs.reduce((s, p) => s + p[1], 0) / logs.length;
  const xx = logs.reduce((s, p) => s + (p[0] - mx) ** 2, 0);
  return logs.length > 1 && xx > 1e-12 ? logs.reduce((s, p) => s + (p[0] - mx) * (p[1] - my), 0) / xx : NaN;
}

// The least error among what costs no more than the budget; the cheaper of equals.
export function bestFor(points: Point[], budget: number, higher: boolean): Point | undefined {
  const sign = higher ? -1 : 1;
  return points.filter((point) => point.x <= budget).sort((a, b) => sign * (a.y - b.y) || a.x - b.x)[0];
}

// The measures that charts begin with: what the plan's Pareto front is of, else the first cost and error there are.
export function firstMeasures(report: Report): {x: string; y: string} {
  const has = (name: string): boolean => report.runs.some((run) => present(run.shown[name]));
  const named = [...report.pareto.measures, ...report.plain, ...report.measures].filter(has);
  return {x: named.find(isCost) ?? "", y: named.find((name) => !isCost(name)) ?? ""};
}

// What a knob costs: the geometric mean of a measure for each of an axis's values, over all else that is chosen.
export function byValue(
  report: Report,
  choice: Choice,
  axis: string,
  measure: string,
): {value: string; mean: number; runs: number}[] {
  return valuesOf(report, axis)
    .map((value) => {
      const numbers = report.runs
        .filter((run) =>
          Object.entries({...choice, [axis]: value}).every(([a, v]) => v === "" || run.settings[a] === v),
        )
        .map((run) => run.shown[measure])
        .filter(present);
      return {value, mean: numbers.length ? geometricMean(numbers) : NaN, runs: numbers.length};
    })
    .filter((bar) => Number.isFinite(bar.mean));
}
