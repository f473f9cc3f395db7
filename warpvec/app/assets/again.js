/* What has been taken out of a drawing since its last fit: the shapes of deleted paths are filled in by the next one. */

/** Returns the paths of an SVG text in order, as {d, paint, element}. */
function pathsOf(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
  return [...parsed.querySelectorAll("path")].map((element) => {
    const paint = ["fill", "fill-opacity", "stroke"].map((name) => element.getAttribute(name) ?? "").join(" ");
    return { d: element.getAttribute("d") ?? "", paint, rule: element.getAttribute("fill-rule") };
  });
}

/** Returns an SVG text of the paths of `before` that `after` has lost; null if there are none.
 *
 * A path of which only the form or the paint has changed is not lost. Each path that is new in `after` stands for one
 * that is gone, if possible one of the same paint. */
function erasedShapes(before, after, size) {
  const present = new Set(pathsOf(after).map(({ d }) => d));
  const old = pathsOf(before);
  const known = new Set(old.map(({ d }) => d));
  const changed = pathsOf(after).filter(({ d }) => !known.has(d));
  const gone = old.filter(({ d }) => !present.has(d));
  for (const { paint } of changed) {
    const same = gone.findIndex((path) => path.paint === paint);
    gone.splice(Math.max(same, 0), 1);
  }
  if (!gone.length) return null;
  const rule = (path) => (path.rule ? ` fill-rule="${path.rule}"` : "");
  const lines = gone.map((path) => `<path${rule(path)} d="${path.d.replace(/[&<"]/g, "")}"/>`);
  return emptyDrawing(size).replace("/>", `>${lines.join("")}</svg>`);
}
