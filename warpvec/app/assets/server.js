/* The server: requests below the token of the address, and its stream of events. */

const BASE = location.pathname;
const RETRY_MS = 1000;

/** Identifies this tab, also after it has been loaded again. */
function pageIdentifier() {
  const known = sessionStorage.getItem("page");
  if (known) return known;
  const made = crypto.randomUUID().replaceAll("-", "");
  sessionStorage.setItem("page", made);
  return made;
}

class Server {
  /** `receive(kind, facts)` takes the events; `onLost` and `onFound` say whether there is a server. */
  constructor(receive, onLost, onFound) {
    Object.assign(this, { receive, onLost, onFound, page: pageIdentifier(), isOnline: false });
    this.listen();
  }

  listen() {
    const source = new EventSource(`${BASE}events?page=${this.page}`);
    for (const kind of ["hello", "server", "ready", "queue", "status", "mode", "frame", "done", "failed"]) {
      source.addEventListener(kind, (event) => this.receive(kind, JSON.parse(event.data)));
    }
    source.addEventListener("open", () => {
      this.isOnline = true;
      this.onFound();
    });
    source.addEventListener("error", () => {
      this.isOnline = false;
      this.onLost();
      if (source.readyState === EventSource.CLOSED) setTimeout(() => this.listen(), RETRY_MS);
    });
    addEventListener("pagehide", () => source.close());
  }

  /** Returns the answer to a request; throws an error with the server's own words if it refuses. */
  async ask(method, path, body) {
    let response;
    try {
      response = await fetch(BASE + path, { method, body });
    } catch {
      throw new Error("The server does not answer. Start warpvec app again.");
    }
    if (!response.ok) throw Object.assign(new Error((await response.text()).trim()), { status: response.status });
    return response;
  }

  async upload(blob, name) {
    const query = new URLSearchParams({ page: this.page, name });
    return (await this.ask("POST", `pictures?${query}`, blob)).json();
  }

  fit(id, request) {
    return this.ask("POST", `pictures/${id}/fit`, JSON.stringify(request));
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

  export(text, options) {
    return this.ask("POST", `export?${new URLSearchParams(options)}`, text);
  }

  previewUrl(id) {
    return `${BASE}pictures/${id}/preview`;
  }
}
