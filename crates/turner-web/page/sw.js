// The service worker: the page works offline after the first visit, and gets the headers that threads need where the host
// does not send them. The build writes the list of files and the version.

const FILES = [];
const VERSION = "";
const CACHE = `turner-${VERSION}`;

self.addEventListener("install", event => {
  event.waitUntil((async () => {
    const cache = await caches.open(CACHE);
    // A file that cannot be had now is fetched when it is used.
    await Promise.allSettled(["./", ...FILES].map(name => cache.add(new Request(name, { cache: "no-cache" }))));
    await self.skipWaiting();
  })());
});

self.addEventListener("activate", event => {
  event.waitUntil((async () => {
    for (const name of await caches.keys()) if (name.startsWith("turner-") && name !== CACHE) await caches.delete(name);
    await self.clients.claim();
  })());
});

/** The same answer with the headers that make the page cross-origin isolated. */
function isolated(response) {
  if (response.type === "opaque" || response.status === 0) return response;
  const headers = new Headers(response.headers);
  headers.set("Cross-Origin-Opener-Policy", "same-origin");
  headers.set("Cross-Origin-Embedder-Policy", "require-corp");
  headers.set("Cross-Origin-Resource-Policy", "same-origin");
  const { status, statusText } = response;
  return new Response(status === 204 || status === 304 ? null : response.body, { status, statusText, headers });
}

self.addEventListener("fetch", event => {
  const { request } = event;
  if (request.method !== "GET" || new URL(request.url).origin !== self.location.origin) return;
  event.respondWith((async () => {
    const cache = await caches.open(CACHE);
    const kept = await cache.match(request, { ignoreSearch: request.mode === "navigate" });
    if (kept) return isolated(kept);
    return isolated(await fetch(request));
  })());
});
