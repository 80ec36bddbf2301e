// SPDX-License-Identifier: Apache-2.0
// What is used of d3, which comes with Observable Plot and without types.
declare module "d3" {
  export function interpolateMagma(t: number): string;
  export function rgb(colour: string): {r: number; g: number; b: number};
  export interface SymbolType {
    draw(context: CanvasPath, size: number): void;
  }
  export const symbolsFill: SymbolType[];
  export function symbol(type: SymbolType, size: number): () => string | null;
}
