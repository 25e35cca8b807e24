// The curves of all runs, one over the other, with the values under the pointer.

const QUANTITIES = {
  energy_percent: ["mean energy (% of the optimum)", "energy"],
  movement_percent: ["mean movement (% of the optimal diagonal)", "movement"],
  energy_mean: ["mean energy of a cell, in the scene’s norm and order", "mean energy"],
  energy_max: ["largest energy of a cell, in the scene’s norm and order", "largest energy"],
  movement_mean: ["mean movement (L)", "mean movement"],
  movement_max: ["largest movement (L)", "largest movement"],
};
const ACROSS = { iteration: "iteration", evaluations: "energy evaluations per site", seconds: "wall time (s)" };
const DASHES = ["", "7 4", "2 3"];
/// The ratio of largest to least value from which movement is drawn on a logarithmic scale.
const LOGARITHMIC_FROM = 20;
/// The same of energies above 100 %, and the least of these.
const ENERGY_LOGARITHMIC_FROM = 3;
const LEAST_EXCESS = 1e-6;
/// Smaller movements (%) are rounding noise.
const LEAST_MOVEMENT = 1e-12;

class Curves {
  constructor(data, home) {
    this.runs = data.runs.filter((run) => run.records.iteration.length > 0);
    this.across = "iteration";
    this.place = null;
    const choice = element("select", { id: "across", change: (event) => {
      this.across = event.target.value;
      this.draw();
    } }, ...Object.entries(ACROSS).map(([key, name]) => element("option", { value: key }, name)));
    this.plots = ["energy_percent", "movement_percent"].map((quantity) => new CurvePlot(this, quantity));
    home.append(
      element("div", { class: "plots" }, ...this.plots.map((plot) => plot.node)),
      element("div", { class: "row controls" }, labelled("Across", choice),
        element("button", { type: "button", id: "save-curves", click: () => this.save() }, "Save as CSV")),
      element("p", { class: "hint" }, "Point, touch, or use the arrow keys on a diagram to read values; a click holds them."),
      ...data.runs.filter((run) => run.record_count > run.records.iteration.length).map((run) => element("p", { class: "hint" },
        `${run.name}: ${countText(run.records.iteration.length)} of ${countText(run.record_count)} records, among them the extremes.`)));
    new ResizeObserver(() => this.draw()).observe(home);
    this.draw();
  }

  draw() {
    for (const plot of this.plots) plot.draw();
  }

  visible() {
    return this.runs.filter((run) => !run.isHidden);
  }

  /// Reads all curves at a place across, or with null at none.
  read(place) {
    this.place = place;
    for (const plot of this.plots) plot.mark();
  }

  /// The places across of all records of visible runs, in order.
  places() {
    return [...new Set(this.visible().flatMap((run) => run.records[this.across]))].sort((a, b) => a - b);
  }

  step(way) {
    const places = this.places();
    if (places.length === 0) return;
    const now = this.place === null ? (way > 0 ? -1 : places.length) : nearest(places, this.place);
    this.read(places[clamp(now + way, 0, places.length - 1)]);
  }

  save() {
    const keys = ["iteration", "evaluations", "seconds", ...Object.keys(QUANTITIES)];
    const quoted = (name) => `"${name.replaceAll('"', '""')}"`;
    const rows = this.runs.flatMap(({ name, records }) => records.iteration.map((_, k) =>
      [quoted(name), ...keys.map((key) => records[key][k])].join(",")));
    save("curves.csv", new Blob([[["run", ...keys].join(","), ...rows, ""].join("\n")], { type: "text/csv" }));
  }
}

/// The place in a sorted list of the number nearest to `value`.
function nearest(list, value) {
  let [low, high] = [0, list.length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low > 0 && value - list[low - 1] <= list[low] - value ? low - 1 : low;
}

class CurvePlot {
  constructor(curves, quantity) {
    this.curves = curves;
    this.quantity = quantity;
    this.isLogarithmic = null;
    this.picture = drawing("svg", { class: "plot", tabindex: 0, role: "img" });
    this.tip = element("div", { class: "tip", hidden: true });
    this.live = element("div", { class: "unseen", "aria-live": "polite" });
    const choice = element("select", { "aria-label": "quantity", change: (event) => {
      this.quantity = event.target.value;
      this.isLogarithmic = null;
      this.draw();
    } }, ...Object.entries(QUANTITIES).map(([key, [name]]) => element("option", { value: key, selected: key === quantity }, name)));
    this.box = element("input", { type: "checkbox", change: () => {
      this.isLogarithmic = this.box.checked;
      this.draw();
    } });
    this.boxText = element("span", {}, "logarithmic");
    this.node = element("div", { class: "plot-place" },
      element("div", { class: "row" }, choice, element("label", { class: "check" }, this.box, this.boxText)),
      element("div", { class: "plot-frame" }, this.picture, this.tip), this.live);
    this.listen();
  }

  isPercent() {
    return this.quantity === "energy_percent";
  }

  /// The points [x, y] of a run that the axes can show. On a logarithmic scale energy is what it has above 100 %.
  points(run) {
    const { records } = run;
    const [xs, ys] = [records[this.curves.across], records[this.quantity]];
    const points = xs.map((x, k) => [x, this.isMade(records, k) ? this.height(ys[k]) : NaN]);
    return points.filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y) && (!this.log || y > 0));
  }

  /// Whether a record has the quantity: no move leads to the first.
  isMade(records, k) {
    return !this.quantity.startsWith("movement") || records.iteration[k] > 0;
  }

  height(value) {
    if (this.log && this.isPercent()) return value - 100 < LEAST_EXCESS ? NaN : value - 100;
    return this.log && this.quantity === "movement_percent" && value < LEAST_MOVEMENT ? NaN : value;
  }

  /// Whether the vertical scale is logarithmic unless somebody chooses, as in src/plot/convergence.rs.
  wantsLog() {
    if (this.isPercent() && !this.curves.visible().some((run) => run.asymptotic)) {
      const [low, high] = extent(this.curves.visible().flatMap((run) => run.records.energy_percent));
      return high - 100 > ENERGY_LOGARITHMIC_FROM * (Math.max(low, 100 + LEAST_EXCESS) - 100);
    }
    if (!this.quantity.startsWith("movement")) return false;
    const all = this.curves.runs.flatMap((run) => run.records[this.quantity].filter((y) => y > LEAST_MOVEMENT));
    return extent(all)[1] > LOGARITHMIC_FROM * extent(all)[0];
  }

  range(all) {
    let [low, high] = extent(all);
    if (!(low <= high)) return this.log ? [1, 10] : [0, 1];
    if (this.log) return high > low ? [low / 1.15, high * 1.15] : [low / 2, high * 2];
    if (this.isPercent() && low > 100 && low - 100 < high - low) low = 100;
    if (this.quantity.startsWith("movement")) low = 0;
    const margin = 0.04 * (high - low) || 0.05 * Math.abs(high) || 1;
    return [low === 0 ? 0 : low - margin, high + margin];
  }

  draw() {
    this.log = this.isLogarithmic ?? this.wantsLog();
    this.box.checked = this.log;
    this.boxText.textContent = this.isPercent() ? "logarithmic above 100 %" : "logarithmic";
    const width = Math.max(260, this.picture.parentNode.clientWidth);
    const height = clamp(Math.round(0.62 * width), 220, 380);
    this.frame = { left: 62, right: width - 12, top: 10, bottom: height - 42 };
    const curves = this.curves.visible().map((run) => ({ run, points: this.points(run) }));
    this.ys = this.range(curves.flatMap(({ points }) => points.map(([, y]) => y)));
    const last = extent(this.curves.visible().flatMap((run) => run.records[this.curves.across]))[1];
    this.xs = [0, last > 0 ? last : 1];
    this.cross = drawing("g", {});
    this.picture.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.picture.setAttribute("height", height);
    this.picture.setAttribute("aria-label", `${QUANTITIES[this.quantity][0]} over ${ACROSS[this.curves.across]}; arrow keys read values`);
    this.picture.replaceChildren(...this.grid(width, height), ...this.optimum(), ...curves.map((curve) => this.curve(curve)), this.cross);
    this.mark();
  }

  x(value) {
    const { left, right } = this.frame;
    return left + ((right - left) * (value - this.xs[0])) / (this.xs[1] - this.xs[0]);
  }

  y(value) {
    const { top, bottom } = this.frame;
    const of = this.log ? Math.log10 : (number) => number;
    const [low, high] = this.ys.map(of);
    return bottom - ((bottom - top) * (of(value) - low)) / (high - low);
  }

  grid(width, height) {
    const { left, right, top, bottom } = this.frame;
    const across = ticks(...this.xs, Math.max(2, (right - left) / 80), this.curves.across === "iteration" ? 1 : 0).flatMap((value) => [
      drawing("line", { class: "grid", x1: this.x(value), x2: this.x(value), y1: top, y2: bottom }),
      drawing("text", { x: this.x(value), y: bottom + 16, "text-anchor": "middle" }, numberText(value)),
    ]);
    const up = this.log ? decades(...this.ys, (bottom - top) / 34) : ticks(...this.ys, (bottom - top) / 44);
    const rows = up.flatMap((value) => [
      drawing("line", { class: "grid", x1: left, x2: right, y1: this.y(value), y2: this.y(value) }),
      drawing("text", { x: left - 7, y: this.y(value) + 4, "text-anchor": "end" },
        numberText(this.log && this.isPercent() ? 100 + value : value, this.log && this.isPercent() ? 9 : 5)),
    ]);
    return [...across, ...rows,
      drawing("rect", { class: "frame", x: left, y: top, width: right - left, height: bottom - top }),
      drawing("text", { x: 0.5 * (left + right), y: height - 6, "text-anchor": "middle" }, ACROSS[this.curves.across])];
  }

  optimum() {
    if (!this.isPercent() || this.log || this.ys[0] > 100 || this.ys[1] < 100) return [];
    const { left, right } = this.frame;
    const kinds = new Set(this.curves.visible().map((run) => run.asymptotic));
    const name = kinds.size > 1 ? "optimum of each run" : kinds.has(true) ? "asymptotic optimum" : "optimum";
    return [
      drawing("line", { class: "optimum", x1: left, x2: right, y1: this.y(100), y2: this.y(100) }),
      drawing("text", { class: "small", x: right - 5, y: this.y(100) - 5, "text-anchor": "end" }, name),
    ];
  }

  curve({ run, points }) {
    const style = { stroke: run.color, "stroke-dasharray": run.dash };
    if (points.length === 1) {
      return drawing("circle", { cx: this.x(points[0][0]), cy: this.y(points[0][1]), r: 3, fill: run.color });
    }
    let last = [-Infinity, 0];
    const kept = points.map(([x, y]) => [this.x(x), this.y(y)]).filter((point, k) => {
      const isSeen = Math.max(Math.abs(point[0] - last[0]), Math.abs(point[1] - last[1])) > 0.25 || k === points.length - 1;
      if (isSeen) last = point;
      return isSeen;
    });
    const path = kept.map(([x, y], k) => `${k === 0 ? "M" : "L"}${x.toFixed(2)} ${y.toFixed(2)}`).join("");
    return drawing("path", { class: "curve", d: path, ...style });
  }

  /// Marks the place that is read, with the values of all runs.
  mark() {
    const { place, across } = this.curves;
    this.cross.replaceChildren();
    this.tip.hidden = place === null;
    if (place === null) return;
    const { top, bottom, left, right } = this.frame;
    this.cross.append(drawing("line", { class: "cross", x1: this.x(place), x2: this.x(place), y1: top, y2: bottom }));
    const rows = this.curves.visible().map((run) => {
      const k = nearest(run.records[across], place);
      const x = run.records[across][k];
      const value = this.isMade(run.records, k) ? run.records[this.quantity][k] : null;
      const y = value === null ? NaN : this.height(value);
      if (Number.isFinite(y) && (!this.log || y > 0)) {
        this.cross.append(drawing("circle", { cx: this.x(x), cy: this.y(y), r: 3.5, fill: run.color }));
      }
      const away = x === place ? "" : ` (at ${numberText(x)})`;
      return [element("i", { style: `background:${run.color}` }), `${run.name}: ${numberText(value, 7)}${away}`];
    });
    const head = `${ACROSS[across]} ${numberText(place)}`;
    this.tip.replaceChildren(element("b", {}, head), ...rows.map((row) => element("span", {}, ...row)));
    const share = (this.x(place) - left) / (right - left);
    const scale = this.picture.clientWidth / (right + 12) || 1;
    this.tip.style.left = share < 0.5 ? `${(this.x(place) + 12) * scale}px` : "auto";
    this.tip.style.right = share < 0.5 ? "auto" : `${(right + 24 - this.x(place)) * scale}px`;
    this.live.textContent = document.activeElement === this.picture ? `${head}; ${rows.map((row) => row[1]).join("; ")}` : "";
  }

  listen() {
    const { picture, curves } = this;
    const read = (event) => {
      const box = picture.getBoundingClientRect();
      const x = ((event.clientX - box.left) * (this.frame.right + 12)) / box.width;
      const { left, right } = this.frame;
      const places = curves.places();
      if (places.length === 0) return;
      const wanted = this.xs[0] + ((this.xs[1] - this.xs[0]) * (x - left)) / (right - left);
      curves.read(places[nearest(places, wanted)]);
    };
    picture.addEventListener("pointermove", (event) => {
      if (!curves.isHeld) read(event);
    });
    picture.addEventListener("pointerdown", (event) => {
      curves.isHeld = event.pointerType !== "touch" && !curves.isHeld;
      read(event);
    });
    picture.addEventListener("pointerleave", (event) => {
      if (!curves.isHeld && event.pointerType !== "touch" && document.activeElement !== picture) curves.read(null);
    });
    picture.addEventListener("keydown", (event) => {
      const far = event.shiftKey ? 10 : 1;
      const way = { ArrowRight: far, ArrowLeft: -far, Home: -Infinity, End: Infinity }[event.key];
      if (event.key === "Escape") {
        curves.isHeld = false;
        curves.read(null);
      } else if (way !== undefined) curves.step(way);
      else return;
      event.preventDefault();
    });
  }
}

/// The least and the greatest of numbers.
function extent(numbers) {
  return numbers.reduce(([low, high], number) => [Math.min(low, number), Math.max(high, number)], [Infinity, -Infinity]);
}
