// Colours of TOML text: a tokenizer that keeps every character, so that the painted text lies exactly behind the typed one.

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

/** A line that is a section alone: what stands before it is closed, even while brackets are being written. */
const SECTION = /\[\[?[A-Za-z0-9_.-]+\]\]?[ \t]*(?:#[^\n]*)?(?=\n|$)/y;

/** The start of each line, and what is open there: brackets, and the quotes of a text of several lines. */
export function scan(text) {
  const lines = [{ start: 0, depth: 0, quote: "" }];
  let depth = 0;
  let quote = "";
  for (let i = 0; i < text.length; i++) {
    if (!quote && text[i] === "[" && (i === 0 || text[i - 1] === "\n")) {
      SECTION.lastIndex = i;
      const section = SECTION.exec(text);
      if (section) {
        depth = 0;
        lines[lines.length - 1].depth = 0;
        i += section[0].length - 1;
        continue;
      }
    }
    const c = text[i];
    if (c === "\n") {
      // A text of one line ends there, closed or not.
      if (quote.length === 1) quote = "";
      lines.push({ start: i + 1, depth, quote });
    } else if (quote) {
      if (c === "\\" && quote[0] === "\"" && text[i + 1] !== "\n") i++;
      else if (text.startsWith(quote, i)) { i += quote.length - 1; quote = ""; }
    } else if (c === "#") {
      const end = text.indexOf("\n", i);
      i = (end < 0 ? text.length : end) - 1;
    } else if (c === "\"" || c === "'") {
      quote = text.startsWith(c.repeat(3), i) ? c.repeat(3) : c;
      i += quote.length - 1;
    } else if (c === "[" || c === "{") {
      depth++;
    } else if (c === "]" || c === "}") {
      depth = Math.max(0, depth - 1);
    }
  }
  return lines;
}

/**
 * [kind, start, end] of each piece of the text from the start of a line to `stop`, without gaps. Lists of several lines
 * look like sections to a tokenizer that does not count brackets; so it counts them.
 */
export function tokens(text, line, stop) {
  const pieces = [];
  let { start: at, depth } = line;
  if (line.quote) {
    const close = text.indexOf(line.quote, at);
    const end = close < 0 ? stop : Math.min(stop, close + line.quote.length);
    pieces.push(["string", at, end]);
    at = end;
  }
  while (at < stop) {
    let kind = "plain";
    let end = at + 1;
    for (const [name, pattern] of TOKENS) {
      if (name === "section" && depth > 0) continue;
      pattern.lastIndex = at;
      const match = pattern.exec(text);
      if (match && match[0]) {
        kind = name;
        end = Math.min(stop, at + match[0].length);
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

/**
 * Paints the text from the start of a line to `stop` into an element; `marks`: [{start, end, kind}] are underlined. Only
 * the lines in sight are painted: a text can have ten thousand.
 */
export function paint(element, text, line, stop, marks) {
  const sorted = marks.filter(mark => mark.end > mark.start && mark.end > line.start && mark.start < stop).sort((a, b) => a.start - b.start);
  const nodes = [];
  let next = 0;
  for (const [kind, start, end] of tokens(text, line, stop)) {
    let at = start;
    while (at < end) {
      while (next < sorted.length && sorted[next].end <= at) next++;
      const mark = sorted[next];
      const inside = mark && mark.start <= at;
      const to = Math.max(at + 1, Math.min(end, inside ? mark.end : mark ? mark.start : end));
      nodes.push(piece(text.slice(at, to), kind, inside ? mark.kind : ""));
      at = to;
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
