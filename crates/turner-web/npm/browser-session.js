// The session's worker in a browser. Threads need a page that is cross-origin isolated.
import { serve } from "./session.js";

const handle = serve({
  isShared: self.crossOriginIsolated === true,
  post: (message, transfer) => self.postMessage(message, transfer),
  startThread(start, onMessage, onError) {
    const thread = new Worker(new URL("./browser-thread.js", import.meta.url), { type: "module" });
    thread.onmessage = ({ data }) => onMessage(data);
    thread.onerror = event => onError(event.message || "the thread cannot be started");
    thread.postMessage(start);
    return () => thread.terminate();
  },
});
self.onmessage = ({ data }) => handle(data);
