// A viewer at infinity, as src/plot/camera.rs, that turns about +z.

class Camera {
  /// Looks from the direction `toward` at the middle of a box.
  constructor(toward) {
    this.home = [Math.atan2(toward[1], toward[0]), Math.asin(unit(toward)[2])];
    this.reset();
  }

  reset() {
    [this.azimuth, this.elevation] = this.home;
    this.zoom = 1;
    this.pan = [0, 0];
  }

  look(azimuth, elevation) {
    this.azimuth = azimuth;
    this.elevation = clamp(elevation, -Math.PI / 2, Math.PI / 2);
  }

  /// Right, up and toward the viewer.
  axes() {
    const [a, e] = [this.azimuth, this.elevation];
    return [
      [-Math.sin(a), Math.cos(a), 0],
      [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)],
      [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)],
    ];
  }

  /// Pixels per unit of length in a picture that shows a ball of this radius.
  scale(radius, width, height) {
    return (this.zoom * 0.5 * Math.min(width, height)) / (radius || 1);
  }

  /// The matrix, by columns, from places about `middle` to the cube of WebGL; `focus`, a pixel, fills the picture.
  matrix({ middle, radius, width, height, focus }) {
    const [right, up, toward] = this.axes();
    const scale = this.scale(radius, width, height);
    const [x, y] = [(2 * scale) / width, (2 * scale) / height];
    const deep = 0.5 / (radius || 1);
    const rows = [
      [...right.map((part) => x * part), -x * dot(right, middle) + (2 * this.pan[0]) / width],
      [...up.map((part) => y * part), -y * dot(up, middle) + (2 * this.pan[1]) / height],
      [...toward.map((part) => -deep * part), deep * dot(toward, middle)],
      [0, 0, 0, 1],
    ];
    if (focus) {
      const place = [(2 * focus[0]) / width - 1, 1 - (2 * focus[1]) / height];
      [width, height].forEach((size, axis) => {
        rows[axis] = rows[axis].map((part, k) => size * (part - (k === 3 ? place[axis] : 0)));
      });
    }
    return new Float32Array([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])));
  }
}

/// A length of 1, 2 or 5 times a power of ten, at most `most`.
function niceLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map((factor) => factor * power).find((length) => length <= most) ?? power;
}
