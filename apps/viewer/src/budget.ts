// SPDX-License-Identifier: Apache-2.0
// The first question: what is the best for so much time?
import {isTime, unitOf, type Report} from "./data";
import {byId, h, number, seconds, select} from "./dom";
import {
  bestFor,
  firstChoice,
  firstMeasures,
  meanOf,
  pictureOf,
  pointsOf,
  valuesOf,
  type Choice,
  type Point,
} from "./statistics";

export interface Budget {
  value: number; // in the measure's unit; NaN where there is nothing to spend or to gain, and for what is no budget
  measure: string;
}
const kRoundBudget_s = 0.1;

const cost = (measure: string, value: number): string =>
  isTime(measure) ? seconds(value) : `${number(value, 3)} ${unitOf(measure) || measure}`;

export function buildBudget(
  report: Report,
  look: (picture: number, layout: string) => void,
  shown: () => number, // the picture that is looked at; -1: none
  changed: (budget: Budget) => void,
): Budget {
  const section = byId("budget");
  const {x, y} = firstMeasures(report);
  const choice = firstChoice(report);
  let points = x && y ? pointsOf(report, choice, x, y) : [];
  const budget: Budget = {value: NaN, measure: x};
  if (points.length < 2) {
    section.hidden = true;
    return budget;
  }
  const costs = points.map((point) => point.x).sort((a, b) => a - b);
  const least = costs[0] as number;
  const most = costs[costs.length - 1] as number;
  budget.value = isTime(x) && kRoundBudget_s >= least ? kRoundBudget_s : (costs[costs.length >> 1] as number);
  const scale = isTime(x) ? 1000 : 1;
  const higher = report.higherIsBetter.includes(y);

  const panelNames = report.layouts.map((layout) => layout.name);
  const panel = h("select", {id: "budget-layout", "aria-label": "Panel"});
  for (const name of panelNames)
    panel.append(
      h("option", {value: name, selected: name === (panelNames.includes("qd-oled") ? "qd-oled" : report.layout)}, name),
    );
  const entry = h("input", {
    id: "budget-value",
    type: "number",
    min: 0,
    step: "any",
    value: number(budget.value * scale, 3).replace("−", "-"),
  });
  const low = Math.log10(Math.min(least, budget.value)) - 0.05;
  const high = Math.log10(Math.max(most, budget.value)) + 0.05;
  const slide = h("input", {
    id: "budget-slider",
    type: "range",
    min: low,
    max: high,
    step: 0.005,
    value: Math.log10(budget.value),
    "aria-label": "Budget",
  });
  const answer = h("div", {id: "answer", "aria-live": "polite"});
  const places = h("div", {id: "answer-places"});

  const averaged = Object.entries(choice)
    .filter(([, value]) => value === "")
    .map(([axis]) => axis);
  // Where scores of several distances or panels are there, one is chosen.
  const fixed = Object.keys(choice).filter((axis) => choice[axis] !== "" && valuesOf(report, axis).length > 1);
  const chosen = fixed.map(
    (axis) =>
      select(
        `budget-${axis}`,
        axis,
        valuesOf(report, axis).map((v): [string, string] => [v, v]),
        choice[axis] ?? "",
        (value) => {
          choice[axis] = value;
          points = pointsOf(report, choice, x, y);
          update();
        },
      ).element,
  );

  const pictureNow = (point: Point): number => pictureOf(report, point.runs, shown());
  const buttons = (point: Point): HTMLElement[] =>
    point.picture < 0
      ? []
      : [
          h(
            "button",
            {type: "button", id: "look", class: "primary", click: () => look(pictureNow(point), "")},
            "Look at its picture",
          ),
          h(
            "span",
            {class: "joined"},
            h(
              "button",
              {type: "button", id: "look-panel", click: () => look(pictureNow(point), panel.value)},
              "See it on the panel",
            ),
            panel,
          ),
        ];
  const placeRows = (): HTMLElement | null => {
    const axis = averaged[0];
    if (!axis || valuesOf(report, axis).length < 2) return null;
    const rows = valuesOf(report, axis).map((value) => {
      const own: Choice = {...choice, [axis]: value};
      const best = bestFor(pointsOf(report, own, x, y), budget.value, higher);
      if (!best) return h("tr", {}, h("th", {scope: "row"}, value), h("td", {colspan: 3}, "none within it"));
      const name =
        best.picture < 0
          ? best.label
          : h("button", {type: "button", class: "link", click: () => look(best.picture, "")}, best.label);
      return h(
        "tr",
        {},
        h("th", {scope: "row"}, value),
        h("td", {}, name),
        h("td", {}, number(best.y, 3)),
        h("td", {}, cost(x, best.x)),
      );
    });
    return h(
      "table",
      {},
      h("thead", {}, h("tr", {}, ...[axis, "best", y, x].map((t) => h("th", {scope: "col"}, t)))),
      h("tbody", {}, ...rows),
    );
  };

  // Places of which nothing is within the budget, though the means over all are.
  const placesWithout = (): string[] => {
    const axis = averaged[0];
    if (!axis) return [];
    return valuesOf(report, axis).filter(
      (value) => !bestFor(pointsOf(report, {...choice, [axis]: value}, x, y), budget.value, higher),
    );
  };
  const scopeOf = (point: Point): string =>
    averaged.length && point.runs.length > 1
      ? ` (${meanOf(report, point.runs, [x, y])} over ` +
        `${averaged.map((axis) => `${valuesOf(report, axis).length} ${axis}s`).join(" and ")})`
      : "";

  const update = (): void => {
    const isBudget = budget.value > 0;
    entry.setAttribute("aria-invalid", String(!isBudget));
    if (!isBudget) {
      answer.replaceChildren(
        h("p", {class: "winner"}, "Nothing fits."),
        h("p", {}, `Enter a budget above 0, in ${isTime(x) ? "ms" : unitOf(x) || x}.`),
      );
      places.replaceChildren();
      changed(budget);
      return;
    }
    const without = placesWithout();
    const best = bestFor(points, budget.value, higher);
    const cheapest = [...points].sort((a, b) => a.x - b.x)[0] as Point;
    answer.replaceChildren(
      ...(best
        ? [
            h("p", {class: "winner"}, h("strong", {id: "winner"}, best.label)),
            h(
              "p",
              {},
              `${higher ? "Highest score" : "Least error"} of the ${points.length} compared: `,
              h("b", {}, `${y} ${number(best.y, 3)}`),
              ` in ${cost(x, best.x)}`,
              scopeOf(best),
              ".",
            ),
            ...(without.length
              ? [h("p", {}, `For ${without.join(", ")}, taken alone, nothing is within ${cost(x, budget.value)}.`)]
              : []),
            h("p", {class: "row"}, ...buttons(best)),
          ]
        : [
            h("p", {class: "winner"}, "Nothing is that cheap."),
            h("p", {}, `The cheapest is ${cheapest.label}, ${cost(x, cheapest.x)}.`),
          ]),
    );
    const rows = placeRows();
    places.replaceChildren(...(rows ? [rows] : []));
    changed(budget);
  };
  entry.addEventListener("input", () => {
    const isBudget = entry.valueAsNumber > 0;
    budget.value = isBudget ? entry.valueAsNumber / scale : NaN;
    if (isBudget) slide.value = String(Math.log10(budget.value));
    update();
  });
  slide.addEventListener("input", () => {
    budget.value = 10 ** Number(slide.value);
    entry.value = String(Number((budget.value * scale).toPrecision(3)));
    update();
  });
  section.append(
    h("h2", {}, "Best for a budget"),
    h(
      "div",
      {class: "budget-grid"},
      h(
        "div",
        {},
        h(
          "div",
          {class: "toolbar"},
          h(
            "label",
            {class: "field"},
            h("span", {}, `Budget, ${x}`),
            h("span", {class: "row"}, entry, isTime(x) ? "ms" : unitOf(x) || x),
          ),
          ...chosen,
        ),
        slide,
        answer,
      ),
      places,
    ),
  );
  update();
  return budget;
}
