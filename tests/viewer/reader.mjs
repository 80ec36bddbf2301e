// SPDX-License-Identifier: Apache-2.0
// What a reader of a report does and sees.
import assert from "node:assert/strict";
import {pathToFileURL} from "node:url";
import {kHeight, kWidth} from "./study_folder.mjs";

export const near = (value, expected, tolerance, what = "") =>
  assert.ok(Math.abs(value - expected) <= tolerance, `${what} ${value} is not ${expected} within ${tolerance}`);
export const encode = (v) => {
  const light = Math.min(1, Math.max(0, v));
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055);
};
export const nearColour = (colour, expected, what) =>
  expected.forEach((v, c) => near(colour[c], v, 1.5, `${what}, channel ${c}:`));

export const complaints = [];
export const requests = [];

export function watch(one) {
  one.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  one.on("pageerror", (error) => complaints.push(error.message));
  one.on("request", (request) => requests.push(request.url()));
  return one;
}
// Not by waitForFunction(), which evaluates texts in the page, and the page forbids that.
export const settled = (one) =>
  one.evaluate(
    () =>
      new Promise((done) => {
        const look = () =>
          document.getElementById("canvas").getAttribute("aria-busy") === "false" ? done() : setTimeout(look, 5);
        look();
      }),
  );
export async function open(one, file, hash = "") {
  await one.goto(pathToFileURL(file).href + hash);
  await settled(one);
}
// The colour of a device pixel of the canvas.
export const colourAt = (one, x, y) =>
  one.evaluate(
    ([px, py]) => {
      const from = document.getElementById("canvas");
      const copy = new OffscreenCanvas(1, 1).getContext("2d");
      copy.drawImage(from, px, py, 1, 1, 0, 0, 1, 1);
      return [...copy.getImageData(0, 0, 1, 1).data].slice(0, 3);
    },
    [Math.floor(x), Math.floor(y)],
  );
// Where display pixel (x, y) lies in a view of one picture, or of a split, that was fitted and then zoomed.
export async function placeOf(one, x, y, zoom, width = kWidth, height = kHeight) {
  const size = await one.evaluate(() => {
    const {width: w, height: h} = document.getElementById("canvas");
    return {w, h};
  });
  return {
    x: Math.round(size.w / 2 - (width / 2) * zoom) + x * zoom,
    y: Math.round(size.h / 2 - (height / 2) * zoom) + y * zoom,
  };
}
export async function pointAt(one, x, y, zoom) {
  await one.evaluate(() => document.getElementById("canvas").scrollIntoView({block: "center", behavior: "instant"}));
  const box = await one.locator("#canvas").boundingBox();
  const at = await placeOf(one, x, y, zoom);
  await one.mouse.move(box.x + at.x + zoom / 2, box.y + at.y + zoom / 2);
}
// The rows of the table of values: name, then three linear values and three codes.
export const probe = (one) =>
  one.evaluate(() =>
    [...document.querySelectorAll("#probe tbody tr")].map((row) => [...row.cells].map((cell) => cell.textContent)),
  );
export const numberIn = (text) => Number(text.replace("−", "-"));
export const frames = (one) =>
  one.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
export async function press(one, ...keys) {
  await one.locator("#canvas").focus();
  for (const key of keys) await one.keyboard.press(key);
  await settled(one);
  await frames(one);
}
export async function click(one, ...ids) {
  for (const id of ids) await one.locator(`#${id}`).click();
  await settled(one);
  await frames(one);
}
