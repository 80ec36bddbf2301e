// SPDX-License-Identifier: Apache-2.0
// A study's folder made by hand: two scenes, four methods, pictures of which every value is known.
import fs from "node:fs";
import path from "node:path";
import {writeExr} from "./exr.mjs";

export const kEvil = `</script><script>window.hacked = 1</script><!-- "q" 'a' & Ünï µ 💡`;
export const kMethods = ["cheap", "good", "slow", kEvil];
export const kSources = ["first", `<img src=x onerror="window.hacked = 2">`];
export const kWidth = 48;
export const kHeight = 32;

// seconds, rmse and whether nothing beats it, by source and method.
export const kResults = [
  [
    [0.02, 0.5, true],
    [0.08, 0.1, true],
    [0.5, 0.05, true],
    [0.09, 0.3, false],
  ],
  [
    [0.03, 0.4, true],
    [0.09, 0.1, true],
    [0.6, 0.15, false],
    [0.08, 0.2, true],
  ],
];

// The reference has three cells a pixel, whose mean is `truth`.
export const truth = (x, y) => [0.2 + x / 128, 0.3 + y / 128, ((x * 7 + y * 13) % 31) / 62].map(Math.fround);
const cell = (x, y) => truth(Math.floor(x / 3), y).map((v) => v + [-0.0625, 0, 0.0625][x % 3]);
export const pictures = {
  cheap: (x, y) => (x === 5 && y === 4 ? [3.5, 0.25, 7] : [0.1 + x / 77, (y * 0.37) / 32, ((x * 5 + y) % 9) / 9]),
  good: (x, y) => truth(x, y).map((v) => v + 0.05),
  slow: (x, y) => [0, 1, 2].map((c) => ((x * (c + 3) + y * (7 - c)) % 11 < 5 ? 0.9 : 0.05 * c)),
};

// `evil(from, to)` makes the picture of the last method out of that of "slow".
export function makeStudy(folder, evil) {
  for (const part of ["pictures", "references", "runs"]) fs.mkdirSync(path.join(folder, part), {recursive: true});
  const runs = [];
  const wholes = [];
  kSources.forEach((source, s) =>
    kMethods.forEach((method, m) => {
      const [seconds, rmse, pareto] = kResults[s][m];
      const some = (value) => ({seconds: value, rmse, psnr: null, dropped: 0});
      runs.push({
        settings: {source, method},
        median: some(seconds),
        spread: {seconds: 0.001, rmse: 0, psnr: null, dropped: 0},
        mean: some(seconds),
        interval95: {seconds: 0.002, rmse: 0.01, psnr: null, dropped: 0},
        values: {seconds: [seconds, seconds], rmse: [rmse, rmse], psnr: [null, null], dropped: [0, 0]},
        pareto,
      });
      wholes.push({
        source,
        strategy: `strategy-${m}`,
        reference: "sobol-owen:spp=64",
        size: `${kWidth}x${kHeight}`,
        layout: "rgb",
        ppd: "40",
      });
    }),
  );
  const results = {
    study: "hand-made",
    title: `Title ${kEvil}`,
    work: "strategy",
    repeats: 1,
    seeds: 2,
    measure: ["seconds", "rmse"],
    fixed: {size: `${kWidth}x${kHeight}`, layout: "rgb", ppd: "40"},
    pareto: {measures: ["seconds", "rmse"], within: ["source"]},
    runs,
    faster: [{first: "good", second: kEvil, where: {source: "first"}, ratio: 0.9, t: -3, freedom: 4, p: 0.01}],
  };
  fs.writeFileSync(path.join(folder, "results.json"), JSON.stringify(results));
  fs.writeFileSync(
    path.join(folder, "plan.json"),
    JSON.stringify({work: "strategy", version: "0", threads: "2", settings: wholes}),
  );
  const at = (part, name) => path.join(folder, part, name);
  writeExr(at("references", "first.exr"), 3 * kWidth, kHeight, cell, {"triad:cells": "3x1"});
  fs.writeFileSync(
    at("references", "first.json"),
    JSON.stringify({
      reference: `first ${kWidth}x${kHeight} cells 3x1 camera '' effects '' bounces 32 by sobol-owen:spp=64`,
      rmse: 0,
    }),
  );
  Object.entries(pictures).forEach(([name, pixel], i) =>
    writeExr(at("pictures", `00${i}-first-${name}.exr`), kWidth, kHeight, pixel),
  );
  evil(at("pictures", "002-first-slow.exr"), at("pictures", "003-first-evil.exr"));
  writeExr(at("pictures", "004-second-cheap.exr"), 20, 30, () => [0.5, 0.5, 0.5]);
  return results;
}
