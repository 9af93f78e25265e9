/** The least and the largest scale, in pixels per meter. */
const SCALES = [0.5, 800];

/** The view of the map: pixels = (scale x + tx, ty - scale y). */
export class View {
  scale = 40;
  tx = 0;
  ty = 0;
  width = 800;
  height = 600;

  /** Returns the place in the world, in meters, of a pixel on the map. */
  toWorld(px, py) {
    return [(px - this.tx) / this.scale, (this.ty - py) / this.scale];
  }

  toScreen(x, y) {
    return [this.scale * x + this.tx, this.ty - this.scale * y];
  }

  /** The center of the view, in meters. */
  get middle() {
    return this.toWorld(this.width / 2, this.height / 2);
  }

  get matrix() {
    return `matrix(${this.scale} 0 0 ${-this.scale} ${this.tx} ${this.ty})`;
  }

  pan(dx, dy) {
    this.tx += dx;
    this.ty += dy;
  }

  /** Zooms about a pixel. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toWorld(px, py);
    this.scale = Math.min(SCALES[1], Math.max(SCALES[0], this.scale * factor));
    this.tx = px - this.scale * x;
    this.ty = py + this.scale * y;
  }

  /** Shows a box [x0, y0, x1, y1] in meters, with a margin in pixels. */
  fit([x0, y0, x1, y1], margin = 48) {
    const [w, d] = [Math.max(x1 - x0, 2), Math.max(y1 - y0, 2)];
    const fitting = Math.min((this.width - 2 * margin) / w, (this.height - 2 * margin) / d);
    this.scale = Math.min(160, Math.max(SCALES[0], fitting));
    this.tx = this.width / 2 - (this.scale * (x0 + x1)) / 2;
    this.ty = this.height / 2 + (this.scale * (y0 + y1)) / 2;
  }

  /** Returns the lines of the grid as two SVG paths, fine and bold. */
  grid() {
    const step = [1, 5, 10, 50, 100, 500].find((it) => it * this.scale >= 9) ?? 1000;
    const [x0, y1] = this.toWorld(0, 0);
    const [x1, y0] = this.toWorld(this.width, this.height);
    const lines = ["", ""];
    for (let i = Math.floor(x0 / step); i <= x1 / step; i++) {
      lines[i % 5 ? 0 : 1] += `M${i * step} ${y0}V${y1}`;
    }
    for (let i = Math.floor(y0 / step); i <= y1 / step; i++) {
      lines[i % 5 ? 0 : 1] += `M${x0} ${i * step}H${x1}`;
    }
    return lines;
  }

  /** Returns a round length, in meters, of 60 to 150 pixels. */
  scaleLength() {
    const least = 60 / this.scale;
    const power = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map((it) => it * power).find((it) => it >= least);
  }
}
