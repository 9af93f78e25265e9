import { fill, svg } from "./dom.js";
import { behaviorOf, peopleOf, robotsOf } from "./things.js";
import { valueAt } from "./data.js";
import { paintRobot, robotColor } from "./looks.js";
import { endOf } from "./runtable.js";
import { inkOn, outline } from "./shapes.js";

/** The number of points in the trail of a body during a run. */
const TRAIL = 60;

const degrees = (angle) => (angle * 180) / Math.PI;

/** A body of a run, with its pose and its path. */
class Ghost {
  constructor(isRobot) {
    this.trail = [];
    this.line = svg("path", { class: isRobot ? "ghost-way of-robot" : "ghost-way" });
    this.disc = svg("circle", { class: isRobot ? "ghost of-robot" : "ghost" });
    this.nose = svg("path", { class: isRobot ? "ghost-nose of-robot" : "ghost-nose" });
    this.body = svg("g", { class: "ghost-body" }, this.disc, this.nose);
  }

  look(color, radius, reacts) {
    for (const element of [this.line, this.body]) {
      element.style.setProperty("--who", color);
      element.style.setProperty("--ink", inkOn(color));
    }
    this.disc.setAttribute("r", radius);
    const r = 0.62 * radius;
    this.nose.setAttribute("d", `M${-0.5 * r} ${0.7 * r}L${r} 0L${-0.5 * r} ${-0.7 * r}`);
    this.body.classList.toggle("reacts", reacts);
  }

  /** Sets its pose; null hides it. */
  put(pose) {
    this.body.style.display = pose ? "" : "none";
    if (pose) this.body.setAttribute("transform", `translate(${pose[0]} ${pose[1]}) rotate(${degrees(pose[2])})`);
  }

  /** Moves it to a pose, with its trail. */
  follow(pose) {
    this.put(pose);
    if (pose) this.trail.push(pose);
    if (!pose || this.trail.length > TRAIL) this.trail.shift();
    this.line.setAttribute("d", this.trail.length > 1 ? outline(this.trail, false) : "");
  }
}

function between(a, b, share) {
  if (!a || !b) return a ?? b;
  let turn = b[2] - a[2];
  turn -= 2 * Math.PI * Math.round(turn / (2 * Math.PI));
  return [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * turn];
}

/** Marks the place where a robot ended before its goal, with the reason. */
function endMark({ robot, reason, message, at: [x, y] }) {
  const text = [robot, endOf({ end_reason: reason })].filter(Boolean).join(": ");
  const mark = svg(
    "g",
    { class: "end-mark" },
    svg("title", null, message ? `${text}: ${message}` : text),
    svg("path", { d: "M-7 -7L7 7M-7 7L7 -7" }),
    svg("text", { "text-anchor": "middle", y: 22 }, text),
  );
  mark.style.transform = `translate(${x}px, ${y}px) scale(var(--px), calc(-1 * var(--px)))`;
  return mark;
}

/**
 * Draws a run over the map: live bodies during the run, and afterwards whole
 * paths with the bodies at a chosen time.
 */
export function makeGhosts(store, overlaid = "") {
  // A run that is laid over another one has one color, and is pale.
  const also = overlaid ? " overlaid" : "";
  const ways = svg("g", { class: `ghost-ways${also}` });
  const bodies = svg("g", { class: `ghost-bodies${also}` });
  const ends = svg("g", { class: `ghost-ends${also}` });
  for (const it of overlaid ? [ways, bodies, ends] : []) it.style.setProperty("--run", overlaid);
  let ghosts = [];
  // The number of robots, which are the first ghosts.
  let count = 1;
  let paths = null;
  let run = null;

  function prepare(robots, people) {
    if (ghosts.length !== robots + people || count !== robots) {
      count = robots;
      ghosts = Array.from({ length: robots + people }, (_, i) => new Ghost(i < robots));
      fill(ways, ...ghosts.map((it) => it.line).reverse());
      fill(bodies, ...ghosts.map((it) => it.body).reverse());
    }
    // The chosen run is above the others.
    if (!ways.isConnected) store.ghosts[overlaid ? "prepend" : "append"](ways, bodies, ends);
    store.dim(true);
  }

  function dress(activities = []) {
    const { data, catalog } = store;
    const people = peopleOf(data);
    const defaults = catalog.defaults?.human ?? {};
    const colors = new Map((catalog.behaviors ?? []).map((it) => [it.name, it.color]));
    ghosts.forEach((ghost, i) => {
      if (i < count) {
        const radius = valueAt(data, [...(robotsOf(data)[i] ?? []), "radius"]) ?? catalog.defaults?.robot?.radius ?? 0.35;
        for (const element of [ghost.line, ghost.body]) paintRobot(element, overlaid || robotColor(catalog, i, count));
        return ghost.look("#1c2530", radius, false);
      }
      const person = people[i - count] ?? {};
      const radius = person.radius ?? defaults.radius ?? 0.35;
      return ghost.look(colors.get(behaviorOf(person, defaults)) ?? "#6b7a8c", radius, Boolean(activities[i - count]));
    });
  }

  return {
    /** Shows a frame of a running run. */
    frame(message) {
      prepare(message.robots.length, message.people.length);
      if (run !== message.run || paths) {
        run = message.run;
        paths = null;
        fill(ends);
        for (const ghost of ghosts) ghost.trail = [];
      }
      dress(message.activities);
      [...message.robots, ...message.people].forEach((pose, i) => ghosts[i].follow(pose));
    },

    /** Shows the paths of a finished run, and where robots ended too early. */
    paths(number, given, early = []) {
      run = number;
      fill(ends, early.map(endMark));
      paths = given;
      prepare(given.robots[0].length, given.people[0]?.length ?? 0);
      dress();
      ghosts.forEach((ghost, i) => {
        const places = given.times.map((_, k) => [...given.robots[k], ...given.people[k]][i]);
        let d = "";
        let piece = [];
        for (const place of [...places, null]) {
          if (place) {
            piece.push(place);
          } else {
            if (piece.length > 1) d += outline(piece, false);
            piece = [];
          }
        }
        ghost.trail = [];
        ghost.line.setAttribute("d", d);
      });
    },

    /** Moves all bodies to their poses at a time, in seconds. */
    at(time) {
      if (!paths) return;
      const { times } = paths;
      let k = times.findIndex((it) => it > time);
      if (k < 0) k = times.length - 1;
      const i = Math.max(k - 1, 0);
      const share = k > i ? Math.min((time - times[i]) / (times[k] - times[i]), 1) : 0;
      const poses = (n) => [...paths.robots[n], ...paths.people[n]];
      const [a, b] = [poses(i), poses(k)];
      ghosts.forEach((ghost, n) => ghost.put(between(a[n], b[n], share)));
    },

    /** Removes everything. */
    clear() {
      for (const it of [ways, bodies, ends]) it.remove();
      paths = null;
      run = null;
      if (!overlaid) store.dim(false);
    },
  };
}
