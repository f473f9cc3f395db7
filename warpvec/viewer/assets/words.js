/* Explains words that are not everyday English: in the help, as tooltips, and to screen readers. */

import { find, findAll } from "viewer/dom.js";

const WORDS = {
  path: ["Path", "A shape with an outline of lines and curves, and a fill."],
  stroke: ["Stroke", "A line of a width along a path: only its middle has nodes."],
  node: ["Node", "A point of an outline where two of its lines or curves meet. Handles beside it bend the curves."],
  smooth: ["Smooth node", "The outline does not bend here: the two handles stay in line (S)."],
  corner: ["Corner", "A node where the outline may bend: each handle moves by itself (S)."],
  gradient: ["Gradient", "A fill or stroke that changes from one colour to another, along a line or from a centre outwards."],
  stops: ["Stops", "The colours of a gradient and where they lie between its start (0 %) and its end (100 %)."],
  opacity: ["Opacity", "How much a path hides what is below: 1 hides it, 0 is like clear glass."],
  softness: ["Softness", "How far the edges of a path are blurred: 0 is sharp. Shadows and glows are soft paths."],
  palette: ["Palette", "All colours of the drawing, the most used first."],
  hex: ["Colour code", "Red, green and blue as six digits from 0 to f, as in web pages: #ff0000 is red."],
  hue: ["Hue", "The place of a colour in the rainbow, from red over green and blue to red again."],
  saturation: ["Vivid", "From grey to the most vivid colour; also called saturation."],
  near: ["Similar colours", "Also change similar colours: those that differ by at most this, of 255."],
  layer: ["Layer", "A group of paths that are shown and hidden together. Upper layers hide lower ones."],
  segment: ["Segment", "A line or a curve between two nodes."],
  bytes: ["File size", "The size of the file that is saved, in bytes."],
  gzip: ["Gzipped", "The file size after compression, as web servers send the file."],
  generation: ["Pass", "Paths that were added to a photo at the same time. Those of early passes are large, later ones show detail."],
  residual: ["Differences", "The difference between the drawing and the picture: black where they are equal."],
  psnr: ["Closeness", "How close the drawing is to the picture: at 30 dB it is good, at 40 dB it looks the same (PSNR)."],
  decibel: ["dB", "Decibel, the unit of closeness: 6 dB more are half of the error."],
  mono: ["Mono", "A kind of drawing in black and white: the dark areas of the picture, outlined in black."],
  opaque: ["Opaque paths", "Paths that hide what is below. Others mix with it, which photos look softer by."],
  again: ["Fit again", "The drawing with your edits is fitted to the picture: shapes stay, and move to where they are closest to it."],
  ssim: ["Likeness of structure", "How close the drawing is to the picture in structure: 1 is equal."],
  canvas: ["Canvas", "Width and height of the drawing, in its own units."],
  size: ["Size", "Width and height of the drawing on paper: 96 pixels are an inch."],
  iteration: ["Step", "A step of the fit, in which every path changes a little."],
  convergence: ["How it came closer", "How the closeness grew while the picture was drawn."],
};

// Rows of the table of figures and their words.
const FIGURE_WORDS = {
  Paths: "path", Layers: "layer", Canvas: "canvas", Size: "size", "File size": "bytes", Gzipped: "gzip", Segments: "segment",
  Closeness: "psnr", "Likeness of structure": "ssim",
};

/** Explains the first cells of the rows of the table of figures. */
export function explainFigures(table) {
  for (const { cells } of table.rows) {
    const word = FIGURE_WORDS[cells[0].textContent];
    cells[0].title = WORDS[word][1];
    cells[0].setAttribute("aria-describedby", `word-${word}`);
  }
}

export function connectWords() {
  for (const [key, [word, meaning]] of Object.entries(WORDS)) {
    const [term, text] = ["dt", "dd"].map((name) => document.createElement(name));
    [term.textContent, text.textContent, text.id] = [word, meaning, `word-${key}`];
    find("words").append(term, text);
  }
  for (const element of findAll("[data-word]")) {
    element.title ||= WORDS[element.dataset.word][1];
    const control = element.control ?? element.closest("label")?.control ?? document.getElementById(element.htmlFor) ?? element;
    control.setAttribute("aria-describedby", `word-${element.dataset.word}`);
  }
}
