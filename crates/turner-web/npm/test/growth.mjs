// 1,000 pictures in one session: its memory and that of the process stay the same.
import assert from "node:assert/strict";
import { after, test } from "node:test";
import { box, cleanups, installed } from "./helpers.mjs";

const { Turner } = await installed();
const turner = new Turner();
after(async () => {
  turner.close();
  for (const cleanup of cleanups) await cleanup();
});

/** Pictures before the first measurement, and in all. */
const [FIRST, ALL] = [100, 1000];

test(`${ALL} pictures in a row need no more memory than ${FIRST}`, { timeout: 600_000 }, async t => {
  const glb = await box();
  const measured = () => ({ memory: turner.memory, rss: process.memoryUsage().rss });
  let early;
  let bytes;
  const begun = performance.now();
  for (let i = 1; i <= ALL; i++) {
    const { data } = await turner.render(glb, { width: 32, height: 24, samples: 1, format: "png" });
    bytes ??= data;
    assert.equal(Buffer.compare(data, bytes), 0);
    if (i === FIRST) early = measured();
  }
  const late = measured();
  const mib = bytes => (bytes / 2 ** 20).toFixed(1);
  t.diagnostic(`memory ${mib(early.memory)} -> ${mib(late.memory)} MiB, RSS ${mib(early.rss)} -> ${mib(late.rss)} MiB, `
    + `${((performance.now() - begun) / ALL).toFixed(1)} ms a picture`);
  // Threads ask for memory in another order each time: a few pages of 64 KiB more or less.
  assert.ok(late.memory <= early.memory + (1 << 20));
  assert.ok(late.rss < early.rss + (48 << 20));
});
