// Values of the scene format, as fields show them.

/** Longest value that is shown as text. */
const LONGEST = 400;

/** What a key has: its value, or its default as far as that is a value. */
export function current(key) {
  if (key.value !== null && key.value !== undefined) return key.value;
  if (key.default === null || key.default === undefined) return null;
  if (key.default === "none" && !key.words?.length) return null;
  if (typeof key.default !== "string") return key.default;
  try {
    return JSON.parse(key.default);
  } catch {
    return key.default;
  }
}

/** A field that is being written in keeps what was typed. */
export const isBusy = element => element === document.activeElement;

/** Numbers are shown with a few digits; what was written stays until it is changed. */
export const digits = (x, count = 6) => typeof x === "number" ? String(Number(x.toPrecision(count))) : "";

export function brief(value) {
  const written = typeof value === "string" ? value : JSON.stringify(value);
  return isLong(value) ? `${written.slice(0, LONGEST)} …` : written;
}

/** Whether a value is too long to be edited in a field. */
export const isLong = value => JSON.stringify(value).length > LONGEST;
