// SPDX-License-Identifier: Apache-2.0
// What a picture's error is made of: how large it is how often, and at which frequencies. Pure functions.
import type {Light} from "./pictures";

// Luminance of linear Rec. 709 (IEC 61966-2-1).
const luminance = (rgb: Float32Array, pixel: number): number =>
  0.2126 * (rgb[3 * pixel] as number) + 0.7152 * (rgb[3 * pixel + 1] as number) + 0.0722 * (rgb[3 * pixel + 2] as number);

// Signed, of luminance.
export function errorPlane(test: Light, reference: Light): Float64Array {
  const plane = new Float64Array(test.width * test.height);
  for (let i = 0; i < plane.length; ++i) {
    const error = luminance(test.rgb, i) - luminance(reference.rgb, i);
    plane[i] = Number.isFinite(error) ? error : 0;
  }
  return plane;
}

export interface Bin {
  from: number;
  to: number;
  share: number; // of the pixels
}
// Sizes of errors in `perDecade` bins a decade from 10^low to 10^high; what is smaller is in the first one, larger in
// the last.
export function errorHistogram(plane: Float64Array, low = -5, high = 1, perDecade = 4): Bin[] {
  const count = (high - low) * perDecade;
  const sums = new Float64Array(count);
  for (const error of plane) {
    const place = error === 0 ? 0 : Math.floor((Math.log10(Math.abs(error)) - low) * perDecade);
    const bin = Math.min(count - 1, Math.max(0, place));
    sums[bin] = (sums[bin] as number) + 1;
  }
  return [...sums].map((sum, i) => ({
    from: 10 ** (low + i / perDecade), to: 10 ** (low + (i + 1) / perDecade), share: sum / plane.length,
  }));
}

// In place, radix 2, of `re` and `im` whose length is a power of two.
export function fft(re: Float64Array, im: Float64Array): void {
  const n = re.length;
  for (let i = 1, j = 0; i < n; ++i) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j] as number, re[i] as number];
      [im[i], im[j]] = [im[j] as number, im[i] as number];
    }
  }
  for (let size = 2; size <= n; size *= 2) {
    const half = size / 2;
    for (let k = 0; k < half; ++k) {
      const c = Math.cos((-2 * Math.PI * k) / size);
      const s = Math.sin((-2 * Math.PI * k) / size);
      for (let i = k; i < n; i += size) {
        const j = i + half;
        const r = (re[j] as number) * c - (im[j] as number) * s;
        const q = (re[j] as number) * s + (im[j] as number) * c;
        re[j] = (re[i] as number) - r;
        im[j] = (im[i] as number) - q;
        re[i] = (re[i] as number) + r;
        im[i] = (im[i] as number) + q;
      }
    }
  }
}

export interface Spectrum {
  frequency: number; // cycles per pixel
  power: number; // mean power density: white noise of variance v has v everywhere
}
// Radial means of the power spectrum of a plane: Hann windows of `size` square that overlap by half (Welch, 1967), their
// means taken off. Empty for a plane that is smaller than 16 pixels a side.
export function noiseSpectrum(plane: Float64Array, width: number, height: number, largest = 128): Spectrum[] {
  let size = largest;
  while (size > Math.min(width, height)) size /= 2;
  if (size < 16) return [];
  const window = Float64Array.from({length: size}, (_, i) => 0.5 - 0.5 * Math.cos((2 * Math.PI * (i + 0.5)) / size));
  const energy = window.reduce((sum, w) => sum + w * w, 0) ** 2;
  const rings = new Float64Array(size / 2);
  const counts = new Float64Array(size / 2);
  const re = Array.from({length: size}, () => new Float64Array(size));
  const im = Array.from({length: size}, () => new Float64Array(size));
  const columnRe = new Float64Array(size);
  const columnIm = new Float64Array(size);
  for (let y0 = 0; y0 + size <= height; y0 += size / 2)
    for (let x0 = 0; x0 + size <= width; x0 += size / 2) {
      let mean = 0;
      for (let y = 0; y < size; ++y) for (let x = 0; x < size; ++x) mean += plane[(y0 + y) * width + x0 + x] as number;
      mean /= size * size;
      for (let y = 0; y < size; ++y) {
        const rowRe = re[y] as Float64Array;
        const rowIm = im[y] as Float64Array;
        for (let x = 0; x < size; ++x)
          rowRe[x] = ((plane[(y0 + y) * width + x0 + x] as number) - mean) * (window[x] as number) * (window[y] as number);
        rowIm.fill(0);
        fft(rowRe, rowIm);
      }
      for (let x = 0; x < size; ++x) {
        for (let y = 0; y < size; ++y) {
          columnRe[y] = (re[y] as Float64Array)[x] as number;
          columnIm[y] = (im[y] as Float64Array)[x] as number;
        }
        fft(columnRe, columnIm);
        for (let y = 0; y < size; ++y) {
          const ring = Math.round(Math.hypot(Math.min(x, size - x), Math.min(y, size - y)));
          if (ring < 1 || ring >= size / 2) continue;
          rings[ring] = (rings[ring] as number) + ((columnRe[y] as number) ** 2 + (columnIm[y] as number) ** 2) / energy;
          counts[ring] = (counts[ring] as number) + 1;
        }
      }
    }
  return [...rings].map((sum, i) => ({frequency: i / size, power: sum / (counts[i] || 1)})).slice(1);
}
