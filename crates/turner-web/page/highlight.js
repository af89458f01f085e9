// Colours of TOML text: a tokenizer that keeps every character, so that the painted text lies exactly behind the typed one.

/** Longest text that is painted, UTF-16 units: painting is linear, but runs with each key. */
export const LONGEST = 300_000;

const TOKENS = [
  ["comment", /#[^\n]*/y],
  ["string", /"""(?:[^\\]|\\[^])*?(?:"""|$)|'''[^]*?(?:'''|$)|"(?:[^"\\\n]|\\.)*"?|'[^'\n]*'?/y],
  ["section", /^[ \t]*\[\[?[^\]\n"]*\]?\]?/my],
  ["key", /[A-Za-z0-9_-]+(?=[ \t]*(?:=|\.[A-Za-z0-9_."-]+[ \t]*=))/y],
  ["number", /[+-]?(?:0x[0-9A-Fa-f_]+|\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d+)?)(?![A-Za-z_])/y],
  ["bool", /\b(?:true|false|inf|nan)\b/y],
  ["space", /\s+/y],
  ["word", /[A-Za-z0-9_-]+/y],
];

/**
 * [kind, start, end] of each piece of the text, without gaps. Multi-line arrays look like sections to a tokenizer that
 * does not count brackets; so it counts them.
 */
export function tokens(text) {
  const pieces = [];
  let at = 0;
  let depth = 0;
  while (at < text.length) {
    let kind = "plain";
    let end = at + 1;
    for (const [name, pattern] of TOKENS) {
      if (name === "section" && depth > 0) continue;
      pattern.lastIndex = at;
      const match = pattern.exec(text);
      if (match && match[0]) {
        kind = name;
        end = at + match[0].length;
        break;
      }
    }
    if (kind === "plain") {
      if ("[{".includes(text[at])) depth++;
      if ("]}".includes(text[at])) depth = Math.max(0, depth - 1);
    }
    const last = pieces[pieces.length - 1];
    if (last && last[0] === kind && last[2] === at) last[2] = end;
    else pieces.push([kind, at, end]);
    at = end;
  }
  return pieces;
}

/** Paints the text into an element; `marks`: [{start, end, kind}] are underlined. */
export function paint(element, text, marks) {
  const pieces = text.length > LONGEST ? [["word", 0, text.length]] : tokens(text);
  const sorted = marks.filter(mark => mark.end > mark.start).sort((a, b) => a.start - b.start);
  const nodes = [];
  let next = 0;
  for (const [kind, start, end] of pieces) {
    let at = start;
    while (at < end) {
      while (next < sorted.length && sorted[next].end <= at) next++;
      const mark = sorted[next];
      const inside = mark && mark.start <= at;
      const to = Math.min(end, inside ? mark.end : mark ? mark.start : end);
      nodes.push(piece(text.slice(at, Math.max(to, at + 1)), kind, inside ? mark.kind : ""));
      at = Math.max(to, at + 1);
    }
  }
  // A last line without characters still has a height.
  nodes.push("\n");
  element.replaceChildren(...nodes);
}

const PLAIN = new Set(["space", "plain", "word"]);

function piece(text, kind, mark) {
  if (PLAIN.has(kind) && !mark) return text;
  const span = document.createElement("span");
  span.className = `${PLAIN.has(kind) ? "" : `t-${kind}`} ${mark ? `mark ${mark}` : ""}`.trim();
  span.textContent = text;
  return span;
}

/** The offset of a line and column, from 1, columns in characters; the end of the line if it is shorter. */
export function offset(text, line, column) {
  let start = 0;
  for (let i = 1; i < line; i++) {
    const next = text.indexOf("\n", start);
    if (next < 0) return text.length;
    start = next + 1;
  }
  let end = text.indexOf("\n", start);
  if (end < 0) end = text.length;
  const before = Array.from(text.slice(start, end)).slice(0, Math.max(0, (column || 1) - 1)).join("");
  return start + before.length;
}

/** The line and column of an offset, from 1, in UTF-16 units. */
export function place(text, at) {
  const start = text.lastIndexOf("\n", at - 1) + 1;
  let line = 1;
  for (let i = text.indexOf("\n"); i >= 0 && i < at; i = text.indexOf("\n", i + 1)) line++;
  return { line, column: at - start + 1 };
}
