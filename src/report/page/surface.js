// What is seen of cells: faces between a cell that is shown and none, sections by a plane, their edges.

/// Bytes of a vertex: place (three f32), normal (three i8), color (three u8), number of the cell (three u8), each
/// filled up to four bytes.
const VERTEX_BYTES = 24;

/// Triangles with colors and cells, and lines.
class SurfaceBuffer {
  constructor() {
    this.count = 0;
    this.room(1 << 14);
    this.lines = [];
  }

  room(count) {
    const bytes = new Uint8Array(count * VERTEX_BYTES);
    if (this.bytes) bytes.set(this.bytes);
    this.bytes = bytes;
    this.floats = new Float32Array(bytes.buffer);
    this.signed = new Int8Array(bytes.buffer);
    this.capacity = count;
  }

  push(points, point, normal, color, cell) {
    if (this.count === this.capacity) this.room(2 * this.capacity);
    const word = (this.count * VERTEX_BYTES) / 4;
    const byte = this.count * VERTEX_BYTES;
    for (let axis = 0; axis < 3; axis++) {
      this.floats[word + axis] = points[3 * point + axis];
      this.signed[byte + 12 + axis] = Math.round(127 * normal[axis]);
      this.bytes[byte + 16 + axis] = color[axis];
      this.bytes[byte + 20 + axis] = ((cell + 1) >> (8 * axis)) & 255;
    }
    this.count++;
  }

  line(points, from, to) {
    for (let axis = 0; axis < 3; axis++) this.lines.push(points[3 * from + axis]);
    for (let axis = 0; axis < 3; axis++) this.lines.push(points[3 * to + axis]);
  }
}

/// The two axes of a plane across `axis`, counter-clockwise as seen from its positive end.
function planeAxes(axis) {
  return [(axis + 1) % 3, (axis + 2) % 3];
}

/// The corners of a face as triangles of places among them.
function faceTriangles(cells, face) {
  const { points, corners, starts, normals } = cells;
  const start = starts[face];
  const size = starts[face + 1] - start;
  if (size === 3) return [[0, 1, 2]];
  const normal = [0, 1, 2].map((axis) => normals[3 * face + axis]);
  const sizes = normal.map(Math.abs);
  const axis = sizes.indexOf(Math.max(...sizes));
  const [u, v] = planeAxes(axis);
  const flip = normal[axis] < 0 ? -1 : 1;
  const flat = [];
  for (let k = 0; k < size; k++) {
    const corner = 3 * corners[start + k];
    flat.push([flip * points[corner + u], points[corner + v]]);
  }
  return ears(flat);
}

/// The surface of the cells for which `shown` is 1. With `cut`, { axis, place, keepsBelow }, what lies on the
/// plane's other side is left out and the cells' sections are added.
function visibleSurface(cells, shown, colors, cut) {
  const buffer = new SurfaceBuffer();
  const { owners, neighbors } = cells;
  for (let face = 0; face < owners.length; face++) {
    const owner = shown[owners[face]] === 1;
    const neighbor = neighbors[face] >= 0 && shown[neighbors[face]] === 1;
    if (owner === neighbor || (cut && isBeyond(cells, face, cut))) continue;
    pushFace(buffer, cells, face, owner ? owners[face] : neighbors[face], owner ? 1 : -1, colors);
  }
  if (cut) {
    for (let cell = 0; cell < cells.count; cell++) {
      if (shown[cell] === 1 && meets(cells, cell, cut.axis, cut.place)) pushSection(buffer, cells, cell, cut, colors[cell]);
    }
  }
  return buffer;
}

function pushFace(buffer, cells, face, cell, side, colors) {
  const { points, corners, starts, normals, smooth } = cells;
  const start = starts[face];
  const end = starts[face + 1];
  const normal = [0, 1, 2].map((axis) => side * normals[3 * face + axis]);
  for (const triangle of faceTriangles(cells, face)) {
    for (const corner of triangle) buffer.push(points, corners[start + corner], normal, colors[cell], cell);
  }
  for (let k = start; k < end; k++) {
    if (smooth[k] === 0) buffer.line(points, corners[k], corners[k + 1 === end ? start : k + 1]);
  }
}

/// Whether a face lies on the side of a cut that is left out.
function isBeyond({ points, corners, starts }, face, { axis, place, keepsBelow }) {
  for (let k = starts[face]; k < starts[face + 1]; k++) {
    if (points[3 * corners[k] + axis] < place === keepsBelow) return false;
  }
  return true;
}

/// Whether a cell lies on both sides of a plane.
function meets(cells, cell, axis, place) {
  cells.extents ??= cellExtents(cells);
  return cells.extents[6 * cell + axis] <= place && cells.extents[6 * cell + 3 + axis] >= place;
}

/// The least and the greatest coordinates of every cell.
function cellExtents({ count, owners, neighbors, starts, corners, points }) {
  const extents = new Float32Array(6 * count).map((_, k) => (k % 6 < 3 ? Infinity : -Infinity));
  const include = (cell, corner) => {
    for (let axis = 0; axis < 3; axis++) {
      const x = points[3 * corner + axis];
      if (x < extents[6 * cell + axis]) extents[6 * cell + axis] = x;
      if (x > extents[6 * cell + 3 + axis]) extents[6 * cell + 3 + axis] = x;
    }
  };
  for (let face = 0; face < owners.length; face++) {
    for (let k = starts[face]; k < starts[face + 1]; k++) {
      include(owners[face], corners[k]);
      if (neighbors[face] >= 0) include(neighbors[face], corners[k]);
    }
  }
  return extents;
}

function pushSection(buffer, cells, cell, { axis, place, keepsBelow }, color) {
  const loops = sectionLoops(cells, cell, axis, place);
  if (loops.length === 0) return;
  const normal = [0, 0, 0];
  normal[axis] = keepsBelow ? 1 : -1;
  const [u, v] = planeAxes(axis);
  const lifted = (loop) => {
    const points = new Float32Array(3 * loop.length);
    loop.forEach((point, k) => {
      points[3 * k + axis] = place;
      points[3 * k + u] = point[0];
      points[3 * k + v] = point[1];
    });
    return points;
  };
  for (const loop of loops) {
    const points = lifted(loop);
    loop.forEach((_, k) => buffer.line(points, k, (k + 1) % loop.length));
  }
  for (const part of bridged(loops)) {
    const points = lifted(part);
    for (const triangle of ears(part)) {
      for (const corner of triangle) buffer.push(points, corner, normal, color, cell);
    }
  }
}

/// The loops [[u, v], …] in which the plane across `axis` at `place` cuts a cell, counter-clockwise as seen from the
/// axis's positive end, holes clockwise. As in src/geometry/section.rs a vertex on the plane counts as above.
function sectionLoops(cells, cell, axis, place) {
  const { points, corners, starts, normals } = cells;
  const segments = new Map();
  let count = 0;
  for (const entry of cells.facesOf[cell]) {
    const isOwn = entry >= 0;
    const face = isOwn ? entry : -1 - entry;
    const [start, end] = [starts[face], starts[face + 1]];
    const [rising, falling] = [[], []];
    for (let k = start; k < end; k++) {
      const [from, to] = [corners[k], corners[k + 1 === end ? start : k + 1]];
      const above = points[3 * from + axis] >= place;
      if (above === points[3 * to + axis] >= place) continue;
      (above === isOwn ? falling : rising).push(crossing(points, from, to, axis, place));
    }
    if (rising.length > 1) {
      const [u, v] = planeAxes(axis);
      const side = isOwn ? 1 : -1;
      const along = (at) => side * (normals[3 * face + u] * at.point[1] - normals[3 * face + v] * at.point[0]);
      for (const list of [rising, falling]) list.sort((one, other) => along(one) - along(other));
    }
    falling.forEach((from, k) => {
      const to = rising[k];
      if (!segments.has(from.key)) segments.set(from.key, []);
      segments.get(from.key).push({ from, to });
      count++;
    });
  }
  return joined(segments, count);
}

/// Where an edge meets the plane; the same for both faces at it.
function crossing(points, from, to, axis, place) {
  const [a, b] = [Math.min(from, to), Math.max(from, to)];
  const [low, high] = [points[3 * a + axis], points[3 * b + axis]];
  const share = (place - low) / (high - low);
  const point = planeAxes(axis).map((other) => points[3 * a + other] + share * (points[3 * b + other] - points[3 * a + other]));
  return { key: a * 67108864 + b, point };
}

/// Segments joined to loops where one starts on the edge on which another ends.
function joined(segments, count) {
  const loops = [];
  for (const list of segments.values()) {
    while (list.length > 0) {
      const loop = [];
      let segment = list.pop();
      for (let steps = 0; segment && steps < count; steps++) {
        loop.push(segment.from.point);
        segment = segments.get(segment.to.key)?.pop();
      }
      if (loop.length >= 3) loops.push(loop);
    }
  }
  return loops;
}
