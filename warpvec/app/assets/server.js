/* The server: requests below the token of the address, and its stream of events. Whenever the page has no stream, the
 * server must prove itself first. */

import { provenPath, WrongServer } from "app/proof.js";

const RETRY_MS = 1000;
// A browser opens six connections to a server, and a stream takes one, so that a seventh page would never load: a page
// that is hidden gives its stream up after this time.
const REST_MS = 2000;
// Time in which a page that is loaded again has been left by the document before.
const CLAIM_MS = 2000;

/** Identifies this tab, also after it has been loaded again: returns its `page`, and the page that it is a `copy` of, or
 * null. A tab that is duplicated gets the storage of the other one, whose page is taken then. Another program at this port
 * may have left something else in the storage, which the user may have blocked, too. */
export async function pageIdentifier() {
  const made = crypto.randomUUID().replaceAll("-", "");
  try {
    const known = sessionStorage.getItem("page");
    const isKnown = /^[0-9a-f]{32}$/.test(known);
    if (isKnown && (await claims(known))) return { page: known, copy: null };
    sessionStorage.setItem("page", made);
    await claims(made);
    return { page: made, copy: isKnown ? known : null };
  } catch {
    return { page: made, copy: null }; // without storage, a page that is loaded again is a new one
  }
}

/** Takes a page until this tab is closed, and tells whether it could. */
function claims(page) {
  const signal = AbortSignal.timeout(CLAIM_MS);
  return new Promise((resolve) => {
    const hold = () => new Promise(() => resolve(true));
    navigator.locks.request(`warpvec page ${page}`, { signal }, hold).catch(() => resolve(!signal.aborted));
  });
}

export class Server {
  /** `page` identifies this tab; `receive(kind, facts)` takes the events; `onLost(isOther)` and `onFound` say whether there
   * is a server: another one may answer. */
  constructor(page, receive, onLost, onFound) {
    this.receive = receive;
    this.onLost = onLost;
    this.onFound = onFound;
    this.page = page;
    this.base = location.pathname;
    this.isOnline = false;
    this.isListening = false;
    this.turn = 0;
    this.timer = 0;
    /** @type {EventSource | null} */
    this.source = null;
    this.listen();
    document.addEventListener("visibilitychange", () => this.restOrWake());
    addEventListener("pageshow", (event) => event.persisted && this.restOrWake());
    addEventListener("pagehide", () => this.leave());
  }

  /** Lets the server prove itself, and learns its token: it may have been started again. */
  async prove() {
    const base = await provenPath(document.body.dataset.key);
    if (base === this.base) return;
    this.base = base;
    history.replaceState(null, "", base); // so that the page can be loaded again
  }

  async listen() {
    this.close();
    this.isListening = true;
    const turn = this.turn;
    const isPresent = () => this.turn === turn;
    const lose = (isOther) => {
      if (!isPresent()) return;
      this.isOnline = false;
      this.source?.close(); // it would try again by itself, whoever answers
      this.source = null;
      this.onLost(isOther);
      setTimeout(() => isPresent() && this.listen(), RETRY_MS);
    };
    try {
      await this.prove();
    } catch (error) {
      lose(error instanceof WrongServer);
      return;
    }
    if (!isPresent()) return;
    const source = new EventSource(`${this.base}events?page=${this.page}`);
    this.source = source;
    for (const kind of ["hello", "server", "ready", "queue", "status", "mode", "stage", "frame", "done", "failed"]) {
      source.addEventListener(kind, (event) => this.receive(kind, JSON.parse(event.data)));
    }
    source.addEventListener("open", () => {
      this.isOnline = true;
      this.onFound();
    });
    source.addEventListener("error", () => lose(false));
  }

  restOrWake() {
    clearTimeout(this.timer);
    if (document.hidden) this.timer = setTimeout(() => this.rest(), REST_MS);
    else if (!this.isListening) this.listen();
  }

  /** Gives the stream up. The server keeps the pictures, and fits them; it tells all when the page listens again. */
  async rest() {
    if (!this.source || !this.isOnline) return;
    this.close(); // first, as the request needs a connection too
    const isNoted = await this.ask("POST", `rest?page=${this.page}`).then(() => true, () => false);
    if (isNoted && document.hidden) return;
    this.listen(); // it is shown again, or the server has ended, which a new stream tells
  }

  close() {
    this.turn += 1;
    this.isListening = false;
    this.source?.close();
    this.source = null;
  }

  /** Tells the server that the page is closed, which it sees by itself if there is a stream. */
  leave() {
    if (this.isListening) this.close();
    else navigator.sendBeacon(`${this.base}leave?page=${this.page}`);
  }

  /** Returns the answer to a request; throws an error with the server's own words if it refuses. */
  async ask(method, path, body) {
    let response;
    try {
      if (!this.source || !this.isOnline) await this.prove();
      response = await fetch(this.base + path, { method, body });
    } catch {
      if (body instanceof Blob && !(await isReadable(body))) throw new Error("The file cannot be read. Was it moved or deleted?");
      throw new Error("The server does not answer. Start warpvec app again.");
    }
    if (!response.ok) throw Object.assign(new Error((await response.text()).trim()), { status: response.status });
    return response;
  }

  async upload({ key, name, blob }) {
    const query = new URLSearchParams({ page: this.page, key, name });
    return (await this.ask("POST", `pictures?${query}`, blob)).json();
  }

  async fit(id, request) {
    return (await this.ask("POST", `pictures/${id}/fit`, JSON.stringify(request))).json();
  }

  stop(id) {
    return this.ask("POST", `pictures/${id}/stop`);
  }

  remove(id) {
    return this.ask("DELETE", `pictures/${id}`);
  }

  async folder() {
    return (await this.ask("GET", "folder")).json();
  }

  async fromFolder(name) {
    return (await this.ask("GET", `folder/${encodeURIComponent(name)}`)).blob();
  }

  /** Returns shapes in other words: strokes, outlines or forms; with "cut", what is left of each first one of two. */
  async reshape(to, texts) {
    const body = JSON.stringify({ shapes: texts });
    return (await (await this.ask("POST", `reshape?${new URLSearchParams({ to })}`, body)).json()).shapes;
  }

  /** Returns the drawing of an SVG file: {svg, text, width, height, figures}; svg is what may be parsed here. */
  async open(file) {
    return (await this.ask("POST", "open", file)).json();
  }

  /** Returns {psnr}, the closeness of a drawing to a picture; null if they are equal. */
  async measure(id, text) {
    return (await this.ask("POST", `pictures/${id}/measure`, text)).json();
  }

  export(text, options) {
    return this.ask("POST", `export?${new URLSearchParams(options)}`, text);
  }

  /** Returns {size, warnings} of a drawing for a machine. */
  async cutFacts(text, machine) {
    return (await this.ask("POST", `cut?${new URLSearchParams({ machine })}`, text)).json();
  }

  previewUrl(id) {
    return `${this.base}pictures/${id}/preview`;
  }
}

/** Tells whether a file is still there. */
async function isReadable(blob) {
  try {
    await blob.slice(0, 1).arrayBuffer();
    return true;
  } catch {
    return false;
  }
}
