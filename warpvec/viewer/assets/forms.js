/* Forms: circles, ellipses and rectangles, which stay what they are while they are moved, turned and scaled.
 *
 * A shape may have a `form` {element, x, y, first, second, angle, corner, text}: the centre, the radii or the sides, the
 * turn in degrees about the centre, the radius of the corners, and the attributes as they were read, or null. A shape
 * whose nodes are edited has none. */

import { ellipseData, rectangleData, rotation } from "viewer/basics.js";
import { formatNumber, parseShape, transformShape } from "viewer/paths.js";

// A transform that differs from a similarity by less leaves a form one.
const EVEN = 1e-6;

export const FORM_NAMES = { circle: "circle", ellipse: "ellipse", rect: "rectangle" };

const SIDES = { circle: ["cx", "cy", "r"], ellipse: ["cx", "cy", "rx", "ry"], rect: ["x", "y", "width", "height"] };

/** Returns the form of a basic shape under `matrix`; null if it is none. `own` is its transform if it alone moves it.
 *
 * @param {Element} element
 * @param {number[]} matrix
 * @param {string | null} own */
export function formOf(element, matrix, own) {
  const name = element.localName;
  if (!SIDES[name]) return null;
  const number = (side) => Number(element.getAttribute(side) ?? 0);
  const [x, y, first, second = first] = SIDES[name].map(number);
  const corners = ["rx", "ry"].map((side) => (name === "rect" && element.hasAttribute(side) ? number(side) : null));
  const corner = corners[0] ?? corners[1] ?? 0;
  if (![x, y, first, second, corner].every(Number.isFinite) || !(first > 0 && second > 0)) return null;
  if ((corners[1] ?? corner) !== corner) return null;
  const center = name === "rect" ? [x + first / 2, y + second / 2] : [x, y];
  const limited = Math.min(corner, first / 2, second / 2);
  const form = { element: name, x: center[0], y: center[1], first, second, angle: 0, corner: limited, text: null };
  const placed = transformForm(form, matrix);
  return placed && { ...placed, text: textAsRead(element, own) };
}

/** Returns the shape of a form. */
export function shapeOfForm(form) {
  const { element, x, y, first, second, angle, corner } = form;
  const isRect = element === "rect";
  const data = isRect
    ? rectangleData(x - first / 2, y - second / 2, first, second, corner, corner)
    : ellipseData(x, y, first, second);
  const turn = rotation((angle * Math.PI) / 180, x, y);
  return { ...transformShape(parseShape(data), turn), form };
}

/** Returns the attributes of an element that states numbers only, and turns about a point at most; else null. */
function textAsRead(element, own) {
  const sides = [...new Set([...SIDES[element.localName], "rx", "ry"])].filter((side) => element.hasAttribute(side));
  const isPlain = sides.every((side) => /^-?[\d.]+$/.test(element.getAttribute(side)));
  if (own === null || !isPlain || !/^(rotate\([-\d. ]+\))?$/.test(own)) return null;
  const text = sides.map((side) => ` ${side}="${element.getAttribute(side)}"`).join("");
  return own ? `${text} transform="${own}"` : text;
}

/** Returns the form after a transform; null if it is none any more.
 *
 * @param {any} form
 * @param {number[]} matrix */
export function transformForm(form, matrix) {
  if (!form) return null;
  const [a, b, c, d, e, f] = matrix;
  const center = { x: a * form.x + c * form.y + e, y: b * form.x + d * form.y + f, text: null };
  const [across, down] = [Math.hypot(a, b), Math.hypot(c, d)];
  const isRight = Math.abs(a * c + b * d) <= EVEN * across * down;
  if (!(across > 0 && down > 0) || !isRight) return null;
  if (Math.abs(across - down) <= EVEN * across) {
    const turn = (Math.atan2(b, a) * 180) / Math.PI;
    const angle = form.element === "circle" ? 0 : upright(a * d > b * c ? turn + form.angle : turn - form.angle);
    return { ...form, ...center, ...sized(form, across), angle };
  }
  const isLevel = b === 0 && c === 0 && form.angle === 0 && form.corner === 0;
  if (!isLevel) return null;
  const element = form.element === "circle" ? "ellipse" : form.element;
  return { ...form, ...center, element, first: form.first * across, second: form.second * down };
}

function sized({ first, second, corner }, scale) {
  return { first: first * scale, second: second * scale, corner: corner * scale };
}

/** Returns an angle in degrees in (-90, 90], which draws the same; one that is almost level is level. */
function upright(angle) {
  const turned = angle - 180 * Math.round(angle / 180);
  return Math.abs(turned) < 1e-9 ? 0 : turned;
}

/** Returns the attributes of a form with `decimals`, as warpvec/svg/form_elements.py writes them. */
export function writeForm(form, decimals) {
  if (form.text !== null) return form.text;
  const { element, x, y, first, second, angle, corner } = form;
  const step = 10 ** -decimals;
  const at = (value) => Math.round(value / step) * step;
  const sizes = [at(first), at(second)];
  const values = element === "rect" ? [at(x - first / 2), at(y - second / 2), ...sizes] : [at(x), at(y), ...sizes];
  const sides = SIDES[element].map((side, i) => ` ${side}="${formatNumber(values[i], decimals)}"`).join("");
  const radius = Math.min(at(corner), Math.floor(Math.min(...sizes) / 2 / step + 1e-6) * step);
  const rounded = formatNumber(radius, decimals);
  const round = element === "rect" && radius > 0 ? ` rx="${rounded}" ry="${rounded}"` : "";
  const degrees = formatNumber(angle, 3);
  if (degrees === "0") return sides + round;
  const center = element === "rect" ? [values[0] + sizes[0] / 2, values[1] + sizes[1] / 2] : values;
  const [cx, cy] = center.map((value) => formatNumber(value, decimals + 1));
  return `${sides}${round} transform="rotate(${degrees} ${cx} ${cy})"`;
}
