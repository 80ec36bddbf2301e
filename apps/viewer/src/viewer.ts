// SPDX-License-Identifier: Apache-2.0
// The pictures: loads what is to be shown, draws it, says what lies under the pointer.
import {linearToSrgb} from "./codec";
import type {Report} from "./data";
import {guarded, number, showError} from "./dom";
import {see} from "./eye";
import {errorOf, kEmitterZoom, type Painter, type Shown} from "./frame";
import {makeCpuPainter} from "./paint_cpu";
import {makeGlPainter} from "./paint_gl";
import {makePanel, type Panel} from "./panel";
import {PictureStore, type Light, type Picture} from "./pictures";
import {groupsOf, picturesShown, pixelAt, place, rivalName, sizeOf, type Placed, type ViewState} from "./view_state";

export interface Probe {
  x: number;
  y: number;
  rows: {index: number; linear: number[]; encoded: number[]}[];
  error: number; // of the first two; NaN without a second
}

class Abandoned extends Error {}

export class Viewer {
  readonly state: ViewState;
  readonly store: PictureStore;
  readonly painter: Painter;
  status = "";
  onChange: () => void = () => undefined; // the state changed, or what is known of it
  onProbe: (probe: Probe | null) => void = () => undefined;
  private readonly panels = new Map<string, Panel>();
  private readonly seen = new Map<string, Light>(); // the last few
  private loaded = new Map<number, Picture>();
  private placed: Placed = {panes: [], width: 1, zoom: 1};
  private turn = 0;
  private pointer: {x: number; y: number} | null = null; // on the canvas, device pixels

  constructor(
    readonly report: Report,
    readonly canvas: HTMLCanvasElement,
    plain: boolean,
  ) {
    this.store = new PictureStore(report.pictures);
    const first = groupsOf(report)[0]?.pictures[0] ?? 0;
    const b = report.pictures[first]?.reference ?? -1;
    this.state = {
      a: first,
      b,
      pinned: [],
      view: b >= 0 ? "side" : "one",
      swapped: false,
      exposure: 0,
      gamma: 0,
      zoom: 0,
      x: 0,
      y: 0,
      split: 0.5,
      layout: "",
      isSeen: false,
      ppd: report.ppd || 40,
      errorMost: 0.1,
    };
    this.centre();
    this.painter = (plain ? null : makeGlPainter(canvas)) ?? makeCpuPainter(canvas);
    new ResizeObserver(() => this.draw()).observe(canvas);
    window.addEventListener("resize", () => this.draw()); // the theme's switch sends it, too
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  set(change: Partial<ViewState>): void {
    const before = this.state.a;
    Object.assign(this.state, change);
    const {a, b} = this.state;
    if (a !== before && change.b === undefined) {
      // Beside the reference of the new picture, if it was beside that of the old one.
      const reference = this.report.pictures[a]?.reference ?? -1;
      if (b === this.report.pictures[before]?.reference || this.report.pictures[b]?.isReference)
        this.state.b = reference;
      const size = this.size(a);
      const old = this.size(before);
      if (size.width !== old.width || size.height !== old.height) this.centre();
      if (this.report.pictures[before]?.reference !== reference) this.state.pinned = [];
    }
    this.onChange();
    this.refresh();
  }

  panelOf(name: string): Panel | null {
    const layout = this.report.layouts.find((one) => one.name === name);
    if (!layout) return null;
    let panel = this.panels.get(name);
    if (!panel) this.panels.set(name, (panel = makePanel(layout)));
    return panel;
  }

  size(index: number): {width: number; height: number} {
    const info = this.report.pictures[index];
    return info ? sizeOf(info) : {width: 1, height: 1};
  }

  centre(): void {
    const {width, height} = this.size(this.state.a);
    Object.assign(this.state, {zoom: 0, x: width / 2, y: height / 2});
  }

  get ratio(): number {
    return window.devicePixelRatio || 1;
  }
  // CSS pixels of a display pixel, as drawn.
  get zoom(): number {
    return this.placed.zoom / this.ratio;
  }
  get areEmittersShown(): boolean {
    const {state} = this;
    const isPicture = state.view !== "difference" && state.view !== "error";
    return state.layout !== "" && !state.isSeen && isPicture && this.zoom >= kEmitterZoom;
  }

  // Zooms about a point of the canvas (device pixels), its middle if none is given.
  zoomTo(zoom: number, x?: number, y?: number): void {
    const limited = Math.min(64, Math.max(1 / 16, zoom));
    const pane = this.placed.panes.find((p) => x !== undefined && x >= p.x && x < p.x + p.width);
    if (pane && x !== undefined && y !== undefined) {
      // The middle of a pane that the split has cut is still that of the whole one.
      const middle = this.state.view === "side" ? pane.x + pane.width / 2 : this.placed.width / 2;
      const px = (x - pane.left) / this.placed.zoom;
      const py = (y - pane.top) / this.placed.zoom;
      this.state.x = px - (x - middle) / (limited * this.ratio);
      this.state.y = py - (y - this.canvas.height / 2) / (limited * this.ratio);
    }
    this.state.zoom = limited;
    this.draw();
    this.onChange();
  }

  pan(dx: number, dy: number): void {
    const {width, height} = this.size(this.state.a);
    if (this.state.zoom === 0) this.state.zoom = this.zoom;
    this.state.x = Math.min(width, Math.max(0, this.state.x - dx / this.placed.zoom));
    this.state.y = Math.min(height, Math.max(0, this.state.y - dy / this.placed.zoom));
    this.draw();
  }

  // Loads what is missing, then draws.
  refresh = guarded(async () => {
    const turn = ++this.turn;
    // The other picture too, so that its values can be read and flickering need not wait.
    const wanted = [...new Set([...picturesShown(this.state), this.state.a, this.state.b])].filter((i) => i >= 0);
    this.say("loading …");
    if (!this.state.isSeen) {
      const previews = await Promise.all(wanted.map((i) => this.store.preview(i)));
      if (turn !== this.turn) return;
      if (previews.some((p) => p.note)) {
        this.loaded = new Map(previews.map((p) => [p.index, p]));
        this.draw();
        this.onChange();
        await new Promise((resolve) => setTimeout(resolve, 50)); // so that it is painted
      }
    }
    const pictures = await Promise.all(wanted.map((i) => this.store.get(i)));
    if (turn !== this.turn) return;
    this.loaded = new Map(pictures.map((p) => [p.index, p]));
    if (this.state.isSeen)
      try {
        for (const picture of pictures) await this.look(picture, turn);
      } catch (error) {
        if (error instanceof Abandoned) return;
        throw error;
      }
    const notes = pictures.map((p) => p.note).filter(Boolean);
    this.say(notes.join("; "));
    this.draw();
    this.onChange();
  });

  private say(text: string): void {
    this.status = text;
    this.canvas.setAttribute("aria-busy", String(text === "loading …" || text.startsWith("computing")));
    this.onChange();
  }

  private seenKey(index: number): string {
    return `${index} ${this.state.layout} ${this.state.ppd}`;
  }

  private async look(picture: Picture, turn: number): Promise<void> {
    const key = this.seenKey(picture.index);
    if (this.seen.has(key)) return;
    this.say("computing what the eye sees …");
    let last = performance.now();
    const pause = async (): Promise<void> => {
      if (performance.now() - last < 40) return;
      await new Promise((resolve) => setTimeout(resolve));
      if (turn !== this.turn) throw new Abandoned();
      last = performance.now();
    };
    const isLight = picture.cells !== picture.pixels; // a render's cells are light, no drives
    const panel = isLight ? null : this.panelOf(this.state.layout);
    const light = await see(picture.cells, panel, this.report.vision, this.state.ppd, pause);
    this.seen.set(key, light);
    const oldest = this.seen.keys().next().value;
    if (this.seen.size > 12 && oldest !== undefined) this.seen.delete(oldest);
  }

  // The light of a picture whose values are read and compared: a value for each display pixel.
  private lightOf(index: number): Light | null {
    if (this.state.isSeen) return this.seen.get(this.seenKey(index)) ?? null;
    return this.loaded.get(index)?.pixels ?? null;
  }

  private shown(index: number): Shown | null {
    const light = this.lightOf(index);
    if (!light) return null;
    const panel = this.panelOf(this.state.layout);
    if (!this.areEmittersShown || !panel) return {light, asPanel: false, gain: 1};
    const picture = this.loaded.get(index) as Picture;
    const isLight = picture.cells !== picture.pixels;
    return {light: picture.cells, asPanel: !isLight, gain: 1 / panel.brightest};
  }

  draw(): void {
    const {canvas, state} = this;
    const width = Math.max(1, Math.round(canvas.clientWidth * this.ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * this.ratio));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
    const indices = picturesShown(state).filter((i) => i >= 0);
    const placing = (): Placed =>
      place(
        state,
        indices.map((i) => this.shown(i)),
        this.size(state.a),
        {width, height},
        this.ratio,
      );
    this.placed = placing();
    this.placed = placing(); // whether emitters are shown depends on the zoom
    const dark = getComputedStyle(canvas).getPropertyValue("--canvas").trim() || "#202020";
    const background = [1, 3, 5].map((i) => parseInt(dark.slice(i, i + 2), 16) / 255) as [number, number, number];
    try {
      this.painter.draw({
        panes: this.placed.panes,
        zoom: this.placed.zoom,
        exposure: state.exposure,
        gamma: state.gamma,
        errorMost: state.errorMost,
        panel: this.panelOf(state.layout),
        background,
      });
    } catch (error) {
      showError(error);
    }
    this.probe();
  }

  pointTo(x: number, y: number): void {
    this.pointer = {x, y};
    this.probe();
  }

  // Moves what is probed by whole display pixels.
  stepPointer(dx: number, dy: number): void {
    const pane = this.placed.panes[0];
    if (!pane) return;
    const at = this.pointer ?? {x: pane.x + pane.width / 2, y: pane.height / 2};
    this.pointTo(at.x + dx * this.placed.zoom, at.y + dy * this.placed.zoom);
  }

  private probe(): void {
    const at = this.pointer && pixelAt(this.placed, this.pointer.x, this.pointer.y);
    const size = this.size(this.state.a);
    if (!at || at.x < 0 || at.y < 0 || at.x >= size.width || at.y >= size.height) return this.onProbe(null);
    const {a, b} = this.state;
    const indices = [...new Set([a, b, ...picturesShown(this.state)])].filter((i) => i >= 0);
    const rows = indices.flatMap((index) => {
      const light = this.lightOf(index);
      if (!light || at.x >= light.width || at.y >= light.height) return [];
      const linear = [...light.rgb.subarray(3 * (at.y * light.width + at.x)).subarray(0, 3)];
      const encoded = linear.map((v) => Math.round(255 * linearToSrgb(Math.min(1, Math.max(0, v)))));
      return [{index, linear, encoded}];
    });
    const [one, two] = rows;
    const error = one && two && rows.length > 1 ? errorOf(one.linear, two.linear) : NaN;
    this.onProbe({x: at.x, y: at.y, rows, error});
  }

  // What each pane holds, and where it begins, in CSS pixels.
  labels(): {left: number; width: number; name: string}[] {
    const indices = picturesShown(this.state).filter((i) => i >= 0 && this.lightOf(i));
    const {panes} = this.placed;
    const sign = this.state.view === "error" ? " beside " : " − ";
    return panes.map((pane, i) => ({
      left: pane.x / this.ratio,
      width: pane.width / this.ratio,
      name: pane.b
        ? indices.map((k) => rivalName(this.report, k)).join(sign)
        : rivalName(this.report, indices[i] ?? -1),
    }));
  }

  describe(): string {
    const names = picturesShown(this.state)
      .map((i) => this.report.pictures[i]?.name ?? "")
      .filter(Boolean);
    const what = {one: "Picture", side: "Side by side", split: "Split", difference: "Difference", error: "Error map"};
    return `${what[this.state.view]}: ${names.join(" and ")}, at ${number(this.zoom * 100, 3)}%`;
  }
}
