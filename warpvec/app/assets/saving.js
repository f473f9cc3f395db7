/* Files that are saved: in the folder of the server, or as downloads. SVG and svgz need no server. */

import { formatBytes } from "viewer/charts.js";
import { find, findAll, setText } from "viewer/dom.js";

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
    for (const option of find("purpose").options) option.disabled = option.hidden = !formats.includes(option.dataset.kind);
    for (const button of findAll("[data-format]")) button.hidden = !formats.includes(button.dataset.format);
  }

  /** Says what the file is that is chosen. Machines make it in its `size`, in millimetres, or null without a drawing. */
  showUse(size) {
    const { kind, help } = this.use;
    setText("purpose-text", kind === "dxf" && size ? `${help} It is ${size} now.` : help);
    find("save-for").title = help;
    setText("save-for", `Save ${kind.toUpperCase()}`);
  }

  /** What the file is for that is chosen: {kind, help, purpose}; the purpose of a kind of its own is usual for it. */
  get use() {
    const [option] = find("purpose").selectedOptions;
    const { kind, help } = option.dataset;
    return { kind, help, purpose: kind === "svg" && option.value !== "web" ? option.value : "" };
  }

  /** Saves `text` for a `purpose`, if one is chosen, and returns a sentence about it. */
  async save(text, name, format, width, purpose = "") {
    if (format === "xml") name = resourceName(name);
    const options = { format, name, ...(purpose && { for: purpose }) };
    if (format === "png") Object.assign(options, { width, transparent: /<rect id="background"/.test(text) ? 0 : 1 });
    if (this.folder && this.server.isOnline) {
      const answer = await (await this.server.export(text, { ...options, to: "folder" })).json();
      return sentence(answer.saved, answer.bytes, answer.losses, ` in ${this.folder}`);
    }
    const { blob, losses } = await this.encoded(text, format, options);
    download(blob, `${name}.${format}`);
    return sentence(`${name}.${format}`, blob.size, losses);
  }

  async encoded(text, format, options) {
    if (format === "svg" && !options.for) return { blob: new Blob([text], { type: "image/svg+xml" }), losses: [] };
    if (format === "svgz" && !options.for) return { blob: await gzipped(text), losses: [] };
    const response = await this.server.export(text, options);
    return { blob: await response.blob(), losses: JSON.parse(response.headers.get("Warpvec-Losses") ?? "[]") };
  }
}

/** Returns `name` as Android wants names of resources: small letters, digits and underscores, a letter first. */
function resourceName(name) {
  const words = name.toLowerCase().replace(/[^a-z0-9]+/g, "_");
  return /^[a-z]/.test(words) ? words : `drawing_${words}`;
}

function sentence(name, bytes, losses, place = "") {
  return [`Saved ${name}${place}, ${formatBytes(bytes)}`, ...losses].join("; ");
}
