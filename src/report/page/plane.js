// Cells in a plane, drawn on a canvas: those of runs in the plane, and sections where there is no WebGL.

/// What is left free below the cells, in pixels, for axes and a scale.
const STRIP = 56;

class PlaneView {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.chosen = -1;
    this.outlines = true;
    this.patches = [];
    this.frame = [[0, 0], [1, 1]];
    this.home();
  }

  /// Patches { cell, loops, rims, color, dot } in a frame [[u, v], [u, v]], and the names of its axes.
  show(patches, frame, names) {
    this.patches = patches;
    this.frame = frame;
    this.names = names;
    for (const patch of patches) {
      const all = patch.loops.flat();
      patch.box = [0, 1].map((axis) => [Math.min(...all.map((p) => p[axis])), Math.max(...all.map((p) => p[axis]))]);
    }
    this.draw();
  }

  size() {
    return [this.canvas.clientWidth || 1, this.canvas.clientHeight || 1];
  }

  scale() {
    const [width, height] = this.size();
    const lengths = [0, 1].map((axis) => this.frame[1][axis] - this.frame[0][axis] || 1);
    return 0.96 * this.zoom * Math.min(width / lengths[0], (height - STRIP) / lengths[1]);
  }

  /// The pixel at which the middle of the frame lies.
  middle() {
    const [width, height] = this.size();
    return [0.5 * width + this.pan[0], 0.5 * (height - STRIP) + 8 - this.pan[1]];
  }

  /// From lengths of the domain to pixels of the page.
  place([u, v]) {
    const [scale, [x, y]] = [this.scale(), this.middle()];
    const middle = [0, 1].map((axis) => 0.5 * (this.frame[0][axis] + this.frame[1][axis]));
    return [x + scale * (u - middle[0]), y - scale * (v - middle[1])];
  }

  draw() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.drawNow();
    });
  }

  drawNow() {
    const { canvas, context } = this;
    const [width, height] = this.size();
    const fineness = Math.min(window.devicePixelRatio || 1, 3);
    [canvas.width, canvas.height] = [width, height].map((length) => Math.round(length * fineness));
    context.setTransform(fineness, 0, 0, fineness, 0, 0);
    context.clearRect(0, 0, width, height);
    const side = this.scale() * Math.sqrt(this.area() / Math.max(this.patches.length, 1));
    const rimWidth = clamp(0.02 * side, 0.2, 1.2);
    context.lineJoin = "round";
    context.lineCap = "round";
    const path = (lines, isClosed) => {
      context.beginPath();
      for (const line of lines) {
        line.forEach((point, k) => (k === 0 ? context.moveTo(...this.place(point)) : context.lineTo(...this.place(point))));
        if (isClosed) context.closePath();
      }
    };
    for (const patch of this.patches) {
      const color = patch.cell === this.chosen ? patch.color.map((part) => Math.round(0.5 * (part + 255))) : patch.color;
      context.fillStyle = webColor(color);
      context.strokeStyle = context.fillStyle;
      context.lineWidth = 0.7;
      path(patch.loops, true);
      context.fill("evenodd");
      // No seam shows between parts of a cell.
      if (patch.loops.length > 1 || !this.outlines) context.stroke();
    }
    context.strokeStyle = "#222";
    context.lineWidth = rimWidth;
    for (const patch of this.outlines ? this.patches : []) {
      path(patch.rims, false);
      context.stroke();
    }
    const radius = clamp(0.05 * side, 0.4, 3);
    for (const patch of this.patches) {
      if (!patch.dot || side < 6) continue;
      context.beginPath();
      context.arc(...this.place(patch.dot), radius, 0, 2 * Math.PI);
      context.fillStyle = luma(patch.color) > 110 ? "#222" : "#fff";
      context.fill();
    }
    this.onDraw?.();
  }

  area() {
    return this.patches.reduce((sum, { loops }) => sum + loops.reduce((part, loop) => part + loopArea(loop), 0), 0);
  }

  cellAt(x, y) {
    const [scale, middle] = [this.scale(), this.middle()];
    const point = [x - middle[0], middle[1] - y].map((length, axis) =>
      0.5 * (this.frame[0][axis] + this.frame[1][axis]) + length / scale);
    const within = (box) => box.every(([low, high], axis) => point[axis] >= low && point[axis] <= high);
    const holds = ({ loops }) => loops.filter((loop) => isInside(point, loop)).length % 2 === 1;
    return this.patches.find((patch) => within(patch.box) && holds(patch))?.cell ?? -1;
  }

  /// Where nothing can be turned, turning moves.
  turn(right, up) {
    this.move(right, up);
  }

  move(right, down) {
    this.pan = [this.pan[0] + right, this.pan[1] - down];
    this.draw();
  }

  magnify(factor, [x, y] = this.size().map((length) => 0.5 * length)) {
    const [width, height] = this.size();
    const zoom = clamp(this.zoom * factor, 0.2, 400);
    const change = zoom / this.zoom;
    const arm = [x - 0.5 * width, 0.5 * (height - STRIP) + 8 - y];
    this.pan = this.pan.map((length, k) => arm[k] + change * (length - arm[k]));
    this.zoom = zoom;
    this.draw();
  }

  home() {
    this.zoom = 1;
    this.pan = [0, 0];
    this.draw();
  }

  compass() {
    const axes = [0, 1, 2].map((axis) => {
      const place = (this.names ?? [0, 1]).indexOf(axis);
      return place < 0 ? null : [[1, 0], [0, -1]][place];
    });
    return { scale: this.scale(), axes };
  }
}
