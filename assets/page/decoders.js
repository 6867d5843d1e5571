// Decodes chunks beside the page, so that the view moves while the scene is loaded: the script of the page runs in workers too, as a decoder.

import { bytesOfBase64, decodeChunk, inflate } from "./decode.js";

/** Workers at most: more wait for one another's memory. */
const MOST_WORKERS = 4;

/** The text of this script, where a page runs it; a worker has no document. */
const pageScript = globalThis.document?.currentScript?.textContent;

async function decodeText({ text, images, cameras }) {
  return decodeChunk(await inflate(bytesOfBase64(text)), images, cameras);
}

/** Whether the script runs as a decoder; it serves the page then. */
export function servesAsDecoder() {
  if (globalThis.document) return false;
  globalThis.onmessage = async ({ data }) => {
    try {
      const decoded = await decodeText(data);
      globalThis.postMessage(decoded, [decoded.samples.buffer]);
    } catch (error) {
      globalThis.postMessage({ error: error.message });
    }
  };
  return true;
}

export class Decoders {
  constructor() {
    this.idle = [];
    try {
      const address = URL.createObjectURL(new Blob([pageScript], { type: "text/javascript" }));
      const count = Math.min(Math.max((navigator.hardwareConcurrency || 2) - 1, 1), MOST_WORKERS);
      this.idle = Array.from({ length: count }, () => this.started(address));
    } catch {
      // Some documents around a page allow no workers, or tell so later. The page decodes by itself then.
    }
    /** Chunks that are decoded at a time. */
    this.count = Math.max(this.idle.length, 1);
  }

  /** A worker. One that cannot start is left out, and what it was asked is answered with nothing. */
  started(address) {
    const worker = new Worker(address);
    worker.answer = () => {};
    worker.onmessage = ({ data }) => worker.answer(data);
    worker.onerror = (event) => {
      event.preventDefault();
      this.idle = this.idle.filter((other) => other !== worker);
      worker.answer(null);
    };
    return worker;
  }

  /** The samples and counts of a chunk, as `decodeChunk` gives them, of its text in the page; at most `count` at a time. */
  async decode(text, images, cameras) {
    const worker = this.idle.pop();
    if (!worker) return decodeText({ text, images, cameras });
    const answer = await new Promise((resolve) => {
      worker.answer = resolve;
      worker.postMessage({ text, images, cameras });
    });
    // A worker that could not start is not asked again.
    if (!answer) return this.decode(text, images, cameras);
    this.idle.push(worker);
    if (answer.error) throw new Error(answer.error);
    return answer;
  }

  /** Ends all workers. */
  end() {
    for (const worker of this.idle) worker.terminate();
    this.idle = [];
  }
}
