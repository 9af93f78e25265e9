import { fill, svg } from "./dom.js";
import { paintRobot } from "./looks.js";
import { behaviorOf, goalsOf, isPoint, isPose, slotsOf } from "./things.js";

/**
 * The drawings on the map, in meters, y up. Each keeps its elements
 * and changes them when its value does; `zoomed` when the scale does.
 */

/** The least half size of a click target, in pixels. */
const GRAB = 10;
/** The least diameter of people with names, in pixels. */
const TINY = 8;

/** Returns black or white, whichever has more contrast to a color. */
export function inkOn(color) {
  const parts = /^#(..)(..)(..)$/.exec(color)?.slice(1) ?? ["80", "80", "80"];
  const [r, g, b] = parts.map((it) => {
    const v = parseInt(it, 16) / 255;
    return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  });
  const light = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  return (light + 0.05) ** 2 > 1.05 * 0.05 ? "#10151c" : "#ffffff";
}

/** Returns the SVG path of points. */
export function outline(points, closed = true) {
  if (!points?.length) return "";
  return `M${points.map(([x, y]) => `${x} ${y}`).join("L")}${closed ? "Z" : ""}`;
}

function label(name, text = "") {
  return svg("text", { class: name, "text-anchor": "middle" }, text);
}

/** Places an upright text, with a size in meters. */
function write(text, x, y, size) {
  text.setAttribute("transform", `translate(${x} ${y}) scale(${size / 10} ${-size / 10})`);
}

const degrees = (angle) => (angle * 180) / Math.PI;
const focusable = (name, key) => ({ class: name, "data-key": key, tabindex: -1, role: "img" });

/** A person: a disc in the color of the behavior, its letter, and a nose. */
export class PersonShape {
  constructor(key) {
    this.hit = svg("circle", { class: "hit" });
    this.disc = svg("circle", { class: "disc" });
    this.ring = svg("circle", { class: "ring" });
    this.nose = svg("path", { class: "nose" });
    this.letter = label("letter");
    this.name = label("name");
    this.badge = svg("g", { class: "badge" }, svg("circle", { r: 6 }), svg("text", { "text-anchor": "middle", y: 3.6 }, "!"));
    this.body = svg("g", null, this.hit, this.ring, this.nose, this.disc, this.letter, this.name, this.badge);
    this.element = svg("g", focusable("person", key), this.body);
  }

  update(person, look, defaults) {
    this.pose = isPose(person.pose) ? person.pose : [...(isPoint(person.pose) ? person.pose.slice(0, 2) : [0, 0]), 0];
    this.element.style.display = isPoint(person.pose) ? "" : "none";
    this.radius = person.radius > 0 ? Math.min(person.radius, 5) : defaults.radius ?? 0.35;
    this.behavior = behaviorOf(person, defaults);
    const { color, letter } = look(this.behavior);
    this.element.style.setProperty("--who", color);
    this.element.style.setProperty("--ink", inkOn(color));
    this.letter.textContent = letter;
    this.title = person.name || "";
    this.body.setAttribute("transform", `translate(${this.pose[0]} ${this.pose[1]})`);
  }

  zoomed(scale) {
    const r = this.radius;
    const px = 1 / scale;
    this.disc.setAttribute("r", r);
    this.hit.setAttribute("r", Math.max(r, GRAB * px));
    this.ring.setAttribute("r", r + 3.5 * px);
    const tip = r + Math.max(0.5 * r, 7 * px);
    const yaw = degrees(this.pose[2]);
    this.nose.setAttribute("d", `M${0.5 * r} ${0.86 * r}L${tip} 0L${0.5 * r} ${-0.86 * r}Z`);
    this.nose.setAttribute("transform", `rotate(${yaw})`);
    const tiny = 2 * r * scale < TINY;
    this.element.classList.toggle("tiny", tiny);
    const size = (this.letter.textContent.length > 1 ? 0.95 : 1.15) * Math.min(r, 14 * px);
    write(this.letter, 0, -0.36 * size, size);
    write(this.name, 0, -r - 14 * px, 11 * px);
    const at = 0.8 * Math.max(r, 7 * px);
    this.badge.setAttribute("transform", `translate(${at} ${at}) scale(${px} ${-px})`);
    this.name.textContent = this.title.length > 24 ? `${this.title.slice(0, 23)}…` : this.title;
  }
}

/** The goals of a person, in order, and the path to them. */
export class ChainShape {
  constructor(key) {
    this.key = key;
    this.line = svg("path", { class: "way" });
    this.back = svg("path", { class: "way back" });
    this.hit = svg("path", { class: "way-hit", "data-chain": key });
    this.dots = [];
    this.places = svg("g");
    this.element = svg("g", { class: "chain" }, this.hit, this.line, this.back, this.places);
  }

  update(person, look, defaults) {
    const { color } = look(behaviorOf(person, defaults));
    this.element.style.setProperty("--who", color);
    this.element.style.setProperty("--ink", inkOn(color));
    this.goals = goalsOf(person);
    const points = this.goals.map(({ at }) => at);
    const all = isPoint(person.pose) ? [person.pose, ...points] : points;
    const d = points.length ? outline(all, false) : "";
    const cyclic = person.cyclic === true && points.length > 1;
    const back = cyclic ? outline([points.at(-1), points[0]], false) : "";
    this.line.setAttribute("d", d);
    this.back.setAttribute("d", back);
    this.hit.setAttribute("d", d + back);
    while (this.dots.length > this.goals.length) this.dots.pop().element.remove();
    this.goals.forEach(({ at, i }, n) => {
      if (!this.dots[n]) this.dots.push(this.#dot(n));
      const dot = this.dots[n];
      dot.element.setAttribute("data-key", `${this.key}/goals/${i}`);
      dot.element.setAttribute("transform", `translate(${at[0]} ${at[1]})`);
      dot.number.textContent = String(i + 1);
    });
  }

  #dot() {
    const hit = svg("circle", { class: "hit" });
    const disc = svg("circle", { class: "dot" });
    const number = label("number");
    const element = svg("g", focusable("goal", ""), hit, disc, number);
    this.places.append(element);
    return { element, hit, disc, number };
  }

  zoomed(scale) {
    const px = 1 / scale;
    for (const { hit, disc, number } of this.dots) {
      hit.setAttribute("r", GRAB * px);
      disc.setAttribute("r", 6.5 * px);
      write(number, 0, -3.1 * px, 9 * px);
    }
  }
}

/** The half size of a place, and the radius of its slots, in meters. */
const PLACE = 0.2;
const SLOT = 0.12;

/** A place: a square with the initial of its type, a nose, and its slots. */
export class PlaceShape {
  constructor(key) {
    this.slots = svg("path", { class: "slots" });
    this.hit = svg("circle", { class: "hit" });
    this.ring = svg("circle", { class: "ring" });
    this.nose = svg("path", { class: "nose" });
    this.disc = svg("path", { class: "disc" });
    this.letter = label("letter");
    this.name = label("name");
    this.badge = svg("g", { class: "badge" }, svg("circle", { r: 6 }), svg("text", { "text-anchor": "middle", y: 3.6 }, "!"));
    this.body = svg("g", null, this.hit, this.ring, this.nose, this.disc, this.letter, this.name, this.badge);
    this.element = svg("g", focusable("place", key), this.slots, this.body);
  }

  update(place, name) {
    const at = isPoint(place.pose) ? place.pose : [0, 0];
    this.yaw = isPose(place.pose) ? place.pose[2] : 0;
    this.element.style.display = isPoint(place.pose) ? "" : "none";
    this.letter.textContent = String(place.type ?? "point").slice(0, 1).toUpperCase();
    this.title = name;
    this.body.setAttribute("transform", `translate(${at[0]} ${at[1]})`);
    const circle = ([x, y]) => `M${x - SLOT} ${y}a${SLOT} ${SLOT} 0 1 0 ${2 * SLOT} 0a${SLOT} ${SLOT} 0 1 0 ${-2 * SLOT} 0`;
    this.slots.setAttribute("d", slotsOf(place).map((it) => `${outline([at, it], false)}${circle(it)}`).join(""));
  }

  zoomed(scale) {
    const px = 1 / scale;
    const r = Math.max(PLACE, 7 * px);
    this.hit.setAttribute("r", Math.max(r, GRAB * px));
    this.ring.setAttribute("r", 1.42 * r + 3 * px);
    this.disc.setAttribute("d", `M${-r} ${-r}h${2 * r}v${2 * r}h${-2 * r}Z`);
    this.nose.setAttribute("d", `M${r} ${0.7 * r}L${1.8 * r} 0L${r} ${-0.7 * r}Z`);
    this.nose.setAttribute("transform", `rotate(${degrees(this.yaw)})`);
    write(this.letter, 0, -0.42 * r, 1.2 * r);
    write(this.name, 0, -r - 14 * px, 11 * px);
    this.name.textContent = this.title.length > 24 ? `${this.title.slice(0, 23)}…` : this.title;
    this.badge.setAttribute("transform", `translate(${r} ${r}) scale(${px} ${-px})`);
  }
}

/** The start or the goal of the robot. */
export class RobotShape {
  constructor(key, isGoal) {
    this.isGoal = isGoal;
    this.hit = svg("circle", { class: "hit" });
    this.ring = svg("circle", { class: "ring" });
    this.disc = svg("path", { class: "disc" });
    this.nose = svg("path", { class: "nose" });
    this.name = label("name");
    this.badge = svg("g", { class: "badge" }, svg("circle", { r: 6 }), svg("text", { "text-anchor": "middle", y: 3.6 }, "!"));
    this.element = svg(
      "g",
      focusable(isGoal ? "robot robot-goal" : "robot", key),
      this.hit,
      this.ring,
      this.disc,
      this.nose,
      this.name,
      this.badge,
    );
  }

  update(pose, radius, name, color) {
    // Robots that swap places have their names below, and those of goals above.
    this.isAbove = this.isGoal && name !== "goal";
    this.pose = pose;
    this.radius = radius;
    this.name.textContent = name;
    paintRobot(this.element, color);
    this.element.setAttribute("transform", `translate(${pose[0]} ${pose[1]})`);
  }

  zoomed(scale) {
    const r = this.radius;
    const px = 1 / scale;
    const yaw = degrees(this.pose[2] ?? 0);
    this.hit.setAttribute("r", Math.max(r, GRAB * px));
    this.ring.setAttribute("r", r + 3.5 * px);
    this.disc.setAttribute("d", `M${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`);
    const wedge = `M${0.72 * r} 0L${-0.3 * r} ${0.5 * r}L${-0.08 * r} 0L${-0.3 * r} ${-0.5 * r}Z`;
    this.nose.setAttribute("d", wedge);
    this.nose.setAttribute("transform", `rotate(${yaw})`);
    write(this.name, 0, this.isAbove ? r + 6 * px : -r - 14 * px, 11 * px);
    const at = 0.8 * Math.max(r, 7 * px);
    this.badge.setAttribute("transform", `translate(${at} ${at}) scale(${px} ${-px})`);
    this.element.classList.toggle("tiny", 2 * r * scale < TINY);
  }
}

/** Returns the drawings of pieces of furniture, from the lowest one up. */
export const piecesOf = (pieces) =>
  pieces.map(([material, points], i) => {
    // What lies on the same material, as the back of a chair, is darker.
    const isOver = pieces.slice(0, i).some(([other]) => other === material);
    return svg("path", { class: isOver ? "piece over" : "piece", "data-material": material, d: outline(points) });
  });

/** A wall or a piece of furniture: the latter from above, with its kind. */
export class WorldShape {
  constructor(key) {
    this.path = svg("path", { class: "shape" });
    this.hit = svg("path", { class: "thin-hit" });
    this.pieces = svg("g", { class: "pieces" });
    this.name = label("name kind");
    this.badge = svg("g", { class: "badge" }, svg("circle", { r: 6 }), svg("text", { "text-anchor": "middle", y: 3.6 }, "!"));
    const name = key.startsWith("world/") ? "fixture" : "area";
    this.element = svg("g", focusable(name, key), this.path, this.badge);
  }

  update({ points, parts, closed, kind, height, pieces = [] }) {
    const all = parts ?? [points];
    const d = all.map((it) => outline(it, closed)).join("");
    this.path.setAttribute("d", d);
    this.at = points?.[0] ?? [0, 0];
    const [xs, ys] = [0, 1].map((axis) => all.flat().map((it) => it[axis]));
    this.box = [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
    this.element.setAttribute("data-kind", kind ?? "");
    this.element.classList.toggle("thin", !closed);
    this.element.classList.toggle("low", height < 1.2);
    this.hit.setAttribute("d", d);
    fill(this.pieces, piecesOf(pieces));
    this.name.textContent = pieces.length ? String(kind).replace(/_/g, " ") : "";
    fill(this.element, ...(closed ? [] : [this.hit]), this.path, ...(pieces.length ? [this.pieces, this.name] : []), this.badge);
  }

  zoomed(scale) {
    this.badge.setAttribute("transform", `translate(${this.at[0]} ${this.at[1]}) scale(${1 / scale} ${-1 / scale})`);
    const { textContent: text } = this.name;
    if (!text) return;
    const [x0, y0, x1, y1] = this.box;
    // Where there is no room, it shows under the mouse and when it is selected.
    this.element.classList.toggle("crowded", (x1 - x0) * scale < 5.6 * text.length + 4 || (y1 - y0) * scale < 14);
    write(this.name, (x0 + x1) / 2, (y0 + y1) / 2 - 3.4 / scale, 10 / scale);
  }
}
