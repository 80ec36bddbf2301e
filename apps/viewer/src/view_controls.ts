// SPDX-License-Identifier: Apache-2.0
// Buttons, sliders and the strip of pictures around the view.
import {byId, h, number, select} from "./dom";
import {kEmitterZoom, kMagma} from "./frame";
import {distanceCm, groupsOf, picturesShown, rivalName, type View} from "./view_state";
import type {Viewer} from "./viewer";

const kViews: [View, string, string][] = [
  ["one", "One", "One picture at a time"],
  ["side", "Side by side", "Reference, picture and what is pinned beside each other"],
  ["split", "Split", "The reference left of the handle, the picture right of it"],
  ["difference", "Difference", "Picture minus the other, grey where they agree"],
  ["error", "Error map", "Mean absolute difference of the channels, in colours"],
];

interface Slider {
  element: HTMLElement;
  set(value: number, text: string): void;
}
function slider(
  id: string,
  label: string,
  range: {min: number; max: number; step: number},
  input: (value: number) => void,
): Slider {
  const box = h("input", {id, type: "range", ...range, input: () => input(Number(box.value))});
  const output = h("output", {for: id});
  return {
    element: h("label", {class: "field slider"}, h("span", {}, label), box, output),
    set: (value, text) => {
      if (document.activeElement !== box || Math.abs(Number(box.value) - value) > range.step) box.value = String(value);
      output.textContent = text;
      box.setAttribute("aria-valuetext", text);
    },
  };
}

function button(id: string, text: string, title: string, click: () => void): HTMLButtonElement {
  return h("button", {id, type: "button", title, click}, text);
}

// Fills the section's bars; what it returns brings them up to date.
export function buildControls(viewer: Viewer): () => void {
  const {report, state} = viewer;
  const groups = groupsOf(report);
  const groupOf = (index: number): number =>
    Math.max(
      0,
      groups.findIndex((g) => g.pictures.includes(index)),
    );

  const group = select(
    "group",
    "Scene",
    groups.map((g, i) => [String(i), g.name]),
    String(groupOf(state.a)),
    (value) => {
      const next = groups[Number(value)]?.pictures ?? [];
      const name = rivalName(report, state.a);
      viewer.set({a: next.find((i) => rivalName(report, i) === name) ?? next[0] ?? state.a});
    },
  );
  const beside = select("beside", "Beside", [], "", (value) => viewer.set({b: Number(value), swapped: false}));
  const views = h("div", {class: "segments", role: "group", "aria-label": "View"});
  for (const [view, text, title] of kViews) {
    const one = button(`view-${view}`, text, title, () => viewer.set({view, swapped: false}));
    one.dataset["view"] = view;
    views.append(one);
  }
  const flicker = button("flicker", "Flicker", "The two pictures in turns, twice a second (F)", () => toggleFlicker());
  let timer = 0;
  const toggleFlicker = (): void => {
    if (timer) {
      clearInterval(timer);
      timer = 0;
    } else {
      viewer.set({view: "one", swapped: false});
      timer = window.setInterval(() => viewer.set({view: "one", swapped: !state.swapped}), 500);
    }
    flicker.setAttribute("aria-pressed", String(timer !== 0));
  };
  const pin = button("pin", "Pin", "Keeps this picture side by side with the next ones", () => {
    const pinned = state.pinned.includes(state.a)
      ? state.pinned.filter((i) => i !== state.a)
      : [...state.pinned, state.a].slice(-3);
    viewer.set({pinned, view: "side"});
  });
  const zooms = h(
    "div",
    {class: "segments", role: "group", "aria-label": "Zoom"},
    button("zoom-out", "−", "Smaller", () => viewer.zoomTo(viewer.zoom / 2)),
    h("output", {id: "zoom"}),
    button("zoom-in", "+", "Larger", () => viewer.zoomTo(viewer.zoom * 2)),
    button("zoom-fit", "Fit", "The whole picture (0)", () => {
      viewer.centre();
      viewer.set({});
    }),
    button("zoom-100", "1:1", "A pixel for a pixel", () => viewer.zoomTo(1)),
    button("zoom-800", "8:1", "Eight times", () => viewer.zoomTo(8)),
  );
  group.element.hidden = groups.length < 2;
  byId("view-bar").replaceChildren(group.element, beside.element, views, flicker, pin, zooms);

  const exposure = slider("exposure", "Exposure", {min: -8, max: 8, step: 0.25}, (value) =>
    viewer.set({exposure: value}),
  );
  const gamma = select(
    "gamma",
    "Curve",
    [
      ["0", "sRGB"],
      ["1", "γ 1.0"],
      ["1.8", "γ 1.8"],
      ["2.2", "γ 2.2"],
      ["2.4", "γ 2.4"],
    ],
    "0",
    (value) => viewer.set({gamma: Number(value)}),
  );
  const scale = slider("error-scale", "Error scale", {min: -4, max: 2, step: 0.25}, (value) =>
    viewer.set({errorMost: 10 ** value}),
  );
  const layout = select(
    "layout",
    "As the panel shows it",
    [["", "plain pixels"], ...report.layouts.map((l): [string, string] => [l.name, l.name])],
    state.layout,
    (value) => viewer.set({layout: value}),
  );
  const seen = h("input", {id: "seen", type: "checkbox", change: () => viewer.set({isSeen: seen.checked})});
  const ppd = slider("ppd", "Distance", {min: 1, max: 2.3, step: 0.01}, (value) =>
    viewer.set({ppd: Math.round(10 ** value)}),
  );
  byId("light-bar").replaceChildren(
    exposure.element,
    gamma.element,
    scale.element,
    layout.element,
    h("label", {class: "field check"}, seen, h("span", {}, "As an eye sees it")),
    ppd.element,
  );

  const strip = byId("strip");
  strip.addEventListener("click", (event) => {
    const one = (event.target as HTMLElement).closest<HTMLElement>("[data-picture]");
    if (one) viewer.set({a: Number(one.dataset["picture"]), swapped: false});
  });

  let shownGroup = -1;
  const fillStrip = (): void => {
    const index = groupOf(state.a);
    const pictures = groups[index]?.pictures ?? [];
    if (index !== shownGroup) {
      shownGroup = index;
      group.box.value = String(index);
      strip.replaceChildren(
        ...pictures.map((picture, i) =>
          h(
            "button",
            {type: "button", "data-picture": picture, title: report.pictures[picture]?.file ?? ""},
            h("kbd", {}, i < 9 ? String(i + 1) : "·"),
            rivalName(report, picture),
          ),
        ),
      );
    }
    const reference = report.pictures[state.a]?.reference ?? -1;
    const others = [...(reference >= 0 ? [reference] : []), ...pictures];
    beside.box.replaceChildren(
      ...others.map((i) => h("option", {value: i, selected: i === state.b}, rivalName(report, i))),
    );
    for (const one of strip.querySelectorAll<HTMLElement>("[data-picture]")) {
      const picture = Number(one.dataset["picture"]);
      one.setAttribute("aria-pressed", String(picture === state.a));
      one.classList.toggle("pinned", state.pinned.includes(picture));
    }
  };

  const fillLegend = (): void => {
    const legend = byId("legend");
    const isMap = state.view === "error";
    const isDifference = state.view === "difference";
    legend.hidden = !isMap && !isDifference;
    if (legend.hidden) return;
    const stops = isMap
      ? Array.from({length: 17}, (_, i) => [...kMagma.subarray(4 * Math.round(i * 15.9375)).subarray(0, 3)])
      : [
          [0, 0, 0],
          [255, 255, 255],
        ];
    const bar = h("span", {
      class: "bar",
      role: "img",
      "aria-label": isMap ? "Colours of the error, from dark to light" : "Greys of the difference",
    });
    bar.style.background = `linear-gradient(90deg, ${stops.map((s) => `rgb(${s.join(" ")})`).join(", ")})`;
    const most = number(state.errorMost, 3);
    legend.replaceChildren(
      h("span", {}, isMap ? "0" : `−${most}`),
      bar,
      h("span", {}, most),
      h(
        "span",
        {class: "note"},
        isMap ? "mean |difference| of R, G, B, linear light" : "picture − other, linear light",
      ),
    );
  };

  const fillNotes = (): void => {
    const notes: string[] = [];
    const panel = viewer.panelOf(state.layout);
    if (viewer.status) notes.push(viewer.status);
    if (panel && viewer.areEmittersShown && panel.brightest > 1)
      notes.push(
        `Emitters of ${panel.layout.name} (${panel.layout.summary}); light divided by ${number(panel.brightest, 3)}, ` +
          `the brightest that an emitter gets: raise the exposure to undo it.`,
      );
    else if (panel && !state.isSeen && (state.view === "difference" || state.view === "error"))
      notes.push("Differences are of the pictures' pixels, without the panel's emitters.");
    else if (panel && !state.isSeen)
      notes.push(
        `Zoom in to ${kEmitterZoom * 100}% or more to see the emitters of ${panel.layout.name}: ` +
          `${panel.layout.summary}.`,
      );
    if (viewer.areEmittersShown) {
      const wide = picturesShown(state).find((i) => report.pictures[i]?.cells.some((n) => n > 1));
      if (wide !== undefined)
        notes.push(
          `The ${rivalName(report, wide)} has ${report.pictures[wide]?.cells.join("x")} values for a pixel: it is ` +
            `light already, so it is shown as plain pixels, without emitters.`,
        );
    }
    if (state.isSeen) {
      const on = panel ? `on a panel with the layout ${panel.layout.name}` : "on a panel without subpixels";
      notes.push(
        `What an eye sees ${on}, ${number(state.ppd)} pixels per degree away ` +
          `(${number(distanceCm(state.ppd), 3)} cm from a screen of 96 dpi).`,
      );
    }
    if ((state.layout || state.isSeen) && report.ppd)
      notes.push(
        `The scores of this report belong to ${number(report.ppd)} pixels per degree` +
          `${report.layout ? ` on ${report.layout}` : ""}, whatever is chosen here.`,
      );
    byId("view-notes").textContent = notes.join(" ");
  };

  const fillLabels = (): void => {
    byId("labels").replaceChildren(
      ...viewer
        .labels()
        .filter((label) => label.width > 40)
        .map((label) => {
          const text = h("span", {}, label.name);
          Object.assign(text.style, {left: `${label.left + 6}px`, maxWidth: `${label.width - 12}px`});
          return text;
        }),
    );
  };

  return () => {
    fillLabels();
    fillStrip();
    fillLegend();
    fillNotes();
    for (const one of views.children)
      one.setAttribute("aria-pressed", String((one as HTMLElement).dataset["view"] === state.view));
    if (timer && state.view !== "one") toggleFlicker();
    pin.setAttribute("aria-pressed", String(state.pinned.includes(state.a)));
    exposure.set(state.exposure, `${state.exposure < 0 ? "−" : "+"}${Math.abs(state.exposure)} EV`);
    gamma.box.value = String(state.gamma);
    scale.set(Math.log10(state.errorMost), number(state.errorMost, 3));
    layout.box.value = state.layout;
    seen.checked = state.isSeen;
    ppd.set(Math.log10(state.ppd), `${number(state.ppd, 3)} ppd`);
    byId("zoom").textContent = `${number(viewer.zoom * 100, 3)}%`;
    byId("caption").textContent = viewer.describe();
    viewer.canvas.setAttribute("aria-label", viewer.describe());
    const handle = byId("handle");
    handle.hidden = state.view !== "split";
    handle.style.left = `${state.split * 100}%`;
    handle.setAttribute("aria-valuenow", String(Math.round(state.split * 100)));
  };
}
