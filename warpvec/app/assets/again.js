/* What has been taken out of a drawing since its last fit: the shapes of deleted paths are filled in by the next one. */

/** Returns the paths of an SVG text in order, as {d, paint, rule}. */
function pathsOf(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
  return [...parsed.querySelectorAll("path")].map((element) => {
    const paint = ["fill", "fill-opacity", "stroke"].map((name) => element.getAttribute(name) ?? "").join(" ");
    return { d: element.getAttribute("d") ?? "", paint, rule: element.getAttribute("fill-rule") };
  });
}

/** Returns the paths of `before` that `after` has lost.
 *
 * A path of which only the form or the paint has changed is not lost. Each path that is new in `after` stands for one
 * that is gone, if possible one of the same paint. */
function lostPaths(before, after) {
  const now = pathsOf(after);
  const present = new Set(now.map(({ d }) => d));
  const old = pathsOf(before);
  const known = new Set(old.map(({ d }) => d));
  const gone = old.filter(({ d }) => !present.has(d));
  for (const { paint } of now.filter(({ d }) => !known.has(d))) {
    const same = gone.findIndex((path) => path.paint === paint);
    gone.splice(Math.max(same, 0), 1);
  }
  return gone;
}

/** Returns those of `paths` that the drawing `text` does not have: undone deletions are none. */
function stillLost(paths, text) {
  const present = new Set(pathsOf(text).map(({ d }) => d));
  return paths.filter(({ d }) => !present.has(d));
}

/** Returns an SVG text of `paths` for a picture of that size; null without any. */
function shapesText(paths, size) {
  if (!paths.length) return null;
  const rule = (path) => (path.rule ? ` fill-rule="${path.rule}"` : "");
  const lines = paths.map((path) => `<path${rule(path)} d="${path.d.replace(/[&<"]/g, "")}"/>`);
  return emptyDrawing(size).replace("/>", `>${lines.join("")}</svg>`);
}
