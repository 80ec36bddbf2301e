// SPDX-License-Identifier: Apache-2.0
// How pictures travel (apps/triad/report_pictures.cpp writes them): base64 of a zlib stream of byte planes. Channel by
// channel, the bytes of all samples from the highest to the lowest, each plane as differences along its whole length.
import type {Format} from "./data";

export const bytesOf = (format: Format): number => ({u8: 1, f16: 2, f32: 4})[format];

export function fromBase64(text: string): Uint8Array {
  // Browsers since 2025 have it, ten times as fast.
  const {fromBase64: native} = Uint8Array as {fromBase64?: (text: string) => Uint8Array};
  if (native) return native.call(Uint8Array, text.trim());
  const binary = atob(text.trim());
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

export async function inflate(bytes: Uint8Array): Promise<Uint8Array> {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export function fromHalf(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : (2 ** -14 * fraction) / 1024);
}

export function srgbToLinear(v: number): number {
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
}
export function linearToSrgb(v: number): number {
  return v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;
}

// Interleaved linear RGB of `count` pixels. 8-bit values are sRGB codes.
export function unpack(bytes: Uint8Array, format: Format, count: number): Float32Array {
  const width = bytesOf(format);
  if (bytes.length !== 3 * width * count)
    throw new Error(`a picture has ${bytes.length} bytes where ${3 * width * count} are needed`);
  const words = new Uint32Array(count);
  const floats = new Float32Array(words.buffer);
  const rgb = new Float32Array(3 * count);
  const table = new Float32Array(format === "f16" ? 65536 : 256);
  for (let i = 0; i < table.length; ++i) table[i] = format === "f16" ? fromHalf(i) : srgbToLinear(i / 255);
  let at = 0;
  for (let channel = 0; channel < 3; ++channel) {
    words.fill(0);
    for (let plane = 0; plane < width; ++plane)
      for (let i = 0, value = 0; i < count; ++i) {
        value = (value + (bytes[at++] as number)) & 255;
        words[i] = ((words[i] as number) << 8) | value;
      }
    if (format === "f32") for (let i = 0; i < count; ++i) rgb[3 * i + channel] = floats[i] as number;
    else for (let i = 0; i < count; ++i) rgb[3 * i + channel] = table[words[i] as number] as number;
  }
  return rgb;
}
