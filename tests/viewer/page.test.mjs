// SPDX-License-Identifier: Apache-2.0
// Reports in Chromium, from disk and without a network: every control does what it says.
import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import fs from "node:fs";
import {createRequire} from "node:module";
import os from "node:os";
import path from "node:path";
import test from "node:test";
import {pathToFileURL} from "node:url";
import {
  click,
  colourAt,
  complaints,
  encode,
  frames,
  near,
  nearColour,
  numberIn,
  open,
  placeOf,
  pointAt,
  press,
  probe,
  requests,
  settled,
  watch,
} from "./reader.mjs";
import {kEvil, kMethods, kSources, makeStudy, pictures, truth} from "./study_folder.mjs";

const program = process.env.TRIAD_PROGRAM;
const {chromium} = createRequire(path.join(process.env.TRIAD_PAGE, "package.json"))("playwright-core");
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "triad-report-"));
const study = path.join(folder, "study");

function triad(...words) {
  const {status, stdout, stderr} = spawnSync(program, words, {encoding: "utf8"});
  return {status, stdout, stderr};
}
function succeed(...words) {
  const {status, stderr} = triad(...words);
  assert.equal(status, 0, stderr);
}

let browser;
let context;
let page;

test.before(async () => {
  const chrome = process.env.CHROMIUM ?? "/usr/bin/chromium";
  assert.ok(fs.existsSync(chrome), `${chrome} is not there; Debian's package is chromium, $CHROMIUM names another`);
  makeStudy(study, (from, to) =>
    succeed("run", from, "eye:layout=qd-oled,ppd=40,grid=pixels", "-o", to, "--depth", "float"),
  );
  succeed("report", study);
  browser = await chromium.launch({executablePath: chrome, args: ["--no-sandbox", "--enable-unsafe-swiftshader"]});
  context = await browser.newContext({
    viewport: {width: 1024, height: 700},
    deviceScaleFactor: 1,
    colorScheme: "light",
    reducedMotion: "reduce",
  });
  await context.setOffline(true);
  page = watch(await context.newPage());
  await open(page, path.join(study, "report.html"));
});
test.after(async () => {
  await browser?.close();
  fs.rmSync(folder, {recursive: true});
});

test("the same results give the same bytes, and calls that cannot work one line", () => {
  const twice = path.join(folder, "twice.html");
  succeed("report", study, "-o", twice, "--threads", "1");
  assert.ok(fs.readFileSync(twice).equals(fs.readFileSync(path.join(study, "report.html"))));
  fs.mkdirSync(path.join(folder, "empty"));
  fs.mkdirSync(path.join(folder, "broken"));
  fs.writeFileSync(path.join(folder, "broken", "results.json"), '{"runs": [{}]}');
  fs.writeFileSync(path.join(folder, "broken", "plan.json"), "{}");
  for (const [words, what] of [
    [["report", path.join(folder, "nowhere")], /is not there/],
    [["report", path.join(folder, "empty")], /has no results\.json/],
    [["report", path.join(folder, "broken")], /not as a study writes it/],
    [["report", study, "-o", path.join(folder, "nowhere", "r.html")], /nowhere/],
    [["report", study, "--embed", "some"], /--embed/],
    [["report", path.join(study, "plan.json")], /triad compare --json/],
    [["report", study, "--ref-cells", "3x1"], /--ref-cells/],
  ]) {
    const {status, stderr} = triad(...words);
    assert.equal(status, 2, stderr);
    // This study's folder has no pictures of some settings, which is warned of before anything is written.
    const lines = stderr.trim().split("\n").filter((line) => !/warning: .* has pictures of 5 of its 8 settings/.test(line));
    assert.equal(lines.length, 1, stderr);
    assert.match(lines[0], what);
  }
});

test("the page is readable at 1024 pixels, and its controls have names", async () => {
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 1024);
  const nameless = await page.evaluate(() =>
    [...document.querySelectorAll("button, input, select, canvas, [role=slider], svg[role=img]")]
      .filter((e) => !(e.getAttribute("aria-label") || e.labels?.[0]?.textContent.trim() || e.textContent.trim()))
      .map((e) => e.outerHTML.slice(0, 100)),
  );
  assert.deepEqual(nameless, []);
  const small = await page.evaluate(
    () =>
      [...document.querySelectorAll("main button")].filter(
        (e) => e.offsetHeight && Math.min(e.offsetHeight, e.offsetWidth) < 24,
      ).length,
  );
  assert.equal(small, 0, "targets are 24 pixels at least");
});

test("names with markup, quotes and Unicode are text", async () => {
  assert.equal(await page.title(), `Title ${kEvil}`);
  assert.equal(await page.locator("h1").textContent(), `Title ${kEvil}`);
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator("main img").count(), 0);
  assert.equal((await page.locator("#strip button").nth(3).textContent()).replace(/^\d/, ""), kEvil);
  assert.ok((await page.locator("#runs tbody td:nth-child(2)").allTextContents()).includes(kEvil));
  assert.ok((await page.locator("#group option").allTextContents()).includes(kSources[1]));
});

test("the best for a budget, and its picture on a QD-OLED panel", async () => {
  assert.equal(await page.locator("#budget-value").inputValue(), "100");
  // Geometric means over both scenes: good takes 84.9 ms at .1, the last method 84.9 at .245.
  assert.equal(await page.locator("#winner").textContent(), "good");
  for (const [budget, winner] of [
    [40, "cheap"],
    [85, "good"],
    [600, "slow"],
  ]) {
    await page.locator("#budget-value").fill(String(budget));
    assert.equal(await page.locator("#winner").textContent(), winner, `for ${budget} ms`);
  }
  await page.locator("#budget-value").fill("10");
  assert.equal(await page.locator("#winner").count(), 0);
  for (const text of ["0", "-5", ""]) {
    await page.locator("#budget-value").fill(text);
    assert.equal(await page.locator("#winner").count(), 0, `for '${text}'`);
    assert.match(await page.locator("#answer").textContent(), /Nothing fits\..*above 0, in ms/);
    assert.equal(await page.locator("#cost-chart .budget-line > *").count(), 0);
  }
  // Geometric means of 20 and 30 ms: below the second scene's least.
  await page.locator("#budget-value").fill("25");
  assert.equal(await page.locator("#winner").textContent(), "cheap");
  assert.match(await page.locator("#answer").textContent(), /geometric mean over 2 sources/);
  assert.match(await page.locator("#answer").textContent(), /onerror.*, taken alone, nothing is within 25 ms/);
  await page.locator("#budget-value").fill("100");
  assert.equal(await page.locator("#budget-layout").inputValue(), "qd-oled");
  await click(page, "look-panel");
  assert.match(await page.locator("#caption").textContent(), /first, good, at 800%/);
  assert.match(await page.locator("#view-notes").textContent(), /Emitters of qd-oled/);
  assert.match(await page.locator("#view-notes").textContent(), /reference has 3x1 values .* without emitters/);
  await click(page, "view-error");
  assert.doesNotMatch(await page.locator("#view-notes").textContent(), /Zoom in/);
  await click(page, "look");
  assert.match(await page.locator("#caption").textContent(), /^Side by side: .*first, good, at (?!800%)/);
  assert.equal(await page.locator("#layout").inputValue(), "");
});

test("keys work wherever the focus is, but for those that a control has a use for", async () => {
  await click(page, "view-one", "zoom-fit");
  await press(page, "1");
  const caption = () => page.locator("#caption").textContent();
  const type = async (...keys) => {
    for (const key of keys) await page.keyboard.press(key);
    await settled(page);
    await frames(page);
  };
  await page.locator("#exposure").focus();
  await type("2", "d");
  assert.match(await caption(), /Difference: first, good/);
  const exposure = () => page.locator("#exposure").inputValue();
  await type("ArrowRight");
  assert.match(await caption(), /first, good/, "the slider's own key");
  assert.equal(await exposure(), "0.25");
  await type("ArrowLeft", "+");
  assert.equal(await exposure(), "0.5");
  await type("-");
  await page.locator("#group").focus();
  await type("3", "s");
  assert.match(await caption(), /Split: reference of first and first, slow/);
  assert.equal(await page.locator("#group").inputValue(), "0");
  await page.locator("#budget-value").focus();
  await type("1");
  assert.match(await caption(), /first, slow/, "a number is typed");
  await page.locator("#budget-value").fill("100");
  const handle = await page.locator("#handle").boundingBox();
  await page.mouse.move(handle.x + handle.width / 2, handle.y + 30);
  await page.mouse.down();
  await page.mouse.move(handle.x + handle.width / 2 + 40, handle.y + 30);
  await page.mouse.move(handle.x + handle.width / 2, handle.y + 30);
  await page.mouse.up();
  await type("ArrowLeft");
  assert.match(await caption(), /first, good/, "once the handle was dragged");
});

test("the wheel scrolls the page, with Ctrl it zooms", async () => {
  await click(page, "zoom-fit", "zoom-800");
  await page.evaluate(() => {
    scrollTo({top: 0, behavior: "instant"});
    document.getElementById("canvas").scrollIntoView({block: "center", behavior: "instant"});
  });
  const top = () => page.evaluate(() => scrollY);
  const zoom = () => page.locator("#zoom").textContent();
  const box = await page.locator("#canvas").boundingBox();
  const before = await top();
  await page.mouse.move(box.x + 200, box.y + 100);
  await page.mouse.wheel(0, 60);
  for (let i = 0; i < 100 && (await top()) === before; ++i) await page.waitForTimeout(20);
  assert.ok((await top()) > before);
  assert.equal(await zoom(), "800%");
  assert.ok(await page.locator("#wheel-hint").isVisible());
  const scrolled = await top();
  await page.keyboard.down("Control");
  await page.mouse.wheel(0, -240);
  for (let i = 0; i < 100 && (await zoom()) === "800%"; ++i) await page.waitForTimeout(20);
  await page.keyboard.up("Control");
  assert.equal(await zoom(), "1600%");
  assert.equal(await top(), scrolled);
});

test("the emitters of a QD-OLED pixel are where its layout says", async () => {
  await click(page, "view-one", "zoom-fit", "zoom-800");
  await page.locator("#layout").selectOption("qd-oled");
  await press(page, "1");
  const [r, g, b] = pictures.cheap(20, 10);
  const at = await placeOf(page, 20, 10, 8);
  // Green lies over the upper half, red and blue in the lower quarters; all divided by the brightest's 4.
  for (const [dx, dy, light, what] of [
    [1, 1, [0, g / 2, 0], "upper left"],
    [6, 2, [0, g / 2, 0], "upper right"],
    [1, 4, [r, 0, 0], "lower left"],
    [3, 7, [r, 0, 0], "its corner"],
    [4, 4, [0, 0, b], "lower right"],
    [7, 7, [0, 0, b], "its corner"],
  ])
    nearColour(await colourAt(page, at.x + dx, at.y + dy), light.map(encode), what);
  await page.locator("#layout").selectOption("rgb");
  await settled(page);
  await frames(page);
  for (const [dx, light] of [
    [1, [r, 0, 0]],
    [4, [0, g, 0]],
    [6, [0, 0, b]],
  ])
    nearColour(await colourAt(page, at.x + dx, at.y + 3), light.map(encode), `stripe at ${dx}`);
  await page.locator("#layout").selectOption("");
});

test("values under the pointer are the file's, whatever the zoom and exposure", async () => {
  await click(page, "zoom-fit", "zoom-800");
  await press(page, "1", "+", "+");
  assert.match(await page.locator("label:has(#exposure) output").textContent(), /\+1 EV/);
  await pointAt(page, 5, 4, 8);
  const rows = await probe(page);
  assert.deepEqual(rows[0], ["cheap", "3.5", "0.25", "7", "255", "137", "255"]);
  truth(5, 4).forEach((v, c) => near(numberIn(rows[1][1 + c]), v, 2e-6));
  const at = await placeOf(page, 9, 20, 8);
  nearColour(
    await colourAt(page, at.x + 4, at.y + 4),
    pictures.cheap(9, 20).map((v) => encode(2 * v)),
    "one stop up",
  );
  await page.locator("#gamma").selectOption("2.2");
  await settled(page);
  await frames(page);
  nearColour(
    await colourAt(page, at.x + 4, at.y + 4),
    pictures.cheap(9, 20).map((v) => 255 * Math.min(1, 2 * v) ** (1 / 2.2)),
    "gamma",
  );
  await page.locator("#gamma").selectOption("0");
  await press(page, "-", "-", "Shift+ArrowRight");
  assert.match(await page.locator("#probe p").textContent(), /Pixel 6, 4/);
  pictures.cheap(6, 4).forEach(async (v, c) => near(numberIn((await probe(page))[0][1 + c]), Math.fround(v), 2e-6));
});

test("differences, error map and their scale", async () => {
  await click(page, "zoom-fit", "zoom-800");
  await press(page, "2", "m");
  const at = await placeOf(page, 30, 12, 8);
  await page.locator("#error-scale").fill("-1"); // a tenth: the error of .05 lies in the middle of the scale
  await frames(page);
  nearColour(await colourAt(page, at.x + 4, at.y + 4), [183, 55, 121], "magma(.5)"); // matplotlib's, of 2015
  assert.match(await page.locator("#legend").textContent(), /^00\.1mean/);
  await page.locator("#error-scale").fill("-1.5");
  await frames(page);
  nearColour(await colourAt(page, at.x + 4, at.y + 4), [252, 253, 191], "magma(1)");
  await page.locator("#error-scale").fill("-1");
  await press(page, "d");
  nearColour(await colourAt(page, at.x + 4, at.y + 4), [191.25, 191.25, 191.25], "half the scale above grey");
  await page.locator("#beside").selectOption({label: "good"});
  await settled(page);
  await frames(page);
  nearColour(await colourAt(page, at.x + 4, at.y + 4), [127.5, 127.5, 127.5], "a picture against itself");
  await page.locator("#beside").selectOption({label: "reference"});
});

test("side by side, split, reference and arrows", async () => {
  await click(page, "zoom-fit", "zoom-800", "view-split");
  await press(page, "3");
  const left = await placeOf(page, 20, 12, 8);
  const right = await placeOf(page, 28, 12, 8);
  nearColour(await colourAt(page, left.x + 4, left.y + 4), truth(20, 12).map(encode), "left of the handle");
  nearColour(await colourAt(page, right.x + 4, right.y + 4), pictures.slow(28, 12).map(encode), "right of it");
  await page.evaluate(() => document.getElementById("canvas").scrollIntoView({block: "center", behavior: "instant"}));
  const handle = await page.locator("#handle").boundingBox();
  await page.mouse.move(handle.x + handle.width / 2, handle.y + 30);
  await page.mouse.down();
  await page.mouse.move(handle.x + handle.width / 2 + 100, handle.y + 30);
  await page.mouse.up();
  await frames(page);
  nearColour(await colourAt(page, right.x + 4, right.y + 4), truth(28, 12).map(encode), "once the handle has passed");
  await press(page, "r");
  nearColour(await colourAt(page, left.x + 4, left.y + 4), truth(20, 12).map(encode), "the reference");
  await press(page, "r");
  nearColour(await colourAt(page, left.x + 4, left.y + 4), pictures.slow(20, 12).map(encode), "and back");
  await press(page, "ArrowLeft");
  assert.match(await page.locator("#caption").textContent(), /first, good/);
  await press(page, "ArrowRight", "ArrowRight", "ArrowRight");
  assert.match(await page.locator("#caption").textContent(), /first, cheap/, "after the last comes the first");
  await click(page, "view-side", "zoom-fit");
  // Two panes of half the width, zoomed together: the same place of both.
  const size = await page.evaluate(() => [
    document.getElementById("canvas").width,
    document.getElementById("canvas").height,
  ]);
  const half = Math.floor((size[0] - 2) / 2);
  nearColour(await colourAt(page, half / 2 + 3, size[1] / 2 + 3), truth(24, 16).map(encode), "reference");
  nearColour(
    await colourAt(page, half + 2 + half / 2 + 3, size[1] / 2 + 3),
    pictures.cheap(24, 16).map(encode),
    "picture",
  );
  await click(page, "flicker");
  const captions = new Set();
  for (let i = 0; i < 60 && captions.size < 2; ++i) {
    captions.add(await page.locator("#caption").textContent());
    await page.waitForTimeout(150);
  }
  assert.equal(captions.size, 2, "it flickers");
  await click(page, "flicker");
});

test("what an eye sees is what the program's eye sees", async () => {
  await click(page, "view-one", "zoom-fit", "zoom-800");
  await press(page, "4"); // what the eye plugin made of "slow"
  const seen = [];
  const places = [
    [0, 0],
    [3, 5],
    [24, 16],
    [30, 31],
    [47, 2],
  ];
  for (const [x, y] of places) {
    await pointAt(page, x, y, 8);
    seen.push((await probe(page))[0].slice(1, 4).map(numberIn));
  }
  await page.locator("#layout").selectOption("qd-oled");
  await press(page, "3");
  await click(page, "seen");
  assert.match(await page.locator("#view-notes").textContent(), /40 pixels per degree away \(60\.6 cm/);
  assert.match(
    await page.locator("#view-notes").textContent(),
    /scores of this report belong to 40 pixels per degree on rgb/,
  );
  for (const [i, [x, y]] of places.entries()) {
    await pointAt(page, x, y, 8);
    (await probe(page))[0]
      .slice(1, 4)
      .map(numberIn)
      .forEach((v, c) => near(v, seen[i][c], 1e-3, `${x}, ${y}:`));
  }
  const near1 = (await probe(page))[0];
  await page.locator("#ppd").fill("2");
  await settled(page);
  await frames(page);
  assert.match(await page.locator("label:has(#ppd) output").textContent(), /100 ppd/);
  assert.notDeepEqual((await probe(page))[0], near1, "from further away it looks different");
  await page.locator("#ppd").fill("1.6");
  await click(page, "seen");
  await page.locator("#layout").selectOption("");
});

test("the Pareto front has the points that the results have", async () => {
  const results = JSON.parse(fs.readFileSync(path.join(study, "results.json"), "utf8"));
  for (const source of kSources) {
    await page.locator("#choose-source").selectOption(source);
    const marked = await page
      .locator("#cost-chart .points > *")
      .evaluateAll((points) =>
        points.map((p) => p.getAttribute("aria-label")).filter((label) => label.includes("on the Pareto front")),
      );
    const expected = results.runs
      .filter((run) => run.settings.source === source && run.pareto)
      .map((run) => run.settings.method);
    assert.equal(await page.locator("#cost-chart .points > *").count(), kMethods.length);
    assert.equal(await page.locator("#cost-chart .front-points > *").count(), expected.length);
    assert.deepEqual(
      kMethods.filter((method) => marked.some((label) => label.startsWith(method + ","))),
      kMethods.filter((m) => expected.includes(m)),
    );
  }
  // A point's keyboard and click: its picture.
  await page.locator("#choose-source").selectOption("first");
  await page.locator("#cost-chart .points > *").nth(1).focus();
  assert.match(await page.locator("#point").textContent(), /good · rmse 0\.1 .* · seconds 80 ms .* strategy-1/);
  await page.keyboard.press("Enter");
  await settled(page);
  await frames(page);
  assert.match(await page.locator("#caption").textContent(), /first, good/);
  // Of a mean, the picture of the scene that is shown.
  await page.locator("#group").selectOption("1");
  await page.locator("#choose-source").selectOption("");
  await page.locator("#cost-chart .points > *").first().focus();
  assert.match(await page.locator("#point").textContent(), /geometric mean of 2/);
  await page.locator("#cost-chart .points > *").first().click();
  await settled(page);
  await frames(page);
  assert.match(await page.locator("#caption").textContent(), /onerror.*, cheap/);
  await page.locator("#group").selectOption("0");
  await page.mouse.move(0, 0);
  await page.locator("#cost-chart .points > *").first().focus();
  await page.locator("#choose-source").selectOption("first");
  assert.match(await page.locator("#point").textContent(), /Dashed: the Pareto front/, "no point of another chart");
  await page.locator("#measure-y").selectOption("dropped");
  await page.locator("#knob-measure").selectOption("dropped");
  for (const chart of ["cost", "knob"])
    assert.equal(await page.locator(`#${chart}-chart`).textContent(), "dropped: all zero.");
  await page.locator("#measure-y").selectOption("rmse");
  await page.locator("#knob-measure").selectOption("rmse");
  await page.locator(".legend-line").first().click();
  assert.equal(await page.locator("#cost-chart .points > *").count(), kMethods.length - 1);
  await page.locator(".legend-line").first().click();
  assert.ok((await page.locator("#knob-chart .bars > *").count()) === kMethods.length);
  assert.ok((await page.locator("#analysis-charts .histogram > *").count()) > 0);
  assert.ok((await page.locator("#analysis-charts .spectrum > *").count()) > 0);
});

test("the table sorts and is saved as CSV and JSON", async () => {
  const head = page.locator("#runs thead th button", {hasText: "rmse"});
  const column = () =>
    page.locator("#runs tbody td:nth-child(4)").evaluateAll((cells) => cells.map((c) => Number(c.dataset.value)));
  await head.click();
  assert.deepEqual(await column(), [0.05, 0.1, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5]);
  // Beside the text: the whole cell is a target.
  await page.locator("#runs thead th", {hasText: "rmse"}).click({position: {x: 3, y: 3}});
  assert.deepEqual(await column(), [0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.1, 0.05]);
  const save = async (id) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator(`#${id}`).click()]);
    return fs.readFileSync(await download.path(), "utf8");
  };
  const lines = (await save("save-csv")).trimEnd().split("\r\n");
  assert.equal(lines.length, 9);
  assert.ok(lines[4].startsWith(`first,"${kEvil.replaceAll('"', '""')}",0.09,`), lines[4]);
  const saved = JSON.parse(await save("save-json"));
  assert.deepEqual(
    saved.runs.map((run) => run.shown.rmse),
    [0.5, 0.1, 0.05, 0.3, 0.4, 0.1, 0.15, 0.2],
  );
  assert.equal(saved.runs[3].settings.method, kEvil);
});

test("dark and light by switch", async () => {
  const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await ground();
  await click(page, "view-one", "zoom-fit");
  await click(page, "theme");
  assert.equal(await ground(), light, "the system's is light");
  await click(page, "theme");
  assert.equal(await ground(), "rgb(20, 22, 27)");
  await frames(page);
  nearColour(await colourAt(page, 2, 2), [14, 16, 20], "the picture's ground");
  await click(page, "theme");
});

test("float data beside the page is loaded when looked at, or its codes are shown", async () => {
  const file = path.join(folder, "beside.html");
  succeed("report", study, "-o", file, "--embed", "codes");
  const beside = watch(await context.newPage());
  await open(beside, file);
  await click(beside, "view-one", "zoom-fit", "zoom-800");
  await pointAt(beside, 5, 4, 8);
  assert.deepEqual((await probe(beside))[0].slice(0, 4), ["cheap", "3.5", "0.25", "7"]);
  const before = complaints.length;
  fs.rmSync(path.join(folder, "beside_data"), {recursive: true});
  await open(beside, file);
  await click(beside, "view-one", "zoom-fit", "zoom-800");
  await pointAt(beside, 5, 4, 8);
  assert.deepEqual((await probe(beside))[0].slice(4), ["255", "137", "255"]);
  assert.match(await beside.locator("#view-notes").textContent(), /8-bit values only/);
  complaints.length = before; // the browser says that the files are missing, and so does the page
  await beside.close();
});

test("compared pictures have a report, too", async () => {
  const [one, two, reference] = [
    "pictures/001-first-good.exr",
    "pictures/000-first-cheap.exr",
    "references/first.exr",
  ].map((name) => path.join(study, name));
  const json = path.join(folder, "scores.json");
  succeed("run", reference, "box:x=3", "-o", path.join(folder, "mean.exr"), "--depth", "float");
  succeed(
    "compare",
    one,
    two,
    "--ref",
    path.join(folder, "mean.exr"),
    "-m",
    "error",
    "--json",
    json,
    "--report",
    path.join(folder, "pictures.html"),
  );
  succeed("report", json);
  assert.ok(
    fs.readFileSync(path.join(folder, "pictures.html")).equals(fs.readFileSync(path.join(folder, "scores.html"))),
  );
  const compared = watch(await context.newPage());
  await open(compared, path.join(folder, "scores.html"));
  assert.equal(await compared.locator("#budget").isVisible(), false, "there is nothing to spend");
  assert.equal(await compared.locator("#runs tbody tr").count(), 2);
  assert.equal(await compared.locator("#cost h2").textContent(), "Scores");
  assert.ok((await compared.locator("nav a").allTextContents()).includes("Scores"));
  assert.equal(await compared.locator("#group").isVisible(), false, "there is one scene");
  assert.equal(await compared.locator("#knob-scope").textContent(), "", "nothing is averaged");
  await click(compared, "view-one", "zoom-fit", "zoom-800");
  await pointAt(compared, 30, 12, 8);
  assert.match(await compared.locator("#probe p").textContent(), /error 0\.05$/);
  const column = (await compared.locator("#runs thead th").allTextContents()).indexOf("error.rmse") + 1;
  near(
    Number(await compared.locator(`#runs tbody tr:first-child td:nth-child(${column})`).getAttribute("data-value")),
    0.05,
    1e-6,
  );
  await compared.close();
});

test("without WebGL2 the same colours", async () => {
  const plain = watch(await context.newPage());
  await open(plain, path.join(study, "report.html"), "#plain");
  assert.equal(await plain.locator("#painter").textContent(), "2-D canvas");
  assert.equal(await page.locator("#painter").textContent(), "WebGL2");
  for (const one of [page, plain]) {
    await click(one, "view-one", "zoom-fit", "zoom-800");
    await press(one, "1");
    await one.locator("#layout").selectOption("pentile-rgbg");
    await settled(one);
    await frames(one);
  }
  const at = await placeOf(page, 20, 10, 8);
  for (const [dx, dy] of [
    [2, 2],
    [6, 2],
    [10, 5],
    [14, 5],
    [2, 10],
    [6, 14],
    [10, 12],
    [14, 12],
  ])
    nearColour(await colourAt(plain, at.x + dx, at.y + dy), await colourAt(page, at.x + dx, at.y + dy), `${dx}, ${dy}`);
  await plain.close();
});

test("without JavaScript the tables are there", async () => {
  const bare = await browser.newContext({javaScriptEnabled: false, offline: true});
  const still = await bare.newPage();
  await still.goto(pathToFileURL(path.join(study, "report.html")).href);
  assert.equal(await still.locator("#runs tbody tr").count(), 8);
  assert.equal(await still.locator("#runs tbody tr.best").count(), 6);
  assert.match(await still.locator("#results").innerText(), /one-tailed/);
  assert.ok(await still.locator("noscript").count());
  assert.equal(await still.locator("#pictures").isVisible(), false);
  assert.deepEqual(await still.locator("nav a:visible").allTextContents(), ["Table"]);
  await bare.close();
});

test("nothing was fetched and nothing complained", async () => {
  assert.deepEqual(complaints, []);
  assert.deepEqual(
    requests.filter((url) => !/^(file|data|blob):/.test(url)),
    [],
  );
  assert.equal(await page.locator("#errors").isVisible(), false);
});
