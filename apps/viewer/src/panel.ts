// SPDX-License-Identifier: Apache-2.0
// A panel's light from the values of a picture on it, cell by cell, as libcore/display/emission.hpp has it.
import type {Layout} from "./data";

// What one emitter adds to one cell of the tile.
export interface Term {
  dx: number; // from the cell's own pixel to the one that drives the emitter
  dy: number;
  channel: number;
  light: [number, number, number];
}
export interface Panel {
  layout: Layout;
  columns: number; // cells of a tile
  rows: number;
  terms: Term[][]; // [row * columns + column]
  most: number; // terms of a cell
  brightest: number; // the most light of a cell, at least 1: what its light is divided by to be shown
}

const modulo = (a: number, n: number): number => ((a % n) + n) % n;

export function makePanel(layout: Layout): Panel {
  const [cellsX, cellsY] = layout.cells;
  const columns = layout.tile[0] * cellsX;
  const rows = layout.tile[1] * cellsY;
  const terms: Term[][] = Array.from({length: columns * rows}, () => []);
  for (const emitter of layout.emitters)
    for (const [x, y, share] of emitter.cells) {
      const column = modulo(x, columns);
      const row = modulo(y, rows);
      const scale = share * cellsX * cellsY;
      terms[row * columns + column]?.push({
        // An emitter whose cells reach into the next tile is driven by a pixel of its own tile.
        dx: ((column - x) / columns) * layout.tile[0] + emitter.pixel[0] - Math.floor(column / cellsX),
        dy: ((row - y) / rows) * layout.tile[1] + emitter.pixel[1] - Math.floor(row / cellsY),
        channel: emitter.channel,
        light: [emitter.primary[0] * scale, emitter.primary[1] * scale, emitter.primary[2] * scale],
      });
    }
  const panel = {layout, columns, rows, terms, most: Math.max(...terms.map((t) => t.length)), brightest: 1};
  const rgb: [number, number, number] = [0, 0, 0];
  // Not all at once: what is derived as white takes the others' place.
  for (let on = 1; on < 8; ++on)
    for (let y = 0; y < rows; ++y)
      for (let x = 0; x < columns; ++x) {
        cellLight(panel, x, y, (_x, _y, channel) => (on >> channel) & 1, rgb);
        panel.brightest = Math.max(panel.brightest, ...rgb);
      }
  return panel;
}

// The drive of a display pixel's channel 0..2, in [0, 1].
export type Drive = (x: number, y: number, channel: number) => number;

// The light of cell (x, y), counted from the picture's upper left one; white at 1.
export function cellLight(panel: Panel, x: number, y: number, drive: Drive, out: [number, number, number]): void {
  const [cellsX, cellsY] = panel.layout.cells;
  const px = Math.floor(x / cellsX);
  const py = Math.floor(y / cellsY);
  out[0] = out[1] = out[2] = 0;
  for (const term of panel.terms[modulo(y, panel.rows) * panel.columns + modulo(x, panel.columns)] ?? []) {
    const qx = px + term.dx;
    const qy = py + term.dy;
    let value = term.channel < 3 ? drive(qx, qy, term.channel) : 0;
    if (panel.layout.derivesWhite) {
      const white = Math.min(drive(qx, qy, 0), drive(qx, qy, 1), drive(qx, qy, 2));
      value = term.channel < 3 ? value - white : white;
    }
    for (let i = 0; i < 3; ++i) (out[i] as number) += value * (term.light[i] as number);
  }
}
