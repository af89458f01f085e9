// Colours of the scene format as those of the colour picker: a name of CSS, "#rrggbb", or linear light.

/** Whether a value is a colour that the picker can show. */
export function isColor(value) {
  if (typeof value === "number") return true;
  if (Array.isArray(value)) return value.length === 3 && value.every(x => typeof x === "number");
  return typeof value === "string" && (/^#[0-9a-f]{6}$/i.test(value) || CSS.supports("color", value));
}

/** "#rrggbb". With `encoded`, the numbers of the scene are display values, as in classic scenes. */
export function hexOf(value, encoded) {
  if (typeof value === "string") return named(value);
  const light = typeof value === "number" ? [value, value, value] : value;
  return `#${light.map(x => byte(encoded ? clamp(x) : encode(x))).join("")}`;
}

/** The transfer function of sRGB (IEC 61966-2-1). */
function encode(x) {
  const light = clamp(x);
  return light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055;
}

const clamp = x => Math.max(0, Math.min(1, x));
const byte = x => Math.round(255 * x).toString(16).padStart(2, "0");

/** The canvas writes every colour that it knows as "#rrggbb". */
function named(name) {
  const context = document.createElement("canvas").getContext("2d");
  context.fillStyle = "#000000";
  context.fillStyle = name;
  return /^#[0-9a-f]{6}$/i.test(context.fillStyle) ? context.fillStyle : "#000000";
}
