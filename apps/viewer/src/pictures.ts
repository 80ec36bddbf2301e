// SPDX-License-Identifier: Apache-2.0
// The pictures of a report, decoded when they are looked at.
import {fromBase64, inflate, unpack} from "./codec";
import type {Format, PictureInfo} from "./data";

// Linear RGB, interleaved. scaleX * scaleY values for each display pixel.
export interface Light {
  width: number; // in values
  height: number;
  scaleX: number;
  scaleY: number;
  rgb: Float32Array;
}
export interface Picture {
  index: number;
  info: PictureInfo;
  pixels: Light; // a value for each display pixel
  cells: Light; // as stored; the same as pixels for ordinary pictures
  isExact: boolean; // float data, not its 8-bit stand-in
  note: string; // what there is to say of it, such as that its float data was not found
}

declare global {
  interface Window {
    triadPicture?: (index: number, base64: string) => void;
  }
}

export function averaged(light: Light): Light {
  const {scaleX, scaleY} = light;
  if (scaleX === 1 && scaleY === 1) return light;
  const width = Math.floor(light.width / scaleX);
  const height = Math.floor(light.height / scaleY);
  const rgb = new Float32Array(3 * width * height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x)
      for (let c = 0; c < 3; ++c) {
        let sum = 0;
        for (let j = 0; j < scaleY; ++j)
          for (let i = 0; i < scaleX; ++i)
            sum += light.rgb[3 * ((y * scaleY + j) * light.width + x * scaleX + i) + c] as number;
        rgb[3 * (y * width + x) + c] = sum / (scaleX * scaleY);
      }
  return {width, height, scaleX: 1, scaleY: 1, rgb};
}

// Scripts may be loaded from where the page lies, even from disk, where fetch() is not allowed.
function loadScript(index: number, path: string): Promise<string> {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    window.triadPicture = (which, base64) => {
      if (which === index) resolve(base64);
    };
    script.onerror = () => reject(new Error(`${path} is not beside this page`));
    script.onload = () => {
      script.remove();
      reject(new Error(`${path} holds no picture ${index}`)); // has no effect once resolved
    };
    script.src = path.split("/").map(encodeURIComponent).join("/");
    document.head.append(script);
  });
}

export class PictureStore {
  private readonly kept = new Map<number, Promise<Picture>>();
  private queue: Promise<unknown> = Promise.resolve(); // side files one at a time: they share a callback

  constructor(private readonly infos: PictureInfo[]) {}

  // Few are kept: a megapixel takes 12 MB.
  get(index: number): Promise<Picture> {
    const known = this.kept.get(index);
    if (known) {
      this.kept.delete(index);
      this.kept.set(index, known);
      return known;
    }
    const made = this.load(index);
    this.kept.set(index, made);
    made.catch(() => this.kept.delete(index));
    const oldest = this.kept.keys().next().value;
    if (this.kept.size > 12 && oldest !== undefined) this.kept.delete(oldest);
    return made;
  }

  // What the page itself holds, at once: 8-bit values, where the float data is beside it.
  preview(index: number): Promise<Picture> {
    const info = this.infos[index];
    if (!info?.side || this.kept.has(index)) return this.get(index);
    return this.decode(index, info, this.embedded(index), info.format, "loading float data …");
  }

  private async load(index: number): Promise<Picture> {
    const info = this.infos[index];
    if (!info) throw new Error(`there is no picture ${index}`);
    if (info.side) {
      const waiting = this.queue.then(() => loadScript(index, info.side));
      this.queue = waiting.catch(() => undefined);
      try {
        return await this.decode(index, info, await waiting, info.sideFormat, "");
      } catch (error) {
        const why = error instanceof Error ? error.message : String(error);
        return this.decode(index, info, this.embedded(index), info.format, `8-bit values only: ${why}`);
      }
    }
    return this.decode(index, info, this.embedded(index), info.format, "");
  }

  private embedded(index: number): string {
    const text = document.getElementById(`triad-picture-${index}`)?.textContent;
    if (!text) throw new Error(`picture ${index} is missing from this page`);
    return text;
  }

  private async decode(index: number, info: PictureInfo, text: string, format: Format, note: string): Promise<Picture> {
    const rgb = unpack(await inflate(fromBase64(text)), format, info.width * info.height);
    const cells = {width: info.width, height: info.height, scaleX: info.cells[0], scaleY: info.cells[1], rgb};
    return {index, info, cells, pixels: averaged(cells), isExact: format !== "u8", note};
  }
}
