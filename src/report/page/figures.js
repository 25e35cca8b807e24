// The figures of the runs before and after as a table, and their scenes as JSON.

/// Keys of `initial` and `final`, their words in space and in the plane, and a factor.
const FIGURES = [
  ["sites", "sites", "sites"],
  ["domain_volume", "volume of the domain (L³)", "area of the domain (L²)"],
  ["volume_sum", "sum of the cells’ volumes (L³)", "sum of the cells’ areas (L²)"],
  ["energy_percent", "mean energy (% of the optimum)", "mean energy (% of the optimum)"],
  ["energy_percent_l2", "… of L2 cells", "… of L2 cells"],
  ["energy_percent_linf", "… of L∞ cells", "… of L∞ cells"],
  ["energy_mean", "mean energy of a cell", "mean energy of a cell"],
  ["energy_max", "largest energy of a cell", "largest energy of a cell"],
  ["cubeness", "cubeness", "squareness"],
  ["six_facet_fraction", "six-facet cells (%)", "four-sided cells (%)", 100],
  ["axis_aligned_area", "share of axis-aligned area", "share of axis-aligned sides"],
  ["volume_sd", "standard deviation of volumes (relative)", "standard deviation of areas (relative)"],
  ["tied_volume", "share of volume equally far from several sites", "share of area equally far from several sites"],
];

function dimensionOf({ run }) {
  return run.scene.dimension ?? 3;
}

function figuresTable(runs) {
  const dimensions = new Set(runs.map(dimensionOf));
  const words = ([, inSpace, inPlane]) => {
    return dimensions.size === 1 && dimensions.has(2) ? inPlane : inSpace;
  };
  const value = (part, key, factor) => (part && part[key] !== undefined ? numberText(part[key] * factor) : "–");
  const rows = FIGURES.filter(([key]) => runs.some(({ run }) => [run.initial, run.final].some((part) => part?.[key] !== undefined)))
    .map((figure) => {
      const [key, , , factor = 1] = figure;
      const cells = runs.flatMap(({ run }) => [value(run.initial, key, factor), value(run.final, key, factor)]);
      return element("tr", { "data-key": key }, element("th", { scope: "row" }, words(figure)), ...cells.map((text) => element("td", {}, text)));
    });
  const plain = [
    ["facets: cells, at the end", ({ run }) => histogramText(run.final?.facet_histogram)],
    ["iterations", ({ records }) => (records.iteration.length > 0 ? String(records.iteration.at(-1)) : "–")],
    ["ended by", ({ run }) => run.ended ?? "not ended"],
    ["time (s)", ({ run }) => numberText(run.seconds, 4)],
    ["threads", ({ run }) => String(run.threads)],
    ["version", ({ run }) => run.version],
  ].map(([name, text]) => element("tr", {}, element("th", { scope: "row" }, name),
    ...runs.map((run) => element("td", { colspan: 2, class: "both" }, text(run)))));
  const heads = runs.map((run) => element("th", { colspan: 2, scope: "colgroup", class: "group" }, swatch(run), run.name));
  const parts = runs.flatMap(() => ["initial", "final"]).map((name) => element("th", { scope: "col" }, name));
  const remark = dimensions.size === 1 ? null
    : element("p", { class: "hint" }, "Of runs in the plane read area for volume, L² for L³, square for cube, side for facet, four for six.");
  return element("div", {}, remark, element("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "figures" },
    element("table", {}, element("thead", {}, element("tr", {}, element("td", {}), ...heads), element("tr", {}, element("td", {}), ...parts)),
      element("tbody", {}, ...rows, ...plain))));
}

function histogramText(histogram) {
  if (!histogram) return "–";
  return Object.entries(histogram).sort((one, other) => one[0] - other[0]).map(([facets, cells]) => `${facets}:\u00a0${cells}`).join(", ");
}

/// A run's line as in the curves.
function swatch(run) {
  return drawing("svg", { class: "swatch", viewBox: "0 0 26 10", "aria-hidden": "true" },
    drawing("line", { x1: 1, x2: 25, y1: 5, y2: 5, stroke: run.color, "stroke-width": 3, "stroke-dasharray": run.dash }));
}

function sceneDetails(run, isOpen) {
  const text = JSON.stringify(run.run.scene, null, 2);
  return element("details", { open: isOpen }, element("summary", {}, swatch(run), run.name), element("pre", { tabindex: 0 }, text));
}
