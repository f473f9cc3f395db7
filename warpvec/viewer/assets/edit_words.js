/* The edits of a drawing in words. */

import { counted } from "viewer/charts.js";

/** Returns what edits are in words: "1 moved shape, 2 colours". */
export function editsInWords(edits) {
  const words = edits.map((edit) => {
    if (edit.kind !== "change") return KIND_WORDS[edit.kind];
    if (edit.erased) return "erased part";
    if (edit.isMoved) return edit.matrix ? "moved shape" : "changed outline";
    return edit.isPainted ? "coloured shape" : "changed look";
  });
  const counts = [...new Set(words)].filter(Boolean).map((word) => counted(words.filter((other) => other === word).length, word));
  return [...(edits.some(({ kind }) => kind === "opened") ? ["the edits in the opened file"] : []), ...counts].join(", ");
}

const KIND_WORDS = {
  color: "replaced colour", background: "background", size: "size", delete: "deleted shape", add: "added shape",
  order: "shape in another order", layer: "name of a layer", layers: "arrangement of layers",
};
