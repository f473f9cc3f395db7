/* Files that are saved: in the folder of the server, or as downloads. SVG and svgz need no server. */

import { formatBytes } from "viewer/charts.js";
import { findAll } from "viewer/dom.js";

const DOWNLOAD_MS = 10_000;

function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), DOWNLOAD_MS);
}

function gzipped(text) {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("gzip"));
  return new Response(stream).blob();
}

export class Saver {
  constructor(server) {
    this.server = server;
    this.folder = null;
  }

  /** Shows the buttons of the formats that the server can write. */
  setUp({ formats, folder }) {
    this.folder = folder;
    for (const button of findAll("[data-format]")) button.hidden = !formats.includes(button.dataset.format);
  }

  /** Saves `text` and returns a sentence about it. */
  async save(text, name, format, width) {
    const options = { format, name };
    if (format === "png") Object.assign(options, { width, transparent: /<rect id="background"/.test(text) ? 0 : 1 });
    if (this.folder && this.server.isOnline) {
      const answer = await (await this.server.export(text, { ...options, to: "folder" })).json();
      return `Saved ${answer.saved} in ${this.folder}, ${formatBytes(answer.bytes)}`;
    }
    const blob = await this.encoded(text, format, options);
    download(blob, `${name}.${format}`);
    return `Saved ${name}.${format}, ${formatBytes(blob.size)}`;
  }

  async encoded(text, format, options) {
    if (format === "svg") return new Blob([text], { type: "image/svg+xml" });
    if (format === "svgz") return gzipped(text);
    return (await this.server.export(text, options)).blob();
  }
}
