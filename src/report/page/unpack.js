// The cells of a run from the numbers that the page holds (src/report/packing.rs and cells.rs).

/// The bytes of `text`, inflated to `size` bytes.
async function bytesOf(text, size) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  if (typeof DecompressionStream === "function") {
    try {
      const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
      return new Uint8Array(await new Response(stream).arrayBuffer());
    } catch {
      // An older browser knows the stream but not this format.
    }
  }
  return inflate(packed, size);
}

/// Reads arrays one after the other.
class NumberReader {
  constructor(bytes) {
    this.bytes = bytes;
    this.place = 0;
  }

  /// Whole numbers whose bytes stand in `width` planes.
  planes(count, width) {
    const numbers = new Uint32Array(count);
    for (let plane = 0; plane < width; plane++) {
      for (let k = 0; k < count; k++) numbers[k] |= this.bytes[this.place++] << (8 * plane);
    }
    return numbers;
  }

  numbers(count) {
    return this.planes(count, 4);
  }

  reals(count) {
    return new Float32Array(this.numbers(count).buffer);
  }

  flags(count) {
    this.place += count;
    return this.bytes.subarray(this.place - count, this.place);
  }

  /// Coordinates of 24 bits, each stored as the way from the one before.
  coordinates(count) {
    const numbers = this.planes(count, 3);
    let last = 0;
    for (let k = 0; k < count; k++) {
      const way = (numbers[k] >>> 1) ^ -(numbers[k] & 1);
      last = (last + way) & 0xffffff;
      numbers[k] = last;
    }
    return numbers;
  }

  /// Places relative to the box's corner (L), x y z in turn.
  places(count, step) {
    const places = new Float32Array(3 * count);
    for (let axis = 0; axis < 3; axis++) {
      const along = this.coordinates(count);
      for (let k = 0; k < count; k++) places[3 * k + axis] = along[k] * step[axis];
    }
    return places;
  }
}

/// The cells of the run of this number; its faces by owner, their corners counter-clockwise as seen from outside it.
async function unpackedCells(number, header) {
  const reader = new NumberReader(await bytesOf(byId(`cells-${number}`).textContent, header.bytes));
  const cells = { ...header, count: header.cells };
  cells.points = reader.places(header.points, header.step);
  const owned = reader.numbers(header.cells);
  const sizes = reader.numbers(header.faces);
  const ways = reader.numbers(header.faces);
  cells.starts = new Uint32Array(header.faces + 1);
  sizes.forEach((size, face) => {
    cells.starts[face + 1] = cells.starts[face] + size;
  });
  cells.owners = new Uint32Array(header.faces);
  let face = 0;
  owned.forEach((count, cell) => {
    for (let k = 0; k < count; k++) cells.owners[face++] = cell;
  });
  cells.neighbors = Int32Array.from(ways, (way, k) => (way === 0 ? -1 : cells.owners[k] + way));
  cells.corners = reader.numbers(header.corners);
  let next = 0;
  for (let k = 0; k < cells.corners.length; k++) {
    cells.corners[k] = next - cells.corners[k];
    if (cells.corners[k] === next) next++;
  }
  cells.smooth = reader.flags(header.corners);
  cells.sites = reader.places(header.cells, header.step);
  cells.siteNumbers = reader.numbers(header.cells);
  cells.columns = header.columns.map((column) => ({ ...column, values: reader.reals(header.cells) }));
  cells.normals = faceNormals(cells);
  cells.facesOf = facesByCell(cells);
  return cells;
}

/// Every face's unit normal out of its owner, by Newell's sum.
function faceNormals({ points, corners, starts }) {
  const normals = new Float32Array(3 * (starts.length - 1));
  for (let face = 0; face + 1 < starts.length; face++) {
    const [start, end] = [starts[face], starts[face + 1]];
    const sum = [0, 0, 0];
    const first = 3 * corners[start];
    for (let k = start + 1; k + 1 < end; k++) {
      const [a, b] = [3 * corners[k], 3 * corners[k + 1]];
      const one = [0, 1, 2].map((axis) => points[a + axis] - points[first + axis]);
      const two = [0, 1, 2].map((axis) => points[b + axis] - points[first + axis]);
      cross(one, two).forEach((length, axis) => {
        sum[axis] += length;
      });
    }
    const size = Math.hypot(...sum) || 1;
    for (let axis = 0; axis < 3; axis++) normals[3 * face + axis] = sum[axis] / size;
  }
  return normals;
}

/// The faces of every cell, those that it owns as k, the others as −1 − k.
function facesByCell({ count, owners, neighbors }) {
  const faces = Array.from({ length: count }, () => []);
  owners.forEach((cell, face) => {
    faces[cell].push(face);
    if (neighbors[face] >= 0) faces[neighbors[face]].push(-1 - face);
  });
  return faces;
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function unit(a) {
  const size = Math.hypot(...a) || 1;
  return a.map((length) => length / size);
}
