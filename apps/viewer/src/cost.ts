// SPDX-License-Identifier: Apache-2.0
// The section of charts: which measures, of which scene, and what a point stands for.
import {isCost, isTime, type Report} from "./data";
import {byId, guarded, h, number, seconds, select} from "./dom";
import {drawBars, drawCost, stylesOf, swatch} from "./charts";
import type {Budget} from "./budget";
import {
  byValue,
  chosenAxes,
  firstChoice,
  firstMeasures,
  groupLines,
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

export function buildCost(report: Report, look: (picture: number) => void): CostSection {
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
    const all: [string, string][] = canAverage(axis) ? [["", `all (mean of ${values.length})`]] : [];
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
    byId("knob-title").hidden = true;
  }

  const cost = (value: number): string => (isTime(state.x) ? seconds(value) : number(value));
  const describe = (point: Point): string => {
    const run = report.runs[point.runs[0] ?? 0];
    const settings = ["strategy", "cells", "filter"].map((name) => run?.whole[name]).filter(Boolean);
    const half = point.high - point.y;
    return [
      point.label,
      `${state.y} ${number(point.y)}${half > 0 ? ` ± ${number(half, 2)}` : ""}`,
      `${state.x} ${cost(point.x)}`,
      ...(point.runs.length > 1 ? [`mean of ${point.runs.length}`] : []),
      ...(point.isBest ? ["on the Pareto front"] : []),
      ...settings.map(String),
    ].join("\n");
  };

  const widthOf = (box: HTMLElement): number => Math.max(320, box.clientWidth);
  const drawScatter = (): void => {
    if (!hasScatter) return;
    const box = byId("cost-chart");
    const points = pointsOf(report, choice, state.x, state.y);
    box.replaceChildren(
      points.length === 0
        ? h("p", {class: "note"}, "No run has both.")
        : drawCost({
            points,
            hidden,
            styles,
            x: state.x,
            y: state.y,
            budget: state.budgetMeasure === state.x ? state.budget : NaN,
            width: widthOf(box),
            describe,
            choose: (point) => point.picture >= 0 && look(point.picture),
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
    byId("knob-scope").textContent =
      `Geometric means over all else${others.length ? `, at ${others.join(", ")}` : ""}.`;
    box.replaceChildren(
      bars.length ? drawBars(bars, state.knobMeasure, widthOf(box)) : h("p", {class: "note"}, "No run has it."),
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
