// SPDX-License-Identifier: Apache-2.0
// Making elements. Text is always set as text, so that names in a report cannot become markup.

type Child = Node | string;
type Properties = Record<string, string | number | boolean | ((event: Event) => void)>;

// Functions listen ("click", "input"), true sets an empty attribute, false leaves it out.
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, properties: Properties = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties))
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value !== false) element.setAttribute(name, value === true ? "" : String(value));
  element.append(...children);
  return element;
}

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element '${id}'`);
  return element as T;
}

export function select(
  id: string, label: string, options: [string, string][], value: string, change: (value: string) => void,
): {element: HTMLElement; box: HTMLSelectElement} {
  const box = h("select", {id, change: () => change(box.value)});
  for (const [key, text] of options) box.append(h("option", {value: key, selected: key === value}, text));
  return {element: h("label", {class: "field"}, h("span", {}, label), box), box};
}

export function number(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e7 || size < 1e-4 ? value.toExponential(digits - 1).replace(/\.?0*e/, "e") : Number(value.toPrecision(digits)).toString();
  return text.replace("-", "−");
}

export function seconds(value: number): string {
  return value < 1e-3 ? `${number(value * 1e6, 3)} µs` : value < 1 ? `${number(value * 1e3, 3)} ms` : `${number(value, 3)} s`;
}

// A failure that the reader sees, in place of a page that silently does nothing.
export function showError(error: unknown): void {
  const box = document.getElementById("errors");
  const text = error instanceof Error ? error.message : String(error);
  if (!box || [...box.children].some((line) => line.textContent === text)) return;
  box.hidden = false;
  box.append(h("p", {}, text));
}

export function guarded<A extends unknown[]>(work: (...args: A) => void | Promise<void>): (...args: A) => void {
  return (...args) => {
    try {
      void Promise.resolve(work(...args)).catch(showError);
    } catch (error) {
      showError(error);
    }
  };
}
