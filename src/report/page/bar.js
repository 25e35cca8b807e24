// Ticks of axes, and the color bar with its numbers.

/// Round numbers from `low` to `high`, about `count` of them, at least `least` apart.
function ticks(low, high, count, least = 0) {
  const length = high - low;
  if (!(length > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(length / count));
  const round = [1, 2, 5, 10].map((factor) => factor * power).find((size) => length / size <= count * 1.2) ?? power;
  const step = Math.max(round, least);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, k) => Number(((first + k) * step).toPrecision(12)));
}

/// Powers of ten from `low` to `high`, and where these are few twice and five times them.
function decades(low, high, count) {
  const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
  const every = Math.max(1, Math.ceil((last - first) / count));
  const factors = last - first <= 2 ? [1, 2, 5] : [1];
  const all = [];
  for (let power = first; power <= last; power += every) all.push(...factors.map((factor) => factor * 10 ** power));
  return all.filter((value) => value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9));
}

const BAR_WIDTH = 250;
const BAR_HEIGHT = 14;
const BAR_SIDE = 16;
const LETTER = 7;

/// The bar of a scale. Ends beyond which values lie are marked by arrows.
function colorBar(scale) {
  const { column, low, high } = scale;
  const stops = Array.from({ length: 17 }, (_, k) =>
    drawing("stop", { offset: k / 16, "stop-color": webColor(scale.at(k / 16)) }));
  const id = `bar-${colorBar.count = (colorBar.count ?? 0) + 1}`;
  const across = (value) => BAR_SIDE + (BAR_WIDTH * (value - low)) / (high - low || 1);
  const values = Array.from(column.values).filter(Number.isFinite);
  const isBelow = values.some((value) => value < low - 1e-6 * Math.abs(low));
  const isAbove = values.some((value) => value > high + 1e-6 * Math.abs(high));
  const arrow = (x, direction, color) => drawing("path", {
    d: `M${x} 2 l${direction * 10} ${BAR_HEIGHT / 2} l${-direction * 10} ${BAR_HEIGHT / 2} z`, fill: webColor(color),
  });
  const end = (value) => `${value === low && isBelow ? "≤ " : value === high && isAbove ? "≥ " : ""}${numberText(value, 4)}`;
  // About seven units a letter: a number that would touch one of the ends is left out.
  const length = (text) => LETTER * text.length;
  const [first, last] = [length(end(low)), BAR_WIDTH + 2 * BAR_SIDE - length(end(high))];
  const isFree = (value) => {
    const half = 0.5 * length(numberText(value, 4)) + LETTER;
    return across(value) - half > first && across(value) + half < last;
  };
  const named = [low, ...ticks(low, high, 4, column.whole ? 1 : 0).filter(isFree), ...(high > low ? [high] : [])];
  const labels = named.flatMap((value) => {
    const anchor = value === low ? "start" : value === high ? "end" : "middle";
    const x = across(value) + (value === low ? -BAR_SIDE : value === high ? BAR_SIDE : 0);
    return [
      drawing("line", { x1: across(value), x2: across(value), y1: BAR_HEIGHT + 2, y2: BAR_HEIGHT + 6, class: "tick" }),
      drawing("text", { x, y: BAR_HEIGHT + 19, "text-anchor": anchor }, end(value)),
    ];
  });
  return drawing("svg", { class: "bar", viewBox: `0 0 ${BAR_WIDTH + 2 * BAR_SIDE} ${BAR_HEIGHT + 24}`, role: "img",
    "aria-label": `colors from ${numberText(low)} to ${numberText(high)}: ${column.label}` },
  drawing("defs", {}, drawing("linearGradient", { id }, ...stops)),
  drawing("rect", { x: BAR_SIDE, y: 2, width: BAR_WIDTH, height: BAR_HEIGHT, fill: `url(#${id})` }),
  isBelow ? arrow(BAR_SIDE, -1, scale.at(0)) : null,
  isAbove ? arrow(BAR_SIDE + BAR_WIDTH, 1, scale.at(1)) : null,
  ...labels);
}
