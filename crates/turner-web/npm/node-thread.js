// A thread in Node: runs tasks of the session on the same memory.
import { parentPort, workerData } from "node:worker_threads";
import { runThread } from "./core.js";

parentPort.postMessage({ ready: true });
try {
  runThread(workerData, message => parentPort.postMessage({ fault: message }));
} catch (error) {
  parentPort.postMessage({ fault: String(error) });
}
