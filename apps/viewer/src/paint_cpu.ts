// SPDX-License-Identifier: Apache-2.0
// The view on a plain canvas, for browsers without WebGL2. Says in TypeScript what paint_gl.ts says in GLSL.
import {linearToSrgb} from "./codec";
import {errorOf, kMagma, samplesOf, type Frame, type Painter, type Pane, type Shown} from "./frame";
import {cellLight} from "./panel";

type Rgb = [number, number, number];
const clamp = (v: number): number => (v > 0 ? (v < 1 ? v : 1) : 0);

export function encode(value: number, exposure: number, gamma: number): number {
  const light = clamp(value * 2 ** exposure);
  return gamma > 0 ? light ** (1 / gamma) : linearToSrgb(light);
}

// The light at (x, y) in display pixels; false outside.
export function lightAt(shown: Shown, frame: Frame, x: number, y: number, out: Rgb): boolean {
  const {light} = shown;
  const px = Math.floor(x * light.scaleX);
  const py = Math.floor(y * light.scaleY);
  if (px < 0 || py < 0 || px >= light.width || py >= light.height) return false;
  if (!shown.asPanel || !frame.panel) {
    for (let c = 0; c < 3; ++c) out[c] = shown.gain * (light.rgb[3 * (py * light.width + px) + c] as number);
    return true;
  }
  const drive = (qx: number, qy: number, c: number): number =>
    qx < 0 || qy < 0 || qx >= light.width || qy >= light.height
      ? 0
      : clamp(light.rgb[3 * (qy * light.width + qx) + c] as number);
  const [cellsX, cellsY] = frame.panel.layout.cells;
  cellLight(frame.panel, Math.floor(x * cellsX), Math.floor(y * cellsY), drive, out);
  for (let c = 0; c < 3; ++c) out[c] = shown.gain * (out[c] as number);
  return true;
}

const a: Rgb = [0, 0, 0];
const b: Rgb = [0, 0, 0];
const sum: Rgb = [0, 0, 0];

// The encoded colour in 0..255 of a device pixel whose centre is (x, y) on the canvas.
export function shade(frame: Frame, pane: Pane, x: number, y: number, out: Rgb): void {
  const n = samplesOf(frame.zoom);
  sum[0] = sum[1] = sum[2] = 0;
  let count = 0;
  let error = 0;
  for (let j = 0; j < n; ++j)
    for (let i = 0; i < n; ++i) {
      const px = (x - pane.left + (i + 0.5) / n - 0.5) / frame.zoom;
      const py = (y - pane.top + (j + 0.5) / n - 0.5) / frame.zoom;
      if (!lightAt(pane.a, frame, px, py, a)) continue;
      b[0] = b[1] = b[2] = 0;
      if (pane.b && pane.mode !== "picture" && !lightAt(pane.b, frame, px, py, b)) continue;
      ++count;
      error += errorOf(a, b);
      for (let c = 0; c < 3; ++c) sum[c] = (sum[c] as number) + (a[c] as number) - (b[c] as number);
    }
  for (let c = 0; c < 3; ++c) {
    const mean = (sum[c] as number) / count;
    if (count === 0) out[c] = 255 * (frame.background[c] as number);
    else if (pane.mode === "picture") out[c] = 255 * encode(mean, frame.exposure, frame.gamma);
    else if (pane.mode === "difference") out[c] = 255 * clamp(0.5 + (0.5 * mean) / frame.errorMost);
    else out[c] = kMagma[4 * Math.round(255 * clamp(error / count / frame.errorMost)) + c] as number;
  }
}

export function makeCpuPainter(canvas: HTMLCanvasElement): Painter {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser has no canvas");
  const rgb: Rgb = [0, 0, 0];
  return {
    name: "2-D canvas",
    draw(frame) {
      context.fillStyle = `rgb(${frame.background.map((v) => 255 * v).join(" ")})`;
      context.fillRect(0, 0, canvas.width, canvas.height);
      for (const pane of frame.panes) {
        const width = Math.round(pane.width);
        const height = Math.round(pane.height);
        if (width < 1 || height < 1) continue;
        const image = context.createImageData(width, height);
        for (let y = 0; y < height; ++y)
          for (let x = 0; x < width; ++x) {
            shade(frame, pane, Math.round(pane.x) + x + 0.5, Math.round(pane.y) + y + 0.5, rgb);
            const at = 4 * (y * width + x);
            for (let c = 0; c < 3; ++c) image.data[at + c] = Math.round(rgb[c] as number);
            image.data[at + 3] = 255;
          }
        context.putImageData(image, Math.round(pane.x), Math.round(pane.y));
      }
    },
  };
}
