/* Follows the commands of path data and collects cubics (SVG 1.1, section 8.3). */

const NUMBER = "[-+]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eE][-+]?\\d+)?";
export const NUMBERS = new RegExp(NUMBER, "g");
const GAP = "[\\s,]*";
// The flags of an arc are single digits that need no separator.
const ARC = new RegExp([NUMBER, NUMBER, NUMBER, "[01]", "[01]", NUMBER, NUMBER].map((part) => `(${part})`).join(GAP), "g");
export const COMMAND = /([MLHVCSQTAZ])([^MLHVCSQTAZ]*)/gi;
const ARGUMENTS = { M: 2, L: 2, H: 1, V: 1, C: 6, S: 4, Q: 4, T: 2, A: 7 };

export class Pen {
  subpaths = [];
  points = null;
  kinds = [];
  x = 0;
  y = 0;
  startX = 0;
  startY = 0;
  // The last handle, which a smooth command mirrors, and the kind of its curve.
  handleX = 0;
  handleY = 0;
  handleOf = "";

  /** Runs a command with any number of argument sets; an incomplete last set is ignored. */
  command(letter, text) {
    const name = letter.toUpperCase();
    if (name === "Z") {
      this.close();
      return;
    }
    const sets = name === "A" ? [...text.matchAll(ARC)].map((match) => match.slice(1).map(Number)) : null;
    const numbers = sets ? sets.flat() : (text.match(NUMBERS) ?? []).map(Number);
    const size = ARGUMENTS[name];
    for (let i = 0; i + size <= numbers.length; i += size) {
      // The pairs after the first one of a move are lines.
      this.step(name === "M" && i ? "L" : name, numbers.slice(i, i + size), letter !== name);
    }
  }

  step(name, n, relative) {
    const [x, y] = relative ? [this.x, this.y] : [0, 0];
    if (name === "M") this.move(n[0] + x, n[1] + y);
    else if (name === "L") this.line(n[0] + x, n[1] + y);
    else if (name === "H") this.line(n[0] + x, this.y);
    else if (name === "V") this.line(this.x, n[0] + y);
    else if (name === "C") this.cubic(n[0] + x, n[1] + y, n[2] + x, n[3] + y, n[4] + x, n[5] + y);
    else if (name === "S") this.cubic(...this.mirrored("C"), n[0] + x, n[1] + y, n[2] + x, n[3] + y, "s");
    else if (name === "Q") this.quadratic(n[0] + x, n[1] + y, n[2] + x, n[3] + y);
    else if (name === "T") this.quadratic(...this.mirrored("Q"), n[0] + x, n[1] + y);
    else this.arc(n[0], n[1], n[2], n[3], n[4], n[5] + x, n[6] + y);
  }

  move(x, y) {
    this.finish(false);
    [this.x, this.y, this.startX, this.startY] = [x, y, x, y];
    this.handleOf = "";
  }

  line(x, y) {
    const [dx, dy] = [(x - this.x) / 3, (y - this.y) / 3];
    this.cubic(this.x + dx, this.y + dy, x - dx, y - dy, x, y, "l");
    this.handleOf = "";
  }

  cubic(x1, y1, x2, y2, x, y, kind = "c") {
    this.points ??= [this.x, this.y];
    this.kinds.push(kind);
    this.points.push(x1, y1, x2, y2, x, y);
    [this.handleX, this.handleY, this.handleOf, this.x, this.y] = [x2, y2, "C", x, y];
  }

  quadratic(hx, hy, x, y) {
    const third = (from, to) => from + (2 / 3) * (to - from);
    this.cubic(third(this.x, hx), third(this.y, hy), third(x, hx), third(y, hy), x, y);
    [this.handleX, this.handleY, this.handleOf] = [hx, hy, "Q"];
  }

  mirrored(kind) {
    return this.handleOf === kind ? [2 * this.x - this.handleX, 2 * this.y - this.handleY] : [this.x, this.y];
  }

  /** Converts end points to centre and angles (SVG 1.1, appendix F.6.5); draws one cubic per quarter turn at most. */
  arc(radiusX, radiusY, degrees, large, sweep, x, y) {
    let [rx, ry] = [Math.abs(radiusX), Math.abs(radiusY)];
    if (!rx || !ry) {
      this.line(x, y);
      return;
    }
    if (x === this.x && y === this.y) return;
    const [cos, sin] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
    const [hx, hy] = [(this.x - x) / 2, (this.y - y) / 2];
    const [ux, uy] = [cos * hx + sin * hy, cos * hy - sin * hx];
    const excess = Math.sqrt((ux / rx) ** 2 + (uy / ry) ** 2);
    if (excess > 1) [rx, ry] = [rx * excess, ry * excess];
    const span = (rx * uy) ** 2 + (ry * ux) ** 2;
    const factor = (large === sweep ? -1 : 1) * Math.sqrt(Math.max((rx * ry) ** 2 / span - 1, 0));
    const [vx, vy] = [(factor * rx * uy) / ry, (-factor * ry * ux) / rx];
    const first = Math.atan2((uy - vy) / ry, (ux - vx) / rx);
    let turn = Math.atan2((-uy - vy) / ry, (-ux - vx) / rx) - first;
    if (sweep && turn < 0) turn += 2 * Math.PI;
    if (!sweep && turn > 0) turn -= 2 * Math.PI;
    const center = [cos * vx - sin * vy + (this.x + x) / 2, sin * vx + cos * vy + (this.y + y) / 2];
    this.ellipse([cos * rx, sin * rx, -sin * ry, cos * ry, ...center], first, turn, x, y);
  }

  /** Draws an arc of the unit circle from the angle `first` over `turn`, transformed by a matrix, that ends at x, y.
   *
   * @param {number[]} matrix
   * @param {number} first
   * @param {number} turn
   * @param {number} x
   * @param {number} y */
  ellipse([a, b, c, d, e, f], first, turn, x, y) {
    const count = Math.max(Math.ceil(Math.abs(turn) / (Math.PI / 2) - 1e-9), 1);
    const step = turn / count;
    const length = (4 / 3) * Math.tan(step / 4);
    for (let i = 0; i < count; i++) {
      const [from, to] = [first + i * step, first + (i + 1) * step];
      const unit = [
        [Math.cos(from) - length * Math.sin(from), Math.sin(from) + length * Math.cos(from)],
        [Math.cos(to) + length * Math.sin(to), Math.sin(to) - length * Math.cos(to)],
        [Math.cos(to), Math.sin(to)],
      ];
      const placed = unit.flatMap(([u, v]) => [a * u + c * v + e, b * u + d * v + f]);
      if (i === count - 1) placed.splice(4, 2, x, y);
      this.cubic(...placed);
    }
    this.handleOf = "";
  }

  close() {
    if (this.points && Math.hypot(this.x - this.startX, this.y - this.startY) > 1e-6) {
      this.line(this.startX, this.startY);
    }
    this.finish(true);
    [this.x, this.y, this.handleOf] = [this.startX, this.startY, ""];
  }

  finish(closed) {
    const { points: p, kinds } = this;
    [this.points, this.kinds] = [null, []];
    if (!p || !p.every(Number.isFinite)) return;
    if (closed) p.splice(-2, 2, p[0], p[1]);
    this.subpaths.push({ points: Float64Array.from(p), closed, kinds });
  }

  finished() {
    this.finish(false);
    return this.subpaths;
  }
}
