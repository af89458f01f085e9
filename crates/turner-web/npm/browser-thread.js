// A thread in a browser: runs tasks of the session on the same memory.
import { runThread } from "./core.js";

self.addEventListener("message", ({ data }) => {
  self.postMessage({ ready: true });
  try {
    runThread(data, message => self.postMessage({ fault: message }));
  } catch (error) {
    self.postMessage({ fault: String(error) });
  }
}, { once: true });
