// SPDX-License-Identifier: Apache-2.0
// The viewer's pure functions against closed forms and hand-made cases.
import assert from "node:assert/strict";
import fs from "node:fs";
import {createRequire} from "node:module";
import os from "node:os";
import path from "node:path";
import test from "node:test";
import {pathToFileURL} from "node:url";
import zlib from "node:zlib";

const source = process.env.TRIAD_VIEWER_SOURCE;
const fromPage = createRequire(path.join(process.env.TRIAD_PAGE, "package.json"));
const esbuild = createRequire(fromPage.resolve("vite/package.json"))("esbuild");
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "triad-viewer-"));
test.after(() => fs.rmSync(folder, {recursive: true}));

async function load(name) {
  const outfile = path.join(folder, `${name}.mjs`);
  esbuild.buildSync({
    entryPoints: [path.join(source, "src", `${name}.ts`)],
    bundle: true,
    format: "esm",
    outfile,
    nodePaths: [path.join(process.env.TRIAD_PAGE, "node_modules")],
  });
  return import(pathToFileURL(outfile));
}
const near = (value, expected, tolerance) =>
  assert.ok(Math.abs(value - expected) <= tolerance, `${value} is not ${expected} within ${tolerance}`);

const point = (x, y, line = "a") => ({
  label: `${line}${x}`,
  line,
  x,
  y,
  low: y,
  high: y,
  runs: [0],
  picture: -1,
  isBest: false,
});

test("Pareto fronts, budgets and slopes", async () => {
  const s = await load("statistics");
  const points = [point(1, 10), point(2, 5), point(2, 5, "tie"), point(3, 6), point(4, 1), point(5, 1), point(2, 7)];
  for (const p of points) p.isBest = s.isParetoOptimal(p, points, false);
  assert.deepEqual(
    points.map((p) => p.isBest),
    [true, true, true, false, true, false, false],
  );
  assert.deepEqual(
    s.frontOf(points).map((p) => p.label),
    ["a1", "a2", "tie2", "a4"],
  );
  assert.equal(s.isParetoOptimal(point(3, 11), points, true), true, "where more is better");
  assert.equal(s.bestFor(points, 3.5, false).x, 2);
  assert.equal(s.bestFor(points, 10, false).x, 4, "the cheaper of equals");
  assert.equal(s.bestFor(points, 0.5, false), undefined);
  near(s.slopeOf([1, 4, 16, 64].map((x) => ({x, y: 3 * x ** -1.5}))), -1.5, 1e-12);
  assert.ok(Number.isNaN(s.slopeOf([{x: 1, y: 1}])));
});

const report = (runs, more = {}) => ({
  kind: "study",
  axes: ["source", "method"],
  along: [],
  measures: ["seconds", "rmse"],
  plain: [],
  higherIsBetter: [],
  pareto: {measures: ["seconds", "rmse"], within: ["source"]},
  pictures: [],
  ...more,
  runs: runs.map(([source, method, seconds, rmse, strategy]) => ({
    settings: {source, method},
    whole: {strategy},
    shown: {seconds, rmse},
    around: {rmse: 0.1 * rmse},
    values: {},
    pareto: null,
    picture: -1,
  })),
});

test("means over scenes are geometric, and of what all scenes have", async () => {
  const s = await load("statistics");
  const data = report([
    ["one", "grid 2", 1, 4, "grid:n=2"],
    ["two", "grid 2", 4, 1, "grid:n=2"],
    ["one", "grid 4", 2, 2, "grid:n=4"],
    ["two", "grid 4", 2, 8, "grid:n=4"],
    ["one", "lost", 1, 1, "random"],
    ["two", "lost", 1, null, "random"],
  ]);
  const points = s.pointsOf(data, {source: ""}, "seconds", "rmse");
  assert.deepEqual(
    points.map((p) => p.label),
    ["grid 2", "grid 4"],
  );
  near(points[0].x, 2, 1e-12);
  near(points[0].y, 2, 1e-12);
  near(points[1].y, 4, 1e-12);
  near(points[0].high / points[0].y - 1, 0.1 / Math.SQRT2, 1e-12); // of two independent values
  assert.deepEqual([...new Set(points.map((p) => p.line))], ["grid"], "one line for one strategy at two prices");
  assert.equal(s.pointsOf(data, {source: "one"}, "seconds", "rmse").length, 3);
});

test("a mean is named for what it is", async () => {
  const s = await load("statistics");
  const data = report([
    ["one", "a", 1, 4, ""],
    ["two", "a", 4, 1, ""],
    ["three", "a", 2, 0, ""],
  ]);
  assert.equal(s.meanOf(data, [0, 1], ["seconds", "rmse"]), "geometric mean");
  assert.equal(s.meanOf(data, [0, 1, 2], ["seconds"]), "geometric mean");
  assert.equal(s.meanOf(data, [0, 1, 2], ["seconds", "rmse"]), "mean", "a zero has no logarithm");
});

test("a mean's picture is of the scene that is shown", async () => {
  const s = await load("statistics");
  const data = report([
    ["one", "a", 1, 1, ""],
    ["one", "b", 1, 1, ""],
    ["two", "a", 1, 1, ""],
    ["two", "b", 1, 1, ""],
  ]);
  data.pictures = data.runs.map((run) => ({settings: run.settings}));
  data.runs.forEach((run, i) => (run.picture = i));
  assert.equal(s.pictureOf(data, [1, 3], 2), 3);
  assert.equal(s.pictureOf(data, [1, 3], 0), 1);
  assert.equal(s.pictureOf(data, [0], 3), 0, "another, where that scene has none");
  assert.equal(s.pictureOf(data, [1, 3], -1), 1);
  data.runs[1].picture = -1;
  assert.equal(s.pictureOf(data, [1], 0), -1);
});

test("settings are told with their values in place", async () => {
  const s = await load("statistics");
  const whole = {strategy: "grid:spp={frames},x={half}", filter: "f:ppd={ppd}", frames: "15", half: "{frames}"};
  assert.equal(s.filledSetting({whole}, "strategy"), "grid:spp=15,x=15");
  assert.equal(s.filledSetting({whole}, "filter"), "", "left out, as nothing says what ppd is");
  assert.equal(s.filledSetting({whole}, "cells"), "");
  assert.equal(s.filledSetting({whole: {a: "{b}", b: "{a}"}}, "a"), "", "and a circle has no end");
});

test("settings that differ in more than their price are several lines", async () => {
  const s = await load("statistics");
  const lines = s.linesOf(
    report([
      ["one", "plain", 1, 1, "quad:spp=4"],
      ["one", "shared", 1, 1, "quad:spp=4,noise=shared"],
      ["one", "sobol-owen 4", 1, 1, "sobol-owen:spp=4"],
      ["one", "sobol-owen 16", 1, 1, "sobol-owen:spp=16"],
    ]),
  );
  assert.deepEqual([...lines.values()], ["plain", "shared", "sobol-owen", "sobol-owen"]);
});

test("halves, floats and codes are unpacked", async () => {
  const c = await load("codec");
  for (const [bits, value] of [
    [0x3c00, 1],
    [0xc000, -2],
    [0x7bff, 65504],
    [1, 2 ** -24],
    [0x3555, 0.333251953125],
    [0x7c00, Infinity],
  ])
    assert.equal(c.fromHalf(bits), value);
  const values = [0.1, -3e-30, 65504, 1, 2, 1e30].map(Math.fround);
  const planes = [];
  for (let channel = 0; channel < 3; ++channel)
    for (let k = 3; k >= 0; --k) {
      const bytes = [0, 1].map((i) => Buffer.from(new Float32Array([values[3 * i + channel]]).buffer)[k]);
      planes.push(bytes[0], (bytes[1] - bytes[0]) & 255);
    }
  const bytes = await c.inflate(new Uint8Array(zlib.deflateSync(Buffer.from(planes))));
  assert.deepEqual([...c.unpack(bytes, "f32", 2)], values);
  const codes = c.unpack(Uint8Array.from([255, 0, 128]), "u8", 1);
  near(codes[0], 1, 1e-7);
  near(codes[2], 0.2158605, 1e-7); // IEC 61966-2-1, code 128
  assert.throws(() => c.unpack(bytes, "f16", 2));
  near(c.linearToSrgb(c.srgbToLinear(0.3)), 0.3, 1e-12);
});

test("a line's blur has the transfer of a Gaussian", async () => {
  const e = await load("eye");
  for (const sigma of [0.5, 0.9, 2.9, 3.1, 8, 40])
    for (const share of [0.02, 0.1, 0.3]) {
      const n = 4096; // whole periods of a cosine that is its own mirror image
      const k = Math.round((share * n) / sigma);
      const line = Float64Array.from({length: n}, (_, i) => Math.cos((Math.PI * k * (i + 0.5)) / n));
      const before = line.slice();
      e.lineBlur(sigma)(line);
      const gain = line.reduce((sum, v, i) => sum + v * before[i], 0) / before.reduce((sum, v) => sum + v * v, 0);
      const f = k / (2 * n);
      near(gain, Math.exp(-2 * (Math.PI * sigma * f) ** 2), sigma < 1 ? 5e-3 : 1e-3);
    }
  const flat = new Float64Array(50).fill(0.7);
  e.lineBlur(20)(flat);
  for (const v of flat) near(v, 0.7, 1e-6);
  assert.deepEqual(
    [-3, -2, -1, 0, 1, 2, 3, 4, 5, 6].map((i) => e.mirrored(i, 3)),
    [2, 1, 0, 0, 1, 2, 2, 1, 0, 0],
  );
});

test("emitters that reach into the next tile are driven by their own pixel", async () => {
  const p = await load("panel");
  const panel = p.makePanel({
    name: "",
    summary: "",
    cells: [2, 1],
    tile: [1, 1],
    derivesWhite: false,
    emitters: [
      {
        name: "",
        primary: [1, 0, 0],
        pixel: [0, 0],
        channel: 0,
        cells: [
          [1, 0, 0.5],
          [2, 0, 0.5],
        ],
      },
      {name: "", primary: [0, 1, 0], pixel: [0, 0], channel: 1, cells: [[1, 0, 1]]},
    ],
  });
  const drive = (x, _y, c) => (c === 0 ? 10 * x + 1 : 100);
  const out = [0, 0, 0];
  p.cellLight(panel, 2, 0, drive, out);
  assert.deepEqual(out, [1, 0, 0], "pixel 1's left cell has the red of pixel 0");
  p.cellLight(panel, 3, 0, drive, out);
  assert.deepEqual(out, [11, 200, 0]);
  assert.equal(panel.brightest, 2);
  const white = p.makePanel({
    name: "",
    summary: "",
    cells: [2, 1],
    tile: [1, 1],
    derivesWhite: true,
    emitters: [
      {name: "", primary: [1, 0, 0], pixel: [0, 0], channel: 0, cells: [[0, 0, 1]]},
      {name: "", primary: [1, 1, 1], pixel: [0, 0], channel: 3, cells: [[1, 0, 1]]},
    ],
  });
  p.cellLight(white, 0, 0, (_x, _y, c) => [0.75, 0.5, 0.25][c], out);
  assert.deepEqual(out, [1, 0, 0]); // (.75 - .25) times two cells
  p.cellLight(white, 1, 0, (_x, _y, c) => [0.75, 0.5, 0.25][c], out);
  assert.deepEqual(out, [0.5, 0.5, 0.5]);
});

test("white noise has its variance at every frequency, a histogram all pixels", async () => {
  const a = await load("analysis");
  const width = 256;
  let state = 1;
  const uniform = () => (state = (state * 48271) % 2147483647) / 2147483647;
  const plane = Float64Array.from({length: width * width}, () => uniform() - 0.5);
  const spectrum = a.noiseSpectrum(plane, width, width);
  assert.equal(spectrum.length, 63);
  for (const [from, to] of [
    [4, 20],
    [20, 40],
    [40, 63],
  ]) {
    const band = spectrum.slice(from, to);
    near(band.reduce((sum, s) => sum + s.power, 0) / band.length, 1 / 12, 0.004);
  }
  const wave = Float64Array.from({length: width * width}, (_, i) => Math.cos((2 * Math.PI * (i % width)) / 8));
  const peak = a.noiseSpectrum(wave, width, width).reduce((best, s) => (s.power > best.power ? s : best));
  near(peak.frequency, 1 / 8, 1e-12);
  const bins = a.errorHistogram(Float64Array.from([0, 1e-9, 0.0015, -0.0015, 50]));
  near(
    bins.reduce((sum, bin) => sum + bin.share, 0),
    1,
    1e-12,
  );
  near(bins.find((bin) => bin.from < 0.0015 && bin.to > 0.0015).share, 0.4, 1e-12);
});

test("tables sort numbers as numbers, CSV is RFC 4180", async () => {
  const t = await load("table");
  const keys = [10, NaN, 9, -1];
  assert.deepEqual(
    [...keys].sort((a, b) => t.compareKeys(a, b, 1)),
    [-1, 9, 10, NaN],
  );
  assert.deepEqual(
    [...keys].sort((a, b) => t.compareKeys(a, b, -1)),
    [10, 9, -1, NaN],
  );
  const lines = t.toCsv(report([['a"b', "c,d", 1.5, null, ""]])).split("\r\n");
  assert.equal(lines[0], "source,method,seconds,seconds ±,rmse,rmse ±,pareto,file");
  assert.equal(lines[1], '"a""b","c,d",1.5,,,0,,');
});

test("text and controls have the contrast of WCAG AA in both themes", () => {
  const css = fs.readFileSync(path.join(source, "src/style.css"), "utf8");
  const blocks = [...css.matchAll(/--ground: [^}]*/g)].map((match) =>
    Object.fromEntries([...match[0].matchAll(/--([\w-]+): (#[0-9a-f]{6})/g)].map(([, name, colour]) => [name, colour])),
  );
  assert.equal(blocks.length, 3);
  assert.deepEqual(blocks[1], blocks[2], "the system's dark is the chosen dark");
  const luminance = (colour) =>
    [1, 3, 5]
      .map((i) => parseInt(colour.slice(i, i + 2), 16) / 255)
      .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
      .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const contrast = (a, b) => {
    const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y);
    return (light + 0.05) / (dark + 0.05);
  };
  const charts = fs
    .readFileSync(path.join(source, "src/charts.ts"), "utf8")
    .match(/kHues = \[(.*)\]/)[1]
    .match(/#\w{6}/g);
  assert.equal(new Set(charts).size, 9);
  for (const theme of blocks) {
    for (const [front, back] of [
      ["text", "card"],
      ["text", "ground"],
      ["quiet", "card"],
      ["accent", "card"],
      ["on-accent", "accent"],
      ["text", "chosen"],
      ["accent", "chosen"],
      ["bad", "bad-ground"],
    ])
      assert.ok(
        contrast(theme[front], theme[back]) >= 4.5,
        `${front} on ${back}: ${contrast(theme[front], theme[back])}`,
      );
    for (const hue of charts)
      assert.ok(contrast(hue, theme.card) >= 3, `${hue} on ${theme.card}: ${contrast(hue, theme.card)}`);
  }
});
