// Two changes of one text.

/** The part of `before` that `after` replaces: [start, end, text]. Whole lines, so that changes of one line meet. */
function change(before, after) {
  let start = 0;
  const least = Math.min(before.length, after.length);
  while (start < least && before[start] === after[start]) start++;
  let same = 0;
  while (same < least - start && before[before.length - 1 - same] === after[after.length - 1 - same]) same++;
  start = before.lastIndexOf("\n", start - 1) + 1;
  let end = before.indexOf("\n", before.length - same);
  if (end < 0) end = before.length;
  return [start, end, after.slice(start, after.length - (before.length - end))];
}

/** Both changes of `base`; `null` where they touch the same lines. */
export function merge(base, ours, theirs) {
  const [first, second] = [change(base, ours), change(base, theirs)].sort((a, b) => a[0] - b[0]);
  if (first[1] > second[0]) return null;
  return base.slice(0, first[0]) + first[2] + base.slice(first[1], second[0]) + second[2] + base.slice(second[1]);
}

/** The selection after a text changed: it moves with what stands behind the change. */
export function keep(before, after, start, end) {
  let same = 0;
  const least = Math.min(before.length, after.length);
  while (same < least && before[same] === after[same]) same++;
  const shift = at => at <= same ? at : Math.max(same, at + after.length - before.length);
  return [Math.min(shift(start), after.length), Math.min(shift(end), after.length)];
}
