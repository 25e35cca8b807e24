// The cells of the runs with their controls: which run, its colors, its cut, the cell under the pointer.

const AXES = ["x", "y", "z"];
const AXIS_COLORS = ["#d03a3a", "#2e9e46", "#3b6fd6"];
const CUT_STEPS = 1000;

class CellViewer {
  constructor(data, home) {
    this.data = data;
    this.home = home;
    this.runs = data.runs.map((run, number) => ({ ...run, number })).filter((run) => run.cells);
    this.loaded = new Map();
    this.state = {
      cut: remembered.get("cut") ?? "",
      place: Number(remembered.get("place") ?? 500),
      keepsBelow: remembered.get("side") !== "above",
      isThrough: remembered.get("mode") === "through",
      color: remembered.get("color"),
      ranges: {},
      hidesBeyond: false,
    };
    this.pinned = -1;
    this.build();
  }

  build() {
    this.canvas = element("canvas", {});
    this.overlay = drawing("svg", { class: "overlay", "aria-hidden": "true" });
    this.tip = element("div", { class: "tip", hidden: true });
    this.stage = element("div", { class: "stage", tabindex: 0, role: "application",
      "aria-label": "The cells. Arrow keys turn, with Shift move, plus and minus zoom, 0 goes back; x, y, z choose a cut, n none, brackets move it." },
    this.canvas, this.overlay, this.tip);
    this.panel = element("div", { class: "panel" });
    this.caption = element("p", { class: "caption" });
    this.message = element("p", { class: "note", hidden: true });
    this.hint = element("p", { class: "hint" });
    this.home.append(this.message, element("div", { class: "viewer" }, this.stage, this.panel), this.caption, this.hint);
    this.listen();
    new ResizeObserver(() => this.view?.draw()).observe(this.stage);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.view?.draw());
  }

  /// Shows the cells of a run, given by its place among those that have cells.
  async choose(place) {
    const run = this.runs[place] ?? this.runs[0];
    if (!this.loaded.has(run.number)) this.loaded.set(run.number, await unpackedCells(run.number, run.cells));
    this.run = run;
    this.cells = this.loaded.get(run.number);
    this.pinned = -1;
    this.takeView();
    this.buildPanel();
    this.update();
  }

  /// The view that fits the cells: in space by WebGL where there is any.
  takeView() {
    const wantsSpace = this.cells.dimension === 3 && !this.hasNoWebGl;
    if (this.view && this.view instanceof SpaceView !== wantsSpace) {
      // A canvas keeps the kind of its first context.
      const canvas = element("canvas", {});
      this.canvas.replaceWith(canvas);
      this.canvas = canvas;
      this.view = null;
    }
    if (!this.view && wantsSpace) {
      try {
        this.view = new SpaceView(this.canvas, this.data.toward);
        this.restoreCamera();
      } catch (error) {
        this.hasNoWebGl = true;
        this.message.hidden = false;
        this.message.textContent = `The cells cannot be shown in space: ${error.message}. Here is a cut through them.`;
      }
    }
    this.view ??= new PlaneView(this.canvas);
    this.view.onDraw = () => this.drawOverlay();
    if (this.view instanceof SpaceView) this.view.aim(this.cells);
    this.stage.classList.toggle("flat", !this.isInSpace());
    if (this.cells.dimension === 3 && !this.isInSpace() && this.state.cut === "") this.state.cut = "z";
    this.hint.textContent = this.hintText();
  }

  hintText() {
    const zoom = "pinch, or click and use the wheel, to zoom; click a cell to hold its values.";
    const cut = this.cells.dimension === 3 ? `, x y z ${this.isInSpace() ? "n " : ""}choose the cut, [ ] move it` : "";
    return this.isInSpace()
      ? `Drag to turn, with Shift or two fingers to move; ${zoom} Keys: arrows turn, + − zoom, 0 back${cut}.`
      : `Drag to move; ${zoom} Keys: arrows move, + − zoom, 0 back${cut}.`;
  }

  restoreCamera() {
    const [azimuth, elevation, zoom, ...pan] = (remembered.get("view") ?? "").split(",").map(Number);
    const { camera } = this.view;
    if (![azimuth, elevation, zoom].every(Number.isFinite) || pan.length !== 2) return;
    camera.look(azimuth, elevation);
    camera.zoom = clamp(zoom, 0.2, 200);
    camera.pan = pan.map((length) => (Number.isFinite(length) ? length : 0));
  }

  isInSpace() {
    return this.view instanceof SpaceView;
  }

  column() {
    return this.cells.columns.find((column) => column.name === this.state.color) ?? this.cells.columns[0];
  }

  scale() {
    const column = this.column();
    const scale = new ColorScale(this.data.palette, column);
    [scale.low, scale.high] = this.state.ranges[this.rangeKey()] ?? column.range;
    return scale;
  }

  rangeKey() {
    return `${this.run.number} ${this.column().name}`;
  }

  /// The cut in the cells' own coordinates; none where nothing is cut.
  cut() {
    const axis = AXES.indexOf(this.state.cut);
    if (axis < 0 || this.cells.dimension === 2) return null;
    const [min, max] = this.cells.bounds.map((corner) => corner[axis]);
    const at = min + (this.state.place / CUT_STEPS) * (max - min);
    // As many decimals as the slider's steps ask for.
    const decimals = clamp(Math.ceil(-Math.log10((max - min) / CUT_STEPS)), 0, 100);
    const text = Math.abs(at) < 1e15 ? String(Number(at.toFixed(decimals))).replace("-", "−") : numberText(at);
    return { axis, text, place: at - this.cells.origin[axis], keepsBelow: this.state.keepsBelow };
  }

  buildPanel() {
    const { state } = this;
    const change = (action) => (event) => {
      action(event.target);
      this.update();
    };
    const choices = this.runs.map((run, place) =>
      element("option", { value: place, selected: run === this.run }, run.name));
    const colors = this.cells.columns.map(({ name }) =>
      element("option", { value: name, selected: name === this.column().name }, name));
    this.bar = element("div", { class: "bar-place" });
    this.low = element("input", { type: "text", inputmode: "decimal", "aria-label": "low end of the colors", change: () => this.readRange() });
    this.high = element("input", { type: "text", inputmode: "decimal", "aria-label": "high end of the colors", change: () => this.readRange() });
    const parts = [
      this.runs.length > 1 ? labelled("Run", element("select", { id: "run-choice",
        change: (event) => this.choose(Number(event.target.value)) }, ...choices)) : null,
      labelled("Color", element("select", { id: "color-choice",
        change: change((choice) => { state.color = choice.value; }) }, ...colors)),
      this.bar,
      element("div", { class: "row" }, this.low, element("span", {}, "to"), this.high,
        element("button", { type: "button", click: () => {
          delete state.ranges[this.rangeKey()];
          this.update();
        } }, "reset")),
      element("label", { class: "check" }, element("input", { type: "checkbox", id: "hide-beyond", checked: state.hidesBeyond,
        change: change((box) => { state.hidesBeyond = box.checked; }) }), "hide cells beyond these"),
      element("label", { class: "check" }, element("input", { type: "checkbox", id: "outlines", checked: this.view.outlines,
        change: change((box) => { this.view.outlines = box.checked; }) }), "edges"),
    ];
    this.facts = element("dl", { class: "facts", "aria-live": "polite" });
    this.panel.replaceChildren(...parts.filter(Boolean), ...(this.cells.dimension === 3 ? this.cutControls(change) : []),
      element("button", { type: "button", id: "home", click: () => {
        this.view.home();
        this.rememberView();
      } }, "Whole view"), this.facts);
  }

  cutControls(change) {
    const { state } = this;
    const axes = this.isInSpace() ? ["", ...AXES] : AXES;
    const radio = (group, value, text, isChosen, action) => element("label", { class: "check" },
      element("input", { type: "radio", name: group, value, checked: isChosen, change: change(action) }), text);
    this.slider = element("input", { type: "range", id: "cut-place", min: 0, max: CUT_STEPS, value: state.place,
      "aria-label": "place of the cut", input: change((slider) => { state.place = Number(slider.value); }) });
    this.cutText = element("output", { for: "cut-place" });
    return [
      element("fieldset", {}, element("legend", {}, "Cut"),
        element("div", { class: "row" }, ...axes.map((axis) => radio("cut", axis, axis === "" ? "none" : axis, axis === state.cut,
          ({ value }) => { state.cut = value; }))),
        element("div", { class: "row" }, this.slider, this.cutText),
        this.isInSpace() ? element("div", { class: "row" },
          radio("mode", "whole", "whole cells", !state.isThrough, () => { state.isThrough = false; }),
          radio("mode", "through", "through cells", state.isThrough, () => { state.isThrough = true; })) : null,
        this.isInSpace() ? element("label", { class: "check" }, element("input", { type: "checkbox", id: "cut-side", checked: !state.keepsBelow,
          change: change((box) => { state.keepsBelow = !box.checked; }) }), "keep the upper side") : null),
    ];
  }

  readRange() {
    const [low, high] = [this.low, this.high].map((input) => Number(input.value.replace("−", "-").replace(",", ".")));
    if (Number.isFinite(low) && Number.isFinite(high) && low < high) this.state.ranges[this.rangeKey()] = [low, high];
    this.update();
  }

  /// Draws anew what depends on the controls, once per frame.
  update() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.updateNow();
    });
  }

  updateNow() {
    const { cells, state } = this;
    const scale = this.scale();
    const values = this.column().values;
    const colors = Array.from(values, (value) => scale.color(value));
    const shown = Uint8Array.from(values, (value) => (!state.hidesBeyond || scale.holds(value) ? 1 : 0));
    const cut = this.cut();
    if (this.isInSpace()) {
      if (cut && !state.isThrough) {
        for (let cell = 0; cell < cells.count; cell++) {
          if (cells.sites[3 * cell + cut.axis] < cut.place !== cut.keepsBelow) shown[cell] = 0;
        }
      }
      const plane = state.isThrough ? cut : null;
      this.view.show(visibleSurface(cells, shown, colors, plane), plane);
    } else {
      this.showPatches(shown, colors, cut);
    }
    this.bar.replaceChildren(element("p", {}, this.column().label), colorBar(scale));
    [this.low.value, this.high.value] = [scale.low, scale.high].map((value) => numberText(value));
    this.showCut(cut);
    const left = this.cells.dimension === 3 && !this.isInSpace() ? this.view.patches.length : shown.reduce((sum, is) => sum + is, 0);
    this.caption.textContent = this.captionText(left);
    this.rememberView();
    this.showFacts(this.pinned);
  }

  captionText(left) {
    const { count, total, selection } = this.cells;
    const all = selection ? `${countText(count)} of ${countText(total)} cells, ${selection}` : `${countText(count)} cells`;
    const hidden = left === count ? "" : `; ${countText(count - left)} hidden`;
    return `${this.run.name}: ${all}${hidden}.`;
  }

  /// The cells of a plane, or the section by the cut.
  showPatches(shown, colors, cut) {
    const { cells } = this;
    const [u, v] = cut ? planeAxes(cut.axis) : [0, 1];
    const frame = cells.bounds.map((corner) => [u, v].map((axis) => corner[axis] - cells.origin[axis]));
    const patches = [];
    for (let cell = 0; cell < cells.count; cell++) {
      if (shown[cell] === 0 || (cut && !meets(cells, cell, cut.axis, cut.place))) continue;
      const loops = cut ? sectionLoops(cells, cell, cut.axis, cut.place) : cells.facesOf[cell].map((face) => faceLoop(cells, face));
      const dot = cut ? null : [cells.sites[3 * cell], cells.sites[3 * cell + 1]];
      const rims = cut ? loops.map((loop) => [...loop, loop[0]]) : cells.facesOf[cell].flatMap((face) => faceRims(cells, face));
      if (loops.length > 0) patches.push({ cell, loops, rims, color: colors[cell], dot });
    }
    this.view.show(patches, frame, [u, v]);
  }

  showCut(cut) {
    if (!this.cutText) return;
    this.slider.disabled = !cut;
    this.cutText.textContent = cut ? `${AXES[cut.axis]} = ${cut.text}` : "";
  }

  rememberView() {
    const { state } = this;
    remember("run", this.runs.indexOf(this.run) || null);
    remember("color", this.column() === this.cells.columns[0] ? null : this.column().name);
    remember("cut", state.cut === "" ? null : state.cut);
    remember("place", state.cut === "" ? null : state.place);
    remember("side", state.keepsBelow ? null : "above");
    remember("mode", state.isThrough ? "through" : null);
    if (!this.isInSpace()) return;
    const { azimuth, elevation, zoom, pan, home } = this.view.camera;
    const isHome = azimuth === home[0] && elevation === home[1] && zoom === 1 && pan.every((length) => length === 0);
    const numbers = [azimuth, elevation, zoom, ...pan].map((number) => Number(number.toFixed(3)));
    remember("view", isHome ? null : numbers.join(","));
  }

  /// Axes and a scale on top of the picture.
  drawOverlay() {
    const { scale, axes } = this.view.compass();
    const [width, height] = this.view.size();
    this.overlay.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const length = niceLength((0.3 * Math.min(width, 500)) / scale);
    const right = width - 12;
    const left = right - length * scale;
    const at = this.isInSpace() ? [40, height - 40] : [24, height - 12];
    const arrows = axes.flatMap((way, axis) => {
      if (!way) return [];
      const end = at.map((x, k) => x + 26 * way[k]);
      const beyond = at.map((x, k) => x + 35 * way[k]);
      if (Math.hypot(...way) < 0.15) return [];
      return [
        drawing("line", { x1: at[0], y1: at[1], x2: end[0], y2: end[1], stroke: AXIS_COLORS[axis], "stroke-width": 2 }),
        drawing("text", { x: beyond[0], y: beyond[1] + 4, "text-anchor": "middle", fill: AXIS_COLORS[axis] }, AXES[axis]),
      ];
    });
    this.overlay.replaceChildren(
      drawing("path", { d: `M${left} ${height - 18} v6 H${right} v-6`, class: "scale-line" }),
      drawing("text", { x: 0.5 * (left + right), y: height - 22, "text-anchor": "middle", class: "scale-text" }, `${numberText(length)} L`),
      ...arrows);
  }

  listen() {
    const { stage } = this;
    const pointers = new Map();
    let moved = 0;
    const at = (event) => {
      const box = stage.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    stage.addEventListener("contextmenu", (event) => event.preventDefault());
    stage.addEventListener("pointerdown", (event) => {
      stage.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, at(event));
      if (pointers.size === 1) moved = 0;
      this.tip.hidden = true;
    });
    stage.addEventListener("pointermove", (event) => {
      const [now, last] = [at(event), pointers.get(event.pointerId)];
      if (!last) {
        this.point(now);
        return;
      }
      const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
      const way = now.map((x, k) => x - last[k]);
      moved += Math.hypot(...way);
      pointers.set(event.pointerId, now);
      if (other) {
        const far = (one) => Math.hypot(one[0] - other[0], one[1] - other[1]) || 1;
        this.view.magnify(far(now) / far(last), now.map((x, k) => 0.5 * (x + other[k])));
        this.view.move(0.5 * way[0], 0.5 * way[1]);
      } else if (event.shiftKey || event.buttons === 2) {
        this.view.move(...way);
      } else {
        this.view.turn(...way);
      }
    });
    const release = (event) => {
      const isClick = pointers.size === 1 && moved < 5 && event.type === "pointerup";
      pointers.delete(event.pointerId);
      if (isClick) this.pin(at(event));
      this.rememberView();
    };
    stage.addEventListener("pointerup", release);
    stage.addEventListener("pointercancel", release);
    stage.addEventListener("pointerleave", () => this.point(null));
    stage.addEventListener("wheel", (event) => {
      if (document.activeElement !== stage && !event.ctrlKey) return;
      event.preventDefault();
      this.view.magnify(Math.exp(-0.0015 * event.deltaY), at(event));
      this.rememberView();
    }, { passive: false });
    stage.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] }[event.key];
    const cut = { x: "x", y: "y", z: "z", n: "" }[event.key];
    if (arrow) {
      if (event.shiftKey) this.view.move(...arrow);
      else this.view.turn(...arrow);
    } else if (event.key === "+" || event.key === "=") this.view.magnify(1.2);
    else if (event.key === "-") this.view.magnify(1 / 1.2);
    else if (event.key === "0" || event.key === "Home") this.view.home();
    else if (cut !== undefined && this.cells.dimension === 3 && (cut !== "" || this.isInSpace())) this.setCut(cut, this.state.place);
    else if ((event.key === "[" || event.key === "]") && this.cut()) {
      this.setCut(this.state.cut, clamp(this.state.place + (event.key === "]" ? 10 : -10), 0, CUT_STEPS));
    } else return;
    event.preventDefault();
    this.rememberView();
  }

  setCut(axis, place) {
    [this.state.cut, this.state.place] = [axis, place];
    const radio = this.panel.querySelector(`input[name=cut][value="${axis}"]`);
    if (radio) radio.checked = true;
    this.slider.value = place;
    this.update();
  }

  /// Looks for the cell at a place of the stage, at the next opportunity; null leaves it.
  point(place) {
    this.pointed = place;
    if (this.isPointing) return;
    this.isPointing = true;
    requestAnimationFrame(() => {
      this.isPointing = false;
      const cell = this.pointed && this.view ? this.view.cellAt(...this.pointed) : -1;
      this.mark(cell >= 0 ? cell : this.pinned);
      this.tip.hidden = cell < 0;
      if (cell >= 0) this.showTip(cell, this.pointed);
      this.showFacts(cell >= 0 ? cell : this.pinned);
    });
  }

  pin(place) {
    this.pinned = this.view.cellAt(...place);
    this.mark(this.pinned);
    this.showFacts(this.pinned);
  }

  mark(cell) {
    if (this.view.chosen === cell) return;
    this.view.chosen = cell;
    this.view.draw();
  }

  showTip(cell, [x, y]) {
    const column = this.column();
    this.tip.textContent = `site ${this.cells.siteNumbers[cell]}: ${column.name} ${numberText(column.values[cell])}`;
    const [width] = this.view.size();
    this.tip.style.left = `${clamp(x + 14, 0, Math.max(0, width - this.tip.offsetWidth - 4))}px`;
    this.tip.style.top = `${Math.max(0, y - 34)}px`;
  }

  showFacts(cell) {
    const { columns, siteNumbers } = this.cells;
    const rows = cell < 0 ? [] : columns.filter(({ name }) => name !== "site").flatMap(({ name, values }) => [
      element("dt", {}, name), element("dd", {}, numberText(values[cell]))]);
    const head = cell < 0 ? "point at a cell, or tap it" : `site ${siteNumbers[cell]}${cell === this.pinned ? " (held)" : ""}`;
    this.facts.replaceChildren(element("dt", { class: "head" }, head), element("dd", {}), ...rows);
  }
}

/// The lines along a face in the plane but for edges between two parts of one cell.
function faceRims(cells, face) {
  const loop = faceLoop(cells, face);
  const start = cells.starts[face];
  const isLine = loop.map((_, k) => cells.smooth[start + k] === 0);
  if (isLine.every(Boolean)) return [[...loop, loop[0]]];
  return loop.map((point, k) => [point, loop[(k + 1) % loop.length]]).filter((_, k) => isLine[k]);
}

/// A face's corners in the plane.
function faceLoop({ points, corners, starts }, face) {
  const loop = [];
  for (let k = starts[face]; k < starts[face + 1]; k++) loop.push([points[3 * corners[k]], points[3 * corners[k] + 1]]);
  return loop;
}
