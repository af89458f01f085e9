// Registers the service worker. Where the host does not send the headers that threads need, the page is loaded once more,
// with the headers of the service worker.

/** Resolves when the page may start: `"reload"` if it is about to be loaded again. */
export async function isolate() {
  if (!("serviceWorker" in navigator) || !window.isSecureContext) return "plain";
  try {
    await navigator.serviceWorker.register(new URL("sw.js", import.meta.url), { updateViaCache: "none" });
  } catch {
    return "plain";
  }
  if (window.crossOriginIsolated) return "isolated";
  // Once: browsers without these headers stay with one thread.
  const key = "turner-isolated";
  try {
    if (sessionStorage.getItem(key)) return "plain";
    sessionStorage.setItem(key, "1");
  } catch {
    return "plain";
  }
  await navigator.serviceWorker.ready;
  location.reload();
  return "reload";
}
