// Polygons of any shape as triangles, by cutting off ears; holes are bridged to the loop around them.

/// Twice the signed area of a triangle of points [x, y].
function turn(a, b, c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

function loopArea(points) {
  let sum = 0;
  for (let k = 1; k + 1 < points.length; k++) sum += turn(points[0], points[k], points[k + 1]);
  return 0.5 * sum;
}

/// The triangles, as triples of places in `points`, of a counter-clockwise loop that may touch itself.
function ears(points) {
  const left = points.map((_, k) => k);
  const triangles = [];
  const isConvex = points.every((point, k) => {
    const [before, after] = [points.at(k - 1), points[(k + 1) % points.length]];
    return turn(before, point, after) >= 0;
  });
  if (isConvex) {
    for (let k = 1; k + 1 < points.length; k++) triangles.push([0, k, k + 1]);
    return triangles;
  }
  while (left.length > 3) {
    const ear = nextEar(points, left);
    const count = left.length;
    triangles.push([left[(ear + count - 1) % count], left[ear], left[(ear + 1) % count]]);
    left.splice(ear, 1);
  }
  triangles.push([...left]);
  return triangles;
}

/// The place in `left` of a corner that can be cut off; where rounding leaves none, of the most convex one.
function nextEar(points, left) {
  const count = left.length;
  let [best, largest] = [0, -Infinity];
  for (let k = 0; k < count; k++) {
    const [a, b, c] = [-1, 0, 1].map((step) => points[left[(k + step + count) % count]]);
    const area = turn(a, b, c);
    const holds = (point) =>
      point !== a && point !== b && point !== c && !isSame(point, a) && !isSame(point, b) && !isSame(point, c) &&
      turn(a, b, point) >= 0 && turn(b, c, point) >= 0 && turn(c, a, point) >= 0;
    if (area > 0 && !left.some((other) => holds(points[other]))) return k;
    if (area > largest) [best, largest] = [k, area];
  }
  return best;
}

function isSame(one, other) {
  return one[0] === other[0] && one[1] === other[1];
}

/// The area that several loops bound (outer ones counter-clockwise, holes clockwise), each a list of points
/// [x, y]: one loop for every part, with its holes bridged.
function bridged(loops) {
  const outer = loops.filter((loop) => loopArea(loop) > 0);
  for (const hole of loops.filter((loop) => loopArea(loop) < 0)) {
    const around = outer.findIndex((loop) => isInside(hole[0], loop));
    if (around < 0) continue;
    outer[around] = withHole(outer[around], hole);
  }
  return outer;
}

/// A loop with a hole joined to it by the shortest bridge that crosses neither.
function withHole(loop, hole) {
  const pairs = loop.flatMap((point, k) => hole.map((other, j) => [Math.hypot(point[0] - other[0], point[1] - other[1]), k, j]));
  pairs.sort((one, other) => one[0] - other[0]);
  const isFree = ([, k, j]) => ![loop, hole].some((ring) =>
    ring.some((from, i) => crosses(loop[k], hole[j], from, ring[(i + 1) % ring.length])));
  const [, k, j] = pairs.find(isFree) ?? pairs[0];
  return [...loop.slice(0, k + 1), ...hole.slice(j), ...hole.slice(0, j + 1), ...loop.slice(k)];
}

/// Whether two segments cross within both.
function crosses(a, b, c, d) {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

/// Whether a point lies in a loop, by the even-odd rule.
function isInside([x, y], loop) {
  let inside = false;
  loop.forEach(([x1, y1], k) => {
    const [x0, y0] = loop.at(k - 1);
    if (y0 > y !== y1 > y && x < x0 + ((y - y0) / (y1 - y0)) * (x1 - x0)) inside = !inside;
  });
  return inside;
}
