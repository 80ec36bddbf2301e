// SPDX-License-Identifier: Apache-2.0
// Light or dark: as the system has it, or as the reader wants it.
import {byId} from "./dom";

const kNames = ["auto", "light", "dark"];

export function setUpTheme(): void {
  const button = byId("theme");
  let theme = "auto";
  try {
    theme = localStorage.getItem("triad-theme") ?? "auto";
  } catch {
    // Pages from disk may have no storage.
  }
  const apply = (): void => {
    document.documentElement.dataset["theme"] = theme;
    button.textContent = `Theme: ${theme}`;
    window.dispatchEvent(new Event("resize")); // canvases take their colours anew
  };
  button.addEventListener("click", () => {
    theme = kNames[(kNames.indexOf(theme) + 1) % kNames.length] as string;
    try {
      localStorage.setItem("triad-theme", theme);
    } catch {
      // As above.
    }
    apply();
  });
  apply();
}
