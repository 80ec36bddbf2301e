// SPDX-License-Identifier: Apache-2.0
// Uncompressed OpenEXR files of float RGB ("OpenEXR File Layout"), so that tests know every value.
import fs from "node:fs";

const int32 = (...values) => {
  const bytes = Buffer.alloc(4 * values.length);
  values.forEach((v, i) => bytes.writeInt32LE(v, 4 * i));
  return bytes;
};
const float32 = (...values) => {
  const bytes = Buffer.alloc(4 * values.length);
  values.forEach((v, i) => bytes.writeFloatLE(v, 4 * i));
  return bytes;
};
const attribute = (name, type, value) =>
  Buffer.concat([Buffer.from(`${name}\0${type}\0`), int32(value.length), value]);

// pixel(x, y) is [r, g, b]. `texts`: more attributes.
export function writeExr(path, width, height, pixel, texts = {}) {
  const channel = (name) => Buffer.concat([Buffer.from(`${name}\0`), int32(2, 0, 1, 1)]);
  const window = int32(0, 0, width - 1, height - 1);
  const header = Buffer.concat([
    int32(20000630, 2),
    attribute("channels", "chlist", Buffer.concat([channel("B"), channel("G"), channel("R"), Buffer.from([0])])),
    attribute("compression", "compression", Buffer.from([0])),
    attribute("dataWindow", "box2i", window),
    attribute("displayWindow", "box2i", window),
    attribute("lineOrder", "lineOrder", Buffer.from([0])),
    attribute("pixelAspectRatio", "float", float32(1)),
    attribute("screenWindowCenter", "v2f", float32(0, 0)),
    attribute("screenWindowWidth", "float", float32(1)),
    ...Object.entries(texts).map(([name, text]) => attribute(name, "string", Buffer.from(text))),
    Buffer.from([0]),
  ]);
  const line = 8 + 12 * width;
  const offsets = Buffer.alloc(8 * height);
  const lines = [];
  for (let y = 0; y < height; ++y) {
    offsets.writeBigUInt64LE(BigInt(header.length + 8 * height + y * line), 8 * y);
    const row = Array.from({length: width}, (_, x) => pixel(x, y));
    lines.push(int32(y, 12 * width), ...[2, 1, 0].map((c) => float32(...row.map((rgb) => rgb[c]))));
  }
  fs.writeFileSync(path, Buffer.concat([header, offsets, ...lines]));
}
