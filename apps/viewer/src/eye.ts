// SPDX-License-Identifier: Apache-2.0
// What an eye at a distance sees of light: opponent channels, each blurred by a sum of two Gaussians, and back. The
// same as libcore/display/eye.hpp does through the Fourier transform, with neutral greys.
import type {Vision} from "./data";
import {cellLight, type Panel} from "./panel";
import type {Light} from "./pictures";

// c b a | a b c | c b a
export function mirrored(i: number, size: number): number {
  const j = ((i % (2 * size)) + 2 * size) % (2 * size);
  return j < size ? j : 2 * size - 1 - j;
}

// A filter of one line in place. Its transfer is that of exp(-x^2 / (2 sigma^2)), sigma in samples, 1 for constants.
export type LineBlur = (line: Float64Array) => void;

// Below this a kernel's taps are written out; above, recursion is quicker and as good.
const kRecursive = 3;

export function lineBlur(sigma: number): LineBlur {
  return sigma < kRecursive ? tapsBlur(gaussianTaps(sigma)) : recursiveBlur(sigma);
}

// h[n], n = 0 .. radius: the integral over the band of exp(-2 pi^2 sigma^2 f^2) cos(2 pi f n), which for small sigma
// is not the sampled Gaussian.
export function gaussianTaps(sigma: number): number[] {
  const radius = Math.max(Math.ceil(5 * sigma), sigma < 1 ? 32 : 0);
  const steps = 1024;
  const taps: number[] = [];
  for (let n = 0; n <= radius; ++n) {
    let sum = 0;
    for (let k = 0; k < steps; ++k) {
      const f = (k + 0.5) / steps - 0.5;
      sum += Math.exp(-2 * (Math.PI * sigma * f) ** 2) * Math.cos(2 * Math.PI * f * n);
    }
    taps.push(sum / steps);
  }
  const total = (taps[0] as number) + 2 * taps.slice(1).reduce((a, b) => a + b, 0);
  return taps.map((tap) => tap / total);
}

function tapsBlur(taps: number[]): LineBlur {
  const radius = taps.length - 1;
  const h = Float64Array.from(taps);
  let padded = new Float64Array(0);
  return (line) => {
    const n = line.length;
    if (padded.length !== n + 2 * radius) padded = new Float64Array(n + 2 * radius);
    padded.set(line, radius);
    for (let i = 0; i < radius; ++i) {
      padded[radius - 1 - i] = line[mirrored(-1 - i, n)] as number;
      padded[radius + n + i] = line[mirrored(n + i, n)] as number;
    }
    for (let i = 0; i < n; ++i) {
      const c = i + radius;
      let sum = (h[0] as number) * (padded[c] as number);
      for (let k = 1; k <= radius; ++k) sum += (h[k] as number) * ((padded[c - k] as number) + (padded[c + k] as number));
      line[i] = sum;
    }
  };
}

// Deriche, Recursively implementing the Gaussian and its derivatives (INRIA RR-1893, 1993), of fourth order: for x >= 0
// exp(-x^2 / 2) is about (1.68 cos .6318x + 3.735 sin .6318x) exp(-1.783x)
// - (.6803 cos 1.997x + .2598 sin 1.997x) exp(-1.723x).
const kDeriche = [
  {cos: 1.68, sin: 3.735, frequency: 0.6318, decay: 1.783},
  {cos: -0.6803, sin: -0.2598, frequency: 1.997, decay: 1.723},
];

function recursiveBlur(sigma: number): LineBlur {
  const parts = kDeriche.map((term) => {
    const w = term.frequency / sigma;
    const shrink = Math.exp(-term.decay / sigma);
    return {
      n0: term.cos,
      n1: shrink * (term.sin * Math.sin(w) - term.cos * Math.cos(w)),
      d1: -2 * shrink * Math.cos(w),
      d2: shrink * shrink,
    };
  });
  // Both directions' gain for constants; the sample itself belongs to the first only.
  const gain = parts.reduce((sum, p) => sum + (2 * (p.n0 + p.n1)) / (1 + p.d1 + p.d2) - p.n0, 0);
  let forward = new Float64Array(0);
  return (line) => {
    const n = line.length;
    if (forward.length !== n) forward = new Float64Array(n);
    forward.fill(0);
    const lead = Math.ceil(10 * sigma);
    for (const {n0, n1, d1, d2} of parts) {
      let y1 = 0;
      let y2 = 0;
      let x1 = line[mirrored(-lead - 1, n)] as number;
      for (let i = -lead; i < n; ++i) {
        const x0 = line[i < 0 ? mirrored(i, n) : i] as number;
        const y0 = n0 * x0 + n1 * x1 - d1 * y1 - d2 * y2;
        if (i >= 0) forward[i] = (forward[i] as number) + y0;
        x1 = x0;
        y2 = y1;
        y1 = y0;
      }
      y1 = y2 = 0;
      // Its response to a sample at 0 begins at -1: n1' = n1 - d1 n0, n2' = -d2 n0.
      const m1 = n1 - d1 * n0;
      const m2 = -d2 * n0;
      let next1 = 0;
      let next2 = 0;
      for (let i = n - 1 + lead; i >= 0; --i) {
        const y0 = m1 * next1 + m2 * next2 - d1 * y1 - d2 * y2;
        if (i < n) forward[i] = (forward[i] as number) + y0;
        next2 = next1;
        next1 = line[i < n ? i : mirrored(i, n)] as number;
        y2 = y1;
        y1 = y0;
      }
    }
    for (let i = 0; i < n; ++i) line[i] = (forward[i] as number) / gain;
  };
}

const clamp = (v: number): number => (v > 0 ? (v < 1 ? v : 1) : 0); // NaN is 0

// The light of a picture on a panel, or of a render's own cells (panel null), clamped to what there is, one row of cells.
type LightRow = (y: number, row: Float64Array) => void;

interface Field {
  width: number; // display pixels, with `pad` more on each side
  height: number;
  scaleX: number; // cells of a pixel
  scaleY: number;
  pad: number;
  row: LightRow; // interleaved RGB of (width + 2 pad) * scaleX cells
}

function panelField(drives: Light, panel: Panel, pad: number): Field {
  const {width, height, rgb} = drives;
  const [scaleX, scaleY] = panel.layout.cells;
  const drive = (x: number, y: number, c: number): number =>
    clamp(rgb[3 * (mirrored(y, height) * width + mirrored(x, width)) + c] as number);
  const out: [number, number, number] = [0, 0, 0];
  return {
    ...{width, height, scaleX, scaleY, pad},
    row: (y, row) => {
      for (let k = 0; k < (width + 2 * pad) * scaleX; ++k) {
        cellLight(panel, k - pad * scaleX, y, drive, out);
        row.set(out, 3 * k);
      }
    },
  };
}

function cellsField(light: Light, pad: number): Field {
  const {scaleX, scaleY, rgb} = light;
  return {
    ...{width: light.width / scaleX, height: light.height / scaleY, scaleX, scaleY, pad},
    row: (y, row) => {
      const from = mirrored(y, light.height) * light.width;
      for (let k = 0; k < row.length / 3; ++k)
        for (let c = 0; c < 3; ++c)
          row[3 * k + c] = clamp(rgb[3 * (from + mirrored(k - pad * scaleX, light.width)) + c] as number);
    },
  };
}

// Means over display pixels of what is seen, linear RGB. `panel` null: the picture is light and no panel's drives.
// `pause` is awaited now and then; it throws to give up.
export async function see(
  picture: Light, panel: Panel | null, vision: Vision, ppd: number, pause: () => Promise<void>,
): Promise<Light> {
  const widest = Math.max(...vision.gaussians.flat().map(([, spread]) => spread));
  const pad = Math.ceil(((3.5 * widest) / Math.SQRT2) * ppd);
  const field = panel ? panelField(picture, panel, pad) : cellsField(picture, pad);
  const {width, height, scaleX, scaleY} = field;
  const rows = (height + 2 * pad) * scaleY;
  const across = (width + 2 * pad) * scaleX;
  const blursX = vision.gaussians.map((g) => g.map(([, s]) => lineBlur((s * ppd * scaleX) / Math.SQRT2)));
  const blursY = vision.gaussians.map((g) => g.map(([, s]) => lineBlur((s * ppd * scaleY) / Math.SQRT2)));
  // [channel][Gaussian]: a value for each row of cells and column of pixels.
  const planes = vision.gaussians.map((g) => g.map(() => new Float32Array(rows * width)));
  const light = new Float64Array(3 * across);
  const line = new Float64Array(across);
  for (let y = 0; y < rows; ++y) {
    if (y % 64 === 0) await pause();
    field.row(y - pad * scaleY, light);
    for (let c = 0; c < 3; ++c)
      for (let g = 0; g < 2; ++g) {
        const m = vision.toOpponent.slice(3 * c, 3 * c + 3) as [number, number, number];
        for (let k = 0; k < across; ++k)
          line[k] =
            m[0] * (light[3 * k] as number) + m[1] * (light[3 * k + 1] as number) + m[2] * (light[3 * k + 2] as number);
        blursX[c]?.[g]?.(line);
        const plane = planes[c]?.[g] as Float32Array;
        for (let x = 0; x < width; ++x) {
          let sum = 0;
          for (let i = 0; i < scaleX; ++i) sum += line[(pad + x) * scaleX + i] as number;
          plane[y * width + x] = sum / scaleX;
        }
      }
  }
  const rgb = new Float32Array(3 * width * height);
  const column = new Float64Array(rows);
  for (let c = 0; c < 3; ++c) {
    const weights = vision.gaussians[c]?.map(([weight]) => weight) as number[];
    const flat = weights.reduce((a, b) => a + b, 0);
    for (let g = 0; g < 2; ++g) {
      const plane = planes[c]?.[g] as Float32Array;
      for (let x = 0; x < width; ++x) {
        if (x % 128 === 0) await pause();
        for (let y = 0; y < rows; ++y) column[y] = plane[y * width + x] as number;
        blursY[c]?.[g]?.(column);
        for (let y = 0; y < height; ++y) {
          let sum = 0;
          for (let j = 0; j < scaleY; ++j) sum += column[(pad + y) * scaleY + j] as number;
          const seen = ((sum / scaleY) * (weights[g] as number)) / flat;
          for (let d = 0; d < 3; ++d) {
            const at = 3 * (y * width + x) + d;
            rgb[at] = (rgb[at] as number) + (vision.toRgb[3 * d + c] as number) * seen;
          }
        }
      }
    }
  }
  return {width, height, scaleX: 1, scaleY: 1, rgb};
}
