// SPDX-License-Identifier: Apache-2.0
// What accuracy costs, drawn: error over cost, knobs, histograms and spectra.
import * as Plot from "@observablehq/plot";
import {symbol, symbolsFill} from "d3";
import {withUnit} from "./data";
import {h, number} from "./dom";
import type {Bin, Spectrum} from "./analysis";
import {frontOf, groupLines, type Point} from "./statistics";

// Nine hues that people with any colour vision tell apart, with 3:1 against both backgrounds; with seven shapes, 63.
const kHues = ["#2b7bc4", "#d6130a", "#13a085", "#ba8b09", "#e400c1", "#8d6058", "#9581ff", "#ff5382", "#9d1bf9"];
const kShapes = ["circle", "square", "triangle", "diamond", "cross", "star", "wye"];

export interface Style {
  colour: string;
  shape: string;
}
export function stylesOf(names: string[]): Map<string, Style> {
  return new Map(
    names.map((name, i) => [
      name,
      {
        colour: kHues[i % kHues.length] as string,
        shape: kShapes[i % kShapes.length] as string,
      },
    ]),
  );
}

const shapeOrder = ["circle", "cross", "diamond", "square", "star", "triangle", "wye"];
export function swatch(style: Style): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "-8 -8 16 16");
  svg.setAttribute("class", "swatch");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  const type = symbolsFill[shapeOrder.indexOf(style.shape)] ?? symbolsFill[0];
  path.setAttribute("d", symbol(type as NonNullable<typeof type>, 70)() ?? "");
  path.setAttribute("fill", style.colour);
  svg.append(path);
  return svg;
}

const common = (width: number): Plot.PlotOptions => ({
  width,
  height: Math.max(260, Math.min(460, width * 0.52)),
  marginLeft: 62,
  marginBottom: 44,
  marginTop: 24,
  style: {background: "transparent", fontSize: "12px", overflow: "visible"},
  grid: true,
});
const axis = (label: string, log: boolean): Plot.ScaleOptions => ({
  label,
  ...(log ? {type: "log", tickFormat: (v: number) => number(v, 2)} : {}),
  nice: true,
});

export interface CostChart {
  points: Point[];
  hidden: Set<string>; // lines
  styles: Map<string, Style>;
  x: string;
  y: string;
  budget: number; // NaN: no line
  width: number;
  describe(point: Point): string; // lines of text
  choose(point: Point): void;
  show(point: Point | null): void;
}

const kTipWidth = 56; // characters

// The text with its long lines broken after commas and spaces.
export function broken(text: string): string {
  return text
    .split("\n")
    .map((line) => {
      let length = 0;
      return (line.match(/[^, ]*[, ]*/g) ?? [])
        .map((word) => {
          const breaks = length > 0 && length + word.trimEnd().length > kTipWidth;
          length = (breaks ? 2 : length) + word.length;
          return breaks ? `\n  ${word}` : word;
        })
        .join("");
    })
    .join("\n");
}

export function drawCost(chart: CostChart): HTMLElement | SVGElement {
  const points = chart.points.filter((point) => !chart.hidden.has(point.line));
  const areLogs = points.every((p) => p.x > 0 && p.y > 0);
  const lines = groupLines(points);
  const hue = (name: string): string => chart.styles.get(name)?.colour ?? "gray";
  const front = frontOf(points);
  const many = lines.filter((line) => line.points.length > 1);
  const marks: Plot.Markish[] = [
    ...many.map((line) =>
      Plot.areaY(line.points, {
        x: "x",
        y1: "low",
        y2: "high",
        fill: hue(line.name),
        fillOpacity: 0.18,
        className: "band",
      }),
    ),
    ...many.map((line) => Plot.lineY(line.points, {x: "x", y: "y", stroke: hue(line.name), strokeWidth: 1.75})),
    Plot.ruleX(points, {x: "x", y1: "low", y2: "high", stroke: (p: Point) => hue(p.line), strokeOpacity: 0.7}),
    Plot.lineY(front, {
      x: "x",
      y: "y",
      stroke: "currentColor",
      strokeDasharray: "5 4",
      strokeWidth: 1.25,
      curve: "step-after",
      className: "front",
    }),
    Plot.dot(front, {x: "x", y: "y", r: 8, stroke: "currentColor", strokeWidth: 1.25, className: "front-points"}),
    Plot.dot(points, {
      x: "x",
      y: "y",
      r: 4.5,
      fill: (p: Point) => hue(p.line),
      className: "points",
      symbol: (p: Point) => chart.styles.get(p.line)?.shape ?? "circle",
      ariaLabel: (p: Point) => chart.describe(p).replaceAll("\n", ", "),
    }),
    Plot.tip(
      points,
      Plot.pointer({
        x: "x",
        y: "y",
        title: (p: Point) => broken(chart.describe(p)),
        maxRadius: 30,
        lineWidth: Infinity,
      }),
    ),
  ];
  if (Number.isFinite(chart.budget) && chart.budget > 0)
    marks.unshift(
      Plot.ruleX([chart.budget], {
        stroke: "currentColor",
        strokeOpacity: 0.55,
        strokeWidth: 2,
        className: "budget-line",
      }),
    );
  const figure = Plot.plot({
    ...common(chart.width),
    x: axis(withUnit(chart.x), areLogs),
    y: axis(`↑ ${withUnit(chart.y)}`, areLogs),
    symbol: {type: "identity"},
    marks,
    ariaLabel: `${chart.y} over ${chart.x}, one line for each of ${lines.map((l) => l.name).join(", ")}`,
  });
  // A click is for the point's picture: it does not pin the tip.
  figure.addEventListener("pointerdown", (event) => event.stopImmediatePropagation(), {capture: true});
  figure.addEventListener("click", (event) => {
    const element = (event.target as Element).closest(".points > *");
    const index = (element as unknown as {__data__: number} | null)?.__data__;
    const point = index === undefined ? (figure as {value?: Point | null}).value : points[index];
    if (point) chart.choose(point);
  });
  figure.addEventListener("input", () => chart.show((figure as {value?: Point | null}).value ?? null));
  // Points can be reached and chosen by keyboard, too.
  for (const element of figure.querySelectorAll<SVGElement>(".points > *")) {
    const point = points[(element as unknown as {__data__: number}).__data__];
    if (!point) continue;
    element.setAttribute("tabindex", "0");
    element.setAttribute("role", "button");
    element.addEventListener("focus", () => chart.show(point));
    element.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      chart.choose(point);
    });
  }
  return figure;
}

export function drawBars(
  bars: {value: string; mean: number}[],
  measure: string,
  width: number,
): HTMLElement | SVGElement {
  const longest = Math.max(...bars.map((bar) => bar.value.length));
  const marginLeft = Math.min(width * 0.55, 12 + 6.6 * longest);
  const shorten = (text: string): string => {
    const room = Math.floor((marginLeft - 12) / 6.2);
    return text.length > room ? text.slice(0, room - 1) + "…" : text;
  };
  return Plot.plot({
    ...common(width),
    height: 56 + 22 * bars.length,
    marginLeft,
    grid: false,
    x: {label: withUnit(measure), grid: true, nice: true, domain: [0, Math.max(...bars.map((bar) => bar.mean), 1e-12)]},
    y: {label: null, domain: bars.map((bar) => bar.value), tickFormat: shorten},
    marks: [
      Plot.barX(bars, {x: "mean", y: "value", fill: kHues[0] as string, title: "value", className: "bars"}),
      Plot.text(bars, {
        x: "mean",
        y: "value",
        text: (bar: {mean: number}) => number(bar.mean, 3),
        textAnchor: "start",
        dx: 4,
      }),
    ],
    marginRight: 60,
    ariaLabel: `${measure} by value`,
  });
}

export interface Named<T> {
  name: string;
  values: T[];
  style: Style;
}
const legendOf = (all: Named<unknown>[]): HTMLElement =>
  h("p", {class: "key"}, ...all.map((one) => h("span", {}, swatch(one.style), one.name)));

export function drawHistogram(all: Named<Bin>[], width: number): HTMLElement {
  const flat = all.flatMap((one) => one.values.map((bin) => ({...bin, colour: one.style.colour, name: one.name})));
  return h(
    "div",
    {},
    legendOf(all),
    Plot.plot({
      ...common(width),
      height: 240,
      x: axis("|error of luminance|, linear light (at most 1e−5: in the first)", true),
      y: {label: "↑ pixels (%)", percent: true},
      marks: [
        Plot.rectY(flat, {
          x1: "from",
          x2: "to",
          y: "share",
          fill: "colour",
          fillOpacity: 0.45,
          stroke: "colour",
          mixBlendMode: "normal",
          className: "histogram",
        }),
        Plot.ruleY([0]),
      ],
      color: {type: "identity"},
      ariaLabel: "Histogram of errors",
    }),
  );
}

export function drawSpectra(all: Named<Spectrum>[], width: number): HTMLElement {
  const flat = all.flatMap((one) =>
    one.values.filter((s) => s.power > 0).map((s) => ({...s, colour: one.style.colour, name: one.name})),
  );
  return h(
    "div",
    {},
    legendOf(all),
    Plot.plot({
      ...common(width),
      height: 240,
      x: {...axis("frequency (cycles/pixel)", true), nice: false},
      y: axis("↑ noise power", true),
      marks: [
        Plot.lineY(flat, {
          x: "frequency",
          y: "power",
          z: "name",
          stroke: "colour",
          strokeWidth: 1.75,
          className: "spectrum",
        }),
      ],
      color: {type: "identity"},
      ariaLabel: "Power spectrum of the error",
    }),
  );
}
