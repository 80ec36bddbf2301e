// SPDX-License-Identifier: Apache-2.0
// The table of runs, which is in the page without scripts too: sorting, pictures, downloads.
import type {Report} from "./data";
import {byId, h} from "./dom";

// RFC 4180.
export function toCsv(report: Report): string {
  const quote = (text: string): string => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const cell = (value: number | null | undefined): string => (typeof value === "number" ? String(value) : "");
  const head = [...report.axes, ...report.measures.flatMap((name) => [name, `${name} ±`]), "pareto", "file"];
  const rows = report.runs.map((run) => [
    ...report.axes.map((axis) => run.settings[axis] ?? ""),
    ...report.measures.flatMap((name) => [cell(run.shown[name]), cell(run.around[name])]),
    run.pareto === null ? "" : String(run.pareto),
    report.pictures[run.picture]?.file ?? "",
  ]);
  return [head, ...rows].map((row) => row.map(quote).join(",") + "\r\n").join("");
}

function save(name: string, text: string, type: string): void {
  const link = h("a", {href: URL.createObjectURL(new Blob([text], {type})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

const keyOf = (row: HTMLTableRowElement, column: number): number | string => {
  const cell = row.cells[column];
  const value = cell?.dataset["value"];
  return value === undefined ? (cell?.textContent ?? "") : Number(value);
};

// Numbers before texts; what is no number comes last either way.
export function compareKeys(a: number | string, b: number | string, sign: number): number {
  if (typeof a === "number" && typeof b === "number") {
    if (Number.isNaN(a) || Number.isNaN(b)) return Number(Number.isNaN(a)) - Number(Number.isNaN(b));
    return sign * (a - b);
  }
  return typeof a === typeof b
    ? sign * String(a).localeCompare(String(b), "en", {numeric: true})
    : typeof a === "number"
      ? -1
      : 1;
}

function makeSortable(table: HTMLTableElement): void {
  const body = table.tBodies[0];
  const heads = [...(table.tHead?.rows[0]?.cells ?? [])];
  heads.forEach((head, column) => {
    const text = head.textContent ?? "";
    head.title = `Sort by ${text}`;
    head.replaceChildren(h("button", {type: "button", class: "sort"}, text));
    // The button's clicks come here as well.
    head.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const rows = [...(body?.rows ?? [])];
      rows.sort((a, b) => compareKeys(keyOf(a, column), keyOf(b, column), down ? -1 : 1));
      body?.append(...rows);
    });
  });
}

// Says so above a table that is wider than the page.
function hintAtWidth(): void {
  for (const box of document.querySelectorAll<HTMLElement>(".scroll")) {
    const hint = h("p", {class: "note wide-hint", hidden: true}, "More columns to the right: scroll sideways →");
    box.before(hint);
    new ResizeObserver(() => (hint.hidden = box.scrollWidth <= box.clientWidth + 1)).observe(box);
  }
}

export function buildTables(report: Report, look: (picture: number) => void): void {
  for (const table of document.querySelectorAll<HTMLTableElement>("table.data")) {
    makeSortable(table);
    for (const row of table.tBodies[0]?.rows ?? []) {
      const picture = Number(row.dataset["picture"] ?? -1);
      const first = row.cells[0];
      if (picture < 0 || !first) continue;
      first.append(
        " ",
        h("button", {type: "button", class: "link", title: "Look at this picture", click: () => look(picture)}, "view"),
      );
    }
  }
  hintAtWidth();
  byId("downloads").append(
    h(
      "button",
      {type: "button", id: "save-csv", click: () => save("results.csv", toCsv(report), "text/csv")},
      "Save as CSV",
    ),
    h(
      "button",
      {
        type: "button",
        id: "save-json",
        click: () =>
          save(
            "results.json",
            JSON.stringify(
              {title: report.title, facts: report.facts, pareto: report.pareto, runs: report.runs},
              null,
              1,
            ) + "\n",
            "application/json",
          ),
      },
      "Save as JSON",
    ),
  );
}
