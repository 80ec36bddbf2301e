// SPDX-License-Identifier: Apache-2.0
// The section of charts: which measures, of which scene, and what a point stands for.
import {isCost, isTime, type Report} from "./data";
import {byId, guarded, h, number, seconds, select} from "./dom";
import {drawBars, drawCost, stylesOf, swatch} from "./charts";
import type {Budget} from "./budget";
import {
  byValue,
  chosenAxes,
  filledSetting,
  firstChoice,
  firstMeasures,
  groupLines,
  meanOf,
  pictureOf,
  pointsOf,
  rivalAxis,
  valuesOf,
  type Point,
} from "./statistics";
import {canAverage} from "./data";

export interface CostSection {
  setBudget(budget: Budget): void;
  draw(): void;
}

// `shown`: the picture that is looked at; -1: none.
export function buildCost(report: Report, look: (picture: number) => void, shown: () => number): CostSection {
  const choice = firstChoice(report);
  const {x: firstX, y: firstY} = firstMeasures(report);
  const state = {
    x: firstX,
    y: firstY,
    budget: NaN,
    budgetMeasure: "",
    knob: rivalAxis(report),
    knobMeasure: firstX || firstY,
  };
  const hidden = new Set<string>();
  const has = report.measures.filter((name) => report.runs.some((run) => typeof run.shown[name] === "number"));
  const costs = has.filter(isCost);
  const rest = has.filter((name) => !isCost(name));
  const styles = stylesOf([
    ...new Set(firstX && firstY ? pointsOf(report, {}, firstX, firstY).map((p) => p.line) : []),
  ]);
  const draw = guarded((): void => {
    drawScatter();
    drawKnob();
  });
  const options = (names: string[]): [string, string][] => names.map((name) => [name, name]);

  const bar = byId("cost-bar");
  for (const axis of chosenAxes(report)) {
    const values = valuesOf(report, axis);
    if (values.length < 2) continue;
    const all: [string, string][] = canAverage(axis) ? [["", `all (geometric mean of ${values.length})`]] : [];
    bar.append(
      select(`choose-${axis}`, axis, [...all, ...options(values)], choice[axis] ?? "", (value) => {
        choice[axis] = value;
        draw();
      }).element,
    );
  }
  const hasScatter = costs.length > 0 && rest.length > 0;
  if (hasScatter)
    bar.append(
      select("measure-y", "Error", options(rest), state.y, (value) => {
        state.y = value;
        draw();
      }).element,
      select("measure-x", "Cost", options(costs), state.x, (value) => {
        state.x = value;
        draw();
      }).element,
    );
  byId("cost-chart-box").hidden = !hasScatter;
  if (report.kind === "comparison") {
    byId("cost-title").textContent = "Scores";
    byId("cost-link").textContent = "Scores";
    byId("knob-title").hidden = true;
  }

  const cost = (value: number): string => (isTime(state.x) ? seconds(value) : number(value));
  const describe = (point: Point): string => {
    const run = report.runs[point.runs[0] ?? 0];
    const settings = run ? ["strategy", "cells", "filter"].map((name) => filledSetting(run, name)).filter(Boolean) : [];
    const half = point.high - point.y;
    return [
      point.label,
      `${state.y} ${number(point.y)}${half > 0 ? ` ± ${number(half, 2)}` : ""}`,
      `${state.x} ${cost(point.x)}`,
      ...(point.runs.length > 1 ? [`${meanOf(report, point.runs, [state.x, state.y])} of ${point.runs.length}`] : []),
      ...(point.isBest ? ["on the Pareto front"] : []),
      ...settings,
    ].join("\n");
  };

  const widthOf = (box: HTMLElement): number => Math.max(320, box.clientWidth);
  const drawScatter = (): void => {
    if (!hasScatter) return;
    const box = byId("cost-chart");
    const points = pointsOf(report, choice, state.x, state.y);
    const zeros = [state.y, state.x].filter((_, i) => points.every((p) => (i ? p.x : p.y) === 0));
    byId("point").textContent = kHint;
    byId("point").hidden = points.length === 0 || zeros.length > 0;
    box.replaceChildren(
      points.length === 0
        ? h("p", {class: "note"}, "No run has both.")
        : zeros.length > 0
          ? h("p", {class: "note"}, `${zeros.join(" and ")}: all zero.`)
          : drawCost({
              points,
              hidden,
              styles,
              x: state.x,
              y: state.y,
              budget: state.budgetMeasure === state.x ? state.budget : NaN,
              width: widthOf(box),
              describe,
              choose: (point) => look(pictureOf(report, point.runs, shown())),
              show: (point) => (byId("point").textContent = point ? describe(point).split("\n").join(" · ") : kHint),
            }),
    );
    byId("cost-legend").replaceChildren(
      ...groupLines(points).map((line) => {
        const style = styles.get(line.name);
        const isHidden = hidden.has(line.name);
        const item = h(
          "button",
          {
            type: "button",
            class: "legend-line",
            "aria-pressed": String(!isHidden),
            title: "Show or hide",
            click: () => {
              if (isHidden) hidden.delete(line.name);
              else hidden.add(line.name);
              draw();
            },
          },
          h("span", {}, line.name),
        );
        if (style) item.prepend(swatch(style));
        if (Number.isFinite(line.slope))
          item.append(
            h("span", {class: "slope", title: "slope of the line in logarithms"}, `slope ${number(line.slope, 2)}`),
          );
        return item;
      }),
    );
  };
  const kHint = byId("point").textContent ?? "";

  const knobs = report.axes.filter((axis) => valuesOf(report, axis).length > 1);
  if (!knobs.includes(state.knob)) state.knob = knobs[0] ?? "";
  byId("knobs").hidden = knobs.length === 0 || has.length === 0;
  byId("knob-bar").append(
    select("knob", "By", options(knobs), state.knob, (value) => {
      state.knob = value;
      draw();
    }).element,
    select("knob-measure", "Measure", options(has), state.knobMeasure, (value) => {
      state.knobMeasure = value;
      draw();
    }).element,
  );
  const drawKnob = (): void => {
    const box = byId("knob-chart");
    if (!state.knob) return;
    const bars = byValue(report, choice, state.knob, state.knobMeasure);
    const others = Object.entries(choice)
      .filter(([axis, value]) => axis !== state.knob && value)
      .map(([a, v]) => `${a} ${v}`);
    const where = others.length ? `at ${others.join(", ")}` : "";
    const isMean = bars.some((bar) => bar.runs > 1);
    byId("knob-scope").textContent = isMean
      ? `Geometric means over all else${where ? `, ${where}` : ""}.`
      : where && `${where[0]?.toUpperCase()}${where.slice(1)}.`;
    const say = (text: string): HTMLElement => h("p", {class: "note"}, text);
    box.replaceChildren(
      bars.length === 0
        ? say("No run has it.")
        : bars.every((bar) => bar.mean === 0)
          ? say(`${state.knobMeasure}: all zero.`)
          : drawBars(bars, state.knobMeasure, widthOf(box)),
    );
  };
  return {
    draw,
    setBudget: (budget) => {
      Object.assign(state, {budget: budget.value, budgetMeasure: budget.measure});
      draw();
    },
  };
}
