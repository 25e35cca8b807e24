// Elements, numbers as text, and what the page remembers in its address.

const SVG = "http://www.w3.org/2000/svg";

/// An element with attributes (functions become listeners) and children (text or elements).
function element(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}

/// The same for SVG.
function drawing(name, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, name), attributes, children);
}

function filled(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(key, value);
    else if (value === true) node.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

function byId(id) {
  return document.getElementById(id);
}

/// A number with `digits` significant ones, without trailing zeros; small and large ones by powers of ten.
function numberText(value, digits = 6) {
  if (value === null || value === undefined) return "–";
  if (!Number.isFinite(value)) return String(value);
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-4 && size < 1e7) return String(Number(value.toPrecision(digits))).replace("-", "−");
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = exponent.replace("+", "").replace("-", "−");
  return `${String(Number(mantissa)).replace("-", "−")}e${power}`;
}

/// A whole number with thin spaces between groups of three digits.
function countText(value) {
  return String(value).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
}

function clamp(value, least, most) {
  return Math.min(Math.max(value, least), most);
}

/// What the address remembers after its #, as name=value pairs.
const remembered = new URLSearchParams(location.hash.slice(1));

/// Remembers a value, or with null forgets it, without a new entry in the history.
let rememberTimer = 0;
function remember(name, value) {
  if (value === null) remembered.delete(name);
  else remembered.set(name, value);
  clearTimeout(rememberTimer);
  rememberTimer = setTimeout(() => {
    const hash = remembered.toString();
    try {
      history.replaceState(null, "", hash === "" ? "#" : `#${hash}`);
    } catch {
      // A browser may refuse that for files: then the address stays as it is.
    }
  }, 200);
}

/// The value of a style's custom property.
function styleColor(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/// A labelled control.
function labelled(text, control) {
  return element("label", {}, element("span", {}, text), control);
}

function save(name, blob) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
