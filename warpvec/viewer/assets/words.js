/* Explains words that are not everyday English: in the help, as tooltips, and to screen readers. */

const WORDS = {
  path: ["Path", "A shape with an outline of lines and curves, and a fill."],
  node: ["Node", "A point of an outline where two of its lines or curves meet. Handles beside it bend the curves."],
  smooth: ["Smooth node", "The outline passes it without a bend: its two handles stay in line (S)."],
  corner: ["Corner", "A node at which the outline may bend: its two handles move apart (S)."],
  gradient: ["Gradient", "A fill that changes from one colour to another, along a line or from a centre outwards."],
  opacity: ["Opacity", "How much a path hides what is below: 1 hides it, 0 is like clear glass."],
  palette: ["Palette", "All colours of the drawing, the most used first."],
  hex: ["Colour code", "Red, green and blue as six digits from 0 to f, as in web pages: #ff0000 is red."],
  hue: ["Hue", "The place of a colour in the rainbow, from red over green and blue to red again."],
  saturation: ["Vivid", "From grey to the most vivid colour; also called saturation."],
  near: ["Near", "Colours that differ by at most this, of 255, are replaced too, and change as much."],
  level: ["Level", "A group of paths that are shown, hidden and saved together, as a layer: upper levels hide lower ones."],
  segment: ["Segment", "A line or a curve between two nodes."],
  gzip: ["Gzipped", "The size of the file as web servers send it, packed without loss."],
  generation: ["Generation", "Paths that the fit added at the same time. Early ones are large, late ones show detail."],
  residual: ["Residual", "The difference between drawing and photo: black where they are the same."],
  psnr: ["PSNR", "How like the photo the drawing is, in decibels (dB). More is better; 3 dB more halve the error."],
  ssim: ["SSIM", "How like the photo the drawing is in structure: 1 is the same."],
  canvas: ["Canvas", "Width and height of the drawing, in its own units."],
  iteration: ["Iteration", "A round of the fit, in which all paths are changed a little."],
  convergence: ["Convergence", "How the likeness grew while the drawing was fitted."],
};

// Rows of the table of figures and their words.
const FIGURE_WORDS = { Paths: "path", Levels: "level", gzipped: "gzip", Segments: "segment", Canvas: "canvas", "PSNR (resvg)": "psnr", SSIM: "ssim" };

/** Explains the first cells of the rows of the table of figures. */
function explainFigures(table) {
  for (const { cells } of table.rows) {
    const key = FIGURE_WORDS[cells[0].textContent];
    if (!key) continue;
    cells[0].title = WORDS[key][1];
    cells[0].setAttribute("aria-describedby", `word-${key}`);
  }
}

function connectWords() {
  for (const [key, [word, meaning]] of Object.entries(WORDS)) {
    const [term, text] = ["dt", "dd"].map((name) => document.createElement(name));
    [term.textContent, text.textContent, text.id] = [word, meaning, `word-${key}`];
    find("words").append(term, text);
  }
  for (const element of document.querySelectorAll("[data-word]")) {
    element.title ||= WORDS[element.dataset.word][1];
    const control = element.control ?? element.closest("label")?.control ?? document.getElementById(element.htmlFor) ?? element;
    control.setAttribute("aria-describedby", `word-${element.dataset.word}`);
  }
}
