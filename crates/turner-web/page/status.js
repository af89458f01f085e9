// The status line: what the renderer does, how far it is, and with how many threads.

import { announce, find } from "./dom.js";
import { fail } from "./message.js";

const HEADERS = "this host does not send the headers Cross-Origin-Opener-Policy and Cross-Origin-Embedder-Policy";
const SHARED = "this browser does not share memory among workers";
/** Renders that take longer are announced when they end, seconds. */
const SPOKEN = 3;

export function setupStatus(page) {
  const text = find("status-text");
  const progress = find("progress");
  let noise = null;
  let settled = false;
  let isNew = true;
  let error = "";

  page.on("ready", engine => {
    const threads = engine.threads === 1 ? "one thread" : `${engine.threads} threads`;
    const [reason, short] = window.crossOriginIsolated
      ? [SHARED, SHARED]
      : [HEADERS, "this host does not send the headers for more"];
    const host = engine.isolated || engine.threads > 1 ? threads : `one thread: ${reason}`;
    find("status-host").textContent = host === threads ? threads : `one thread: ${short}`;
    find("status-host").title = host;
    find("host").textContent = `Renders with ${host}.`;
  });

  page.on("opened", () => { settled = false; isNew = true; noise = null; });
  page.on("frame", frame => {
    noise = frame.noise;
    show({ ...frame, doing: frame.stage === "preview" ? "preview" : "", settled: frame.stage === "settled" });
  });
  page.on("status", status => {
    // One message for one error: it can be closed.
    if (status.error && status.error.message !== error) fail(status.error, "Cannot render");
    error = status.error?.message || "";
    show(status);
  });

  function show(now) {
    const total = now.total || 0;
    const done = total ? Math.min(1, now.samples / total) : 0;
    progress.value = now.settled ? 1 : done;
    text.textContent = sentence(now, noise, page.paused);
    // Short renders after each edit would talk all the time.
    if (now.settled && !settled && (now.seconds > SPOKEN || isNew)) {
      isNew = false;
      announce(`The picture is finished: ${plural(total)} in ${duration(now.seconds)}`);
    }
    settled = Boolean(now.settled);
  }
}

/** "12 of 64 samples · noise 3 % · about 8 s left" */
function sentence(now, noise, paused) {
  const parts = [];
  if (now.settled) {
    parts.push(`finished: ${plural(now.total)} in ${duration(now.seconds)}`);
  } else if (paused) {
    parts.push("paused");
  } else if (now.doing) {
    parts.push(now.doing);
  }
  if (!now.settled && now.total && now.samples) parts.push(`${now.samples} of ${now.total} samples`);
  if (noise !== null && noise !== undefined) parts.push(`noise ${percent(noise)}${now.denoised ? " before denoising" : ""}`);
  if (!now.settled && !paused && now.left !== null && now.left !== undefined) parts.push(`about ${duration(now.left)} left`);
  return parts.join(" · ") || "ready";
}

const plural = samples => samples === 1 ? "1 sample" : `${samples} samples`;
const percent = x => `${(100 * x).toPrecision(x < 0.1 ? 2 : 3).replace(/\.?0+$/, "")} %`;

/** Seconds in words: "0.4 s", "12 s", "3 min". */
export function duration(seconds) {
  if (!(seconds >= 0)) return "some time";
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (seconds < 100) return `${Math.round(seconds)} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}
