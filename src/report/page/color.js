// From values to colors, as src/plot/color.rs: viridis, its darkest end left out, the good end bright.

class ColorScale {
  constructor(palette, column) {
    this.stops = palette.stops.map(rgbOf);
    this.dark = palette.dark;
    this.column = column;
    [this.low, this.high] = column.range;
  }

  /// Red, green and blue (0…255) at a share 0…1 of the way from the low to the high end of the range.
  at(share) {
    const bright = this.column.bright === "low" ? 1 - share : share;
    const place = (this.dark + (1 - this.dark) * clamp(bright, 0, 1)) * (this.stops.length - 1);
    const stop = Math.min(Math.floor(place), this.stops.length - 2);
    const [from, to] = [this.stops[stop], this.stops[stop + 1]];
    return from.map((part, k) => Math.round(part + (place - stop) * (to[k] - part)));
  }

  color(value) {
    if (!Number.isFinite(value)) return [136, 136, 136];
    const length = this.high - this.low;
    return this.at(length > 0 ? (value - this.low) / length : value < this.low ? 0 : 1);
  }

  holds(value) {
    return value >= this.low && value <= this.high;
  }
}

function rgbOf(text) {
  const code = parseInt(text.slice(1), 16);
  return [code >> 16, (code >> 8) & 255, code & 255];
}

function webColor(rgb) {
  return `rgb(${rgb.join(" ")})`;
}

/// The perceived brightness, 0 to 255 (ITU-R BT.601).
function luma([red, green, blue]) {
  return 0.299 * red + 0.587 * green + 0.114 * blue;
}
