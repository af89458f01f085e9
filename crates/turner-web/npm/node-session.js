// The session's worker in Node.
import { parentPort, Worker } from "node:worker_threads";
import { serve } from "./session.js";

const handle = serve({
  isShared: true,
  post: (message, transfer) => parentPort.postMessage(message, transfer),
  startThread(start, onMessage, onError) {
    const thread = new Worker(new URL("./node-thread.js", import.meta.url), { workerData: start });
    thread.on("message", onMessage);
    thread.on("error", error => onError(error.message));
    return () => void thread.terminate();
  },
});
parentPort.on("message", handle);
