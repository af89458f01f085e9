// Threads need a page that is cross-origin isolated. Where the host does not send the headers, the service worker adds
// them: it must control the page, so the page loads once more on the first visit. The worker also keeps the page offline.

const LOADED_AGAIN = "turner-loaded-again";
/** Longest wait for the worker, milliseconds. */
const PATIENCE = 4000;

export async function isolate() {
  if (!("serviceWorker" in navigator) || !isSecureContext) return;
  const registration = navigator.serviceWorker.register("sw.js").catch(() => null);
  if (crossOriginIsolated || !tryOnce()) return;
  // Without an answer the page continues, with one thread.
  const ready = registration.then(found => found ? active(found).then(() => true) : false);
  if (!await Promise.race([ready, new Promise(resolve => setTimeout(resolve, PATIENCE, false))])) return;
  location.reload();
  // The page is about to go.
  await new Promise(() => {});
}

/** Whether this is the first try of this visit; also false where nothing can be stored. */
function tryOnce() {
  try {
    if (sessionStorage.getItem(LOADED_AGAIN)) return false;
    sessionStorage.setItem(LOADED_AGAIN, "yes");
    return true;
  } catch {
    return false;
  }
}

/** Waits until the worker controls the page, or can control it after a reload. */
async function active(registration) {
  const worker = registration.installing || registration.waiting;
  if (navigator.serviceWorker.controller || !worker) return;
  await new Promise(resolve => {
    navigator.serviceWorker.addEventListener("controllerchange", resolve, { once: true });
    worker.addEventListener("statechange", () => { if (worker.state === "activated" || worker.state === "redundant") resolve(); });
  });
}
