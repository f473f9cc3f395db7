/* The handles of a form on the picture, and what they do: the centre moves it, the others change its size. */

// Sizes stay larger, in user units: a form without a size is not drawn, and could not be taken again.
const SIZE_MIN = 0.01;
// The handle of round corners lies on the upper side, this share of the shorter side before the corner's own handle.
const CORNER_GAP = 0.12;
// Directions of the rim from the centre: right, below, left, above.
const RIM = [[1, 0], [0, 1], [-1, 0], [0, -1]];
// Corners clockwise on screen from the left top.
const CORNERS = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
const NAMES = {
  rim: ["Centre", "Rim at the right", "Rim below", "Rim at the left", "Rim above"],
  rect: ["Centre", "Left upper corner", "Right upper corner", "Right lower corner", "Left lower corner", "Round corners"],
};

/** Returns the handles {x, y, name} of a form: its centre, then its rim or its corners, last that of round corners. */
export function formPoints(form) {
  const names = form.element === "rect" ? NAMES.rect : NAMES.rim;
  return levelPoints(form).map((point, i) => {
    const [dx, dy] = turned(point, form.angle);
    return { x: form.x + dx, y: form.y + dy, name: names[i] };
  });
}

/** Returns the handles relative to the centre, before the form is turned. */
function levelPoints({ element, first, second, corner }) {
  if (element !== "rect") return [[0, 0], ...RIM.map(([u, v]) => [u * first, v * second])];
  const [x, y] = [first / 2, second / 2];
  const inner = x - corner - CORNER_GAP * Math.min(first, second);
  return [[0, 0], ...CORNERS.map(([u, v]) => [u * x, v * y]), [inner, -y]];
}

/** Returns a form after its handle `index` was moved: the opposite corner of a rectangle stays, the centre of others. */
export function moveFormPoint(form, index, dx, dy) {
  const { element, angle } = form;
  if (index === 0) return changedForm(form, { x: form.x + dx, y: form.y + dy });
  const by = turned([dx, dy], -angle);
  if (element === "circle") return changedForm(form, { first: lengthAfter(form, index, by) });
  if (element === "ellipse") return changedForm(form, stretched(form, RIM[index - 1], by));
  if (index > CORNERS.length) return changedForm(form, { corner: form.corner - by[0] });
  return withCorner(form, CORNERS[index - 1], by);
}

function lengthAfter(form, index, by) {
  const [x, y] = levelPoints(form)[index];
  return Math.hypot(x + by[0], y + by[1]);
}

/** Changes the radius along which the rim was moved.
 *
 * @param {any} form
 * @param {number[]} direction
 * @param {number[]} by */
function stretched({ first, second }, [u, v], [dx, dy]) {
  return u ? { first: first + u * dx } : { second: second + v * dy };
}

/** Moves one corner; the opposite one stays.
 *
 * @param {any} form
 * @param {number[]} corner
 * @param {number[]} by */
function withCorner(form, [u, v], [dx, dy]) {
  const sized = changedForm(form, { first: form.first + u * dx, second: form.second + v * dy });
  const half = [(u * (sized.first - form.first)) / 2, (v * (sized.second - form.second)) / 2];
  const [x, y] = turned(half, form.angle);
  return { ...sized, x: form.x + x, y: form.y + y };
}

/** Returns a form with other numbers, within their bounds; the radii of a circle are one.
 *
 * @param {any} form
 * @param {{x?: number, y?: number, first?: number, second?: number, angle?: number, corner?: number}} change */
export function changedForm(form, change) {
  const next = { ...form, ...change, text: null };
  next.first = Math.max(next.first, SIZE_MIN);
  next.second = form.element === "circle" ? next.first : Math.max(next.second, SIZE_MIN);
  next.corner = form.element === "rect" ? Math.min(Math.max(next.corner, 0), next.first / 2, next.second / 2) : 0;
  if (form.element === "circle") next.angle = 0;
  return next;
}

/**
 * @param {number[]} vector
 * @param {number} degrees */
function turned([x, y], degrees) {
  const [cos, sin] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [cos * x - sin * y, sin * x + cos * y];
}
