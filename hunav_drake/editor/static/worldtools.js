import { svg } from "./dom.js";
import { round, valueAt } from "./data.js";
import { isPoint } from "./things.js";
import { freeName, segmentAt } from "./changes.js";
import { outline } from "./shapes.js";
import { addParts, corners, discCorners, newName } from "./newparts.js";
import { furnitureTool } from "./furniture.js";

/** The thickness of the walls of a room, and the width of a door, in meters. */
const THICK = 0.15;
const DOOR = 0.9;

const WALLS = ["world", "walls"];

/** A line of corners, one for each click. */
function lineTool(store, map, face, { shape, least, closes }) {
  let points = [];
  const draw = (to = null) => {
    const all = to ? [...points, to] : points;
    map.sketch.replaceChildren(
      svg("path", { class: closes && all.length > 2 ? "sketch-area" : "sketch-line", d: outline(all, closes && all.length > 2) }),
      ...points.map(([x, y]) => svg("circle", { class: "sketch-corner", cx: x, cy: y, r: 4 / map.scale })),
    );
  };
  return {
    ...face,
    corners: true,
    hint: `Click the corners. Backspace removes the last one; Enter or a double click ends.`,
    down(place, event) {
      const near = points.length >= least && Math.hypot(place[0] - points[0][0], place[1] - points[0][1]) * map.scale < 10;
      if (event.detail > 1 || (closes && near)) return this.finish(), null;
      points.push(place);
      draw();
      return null;
    },
    hover: (place) => points.length && draw(place),
    back() {
      points.pop();
      draw();
    },
    finish() {
      const had = points.length > 0;
      if (points.length >= least) {
        const called = newName(store, WALLS, face.name);
        const value = { type: shape, name: called, points };
        addParts(store, `Add ${called}`, [{ list: WALLS, value }], [{ points, closed: closes, kind: shape, height: 2.5 }]);
      }
      this.leave();
      return had ? null : false;
    },
    leave() {
      points = [];
      map.sketch.replaceChildren();
    },
  };
}

/** An area from corner to corner. */
const BOX = {
  type: "box",
  area(a, b) {
    const center = [round((a[0] + b[0]) / 2), round((a[1] + b[1]) / 2)];
    const size = [round(Math.abs(a[0] - b[0])), round(Math.abs(a[1] - b[1]))];
    return { center, size };
  },
  width: (box) => Math.min(...box.size),
  text: ({ size }) => `${size[0].toFixed(2)} × ${size[1].toFixed(2)} m`,
  corners,
};

/** An area from a center to its rim. */
const DISC = {
  type: "disc",
  area: (a, b) => ({ center: a.map(round), radius: round(Math.hypot(b[0] - a[0], b[1] - a[1])) }),
  width: (disc) => 2 * disc.radius,
  text: ({ radius }) => `radius ${radius.toFixed(2)} m`,
  corners: discCorners,
};

/** A shape pulled over the floor: a box, a disc, or a room of four walls. */
function areaTool(store, map, face, partsFor, shape = BOX) {
  let first = null;
  const { area } = shape;
  const path = (a, b) => svg("path", { class: "sketch-area", d: outline(shape.corners(area(a, b))) });
  function end(a, b) {
    map.sketch.replaceChildren();
    const pulled = area(a, b);
    if (shape.width(pulled) < 0.05) return;
    const [label, values] = partsFor(pulled);
    const parts = values.map((value) => ({ list: WALLS, value: { type: shape.type, ...value } }));
    addParts(store, label, parts, values.map((it) => ({ points: shape.corners(it), closed: true, kind: shape.type, height: 2.5 })));
    store.tools.choose("select");
  }
  return {
    ...face,
    corners: true,
    down(place, event) {
      // With the keyboard, each press sets a corner.
      if (!event.pointerId) {
        if (first) end(first, place);
        first = first ? null : place;
        return null;
      }
      let to = place;
      return {
        move(now) {
          const at = map.view.toWorld(...map.pixels(now));
          to = store.snapped(at, now, { corners: true });
          map.sketch.replaceChildren(path(place, to));
          store.tell("hint", { text: shape.text(area(place, to)) });
        },
        end: () => end(place, to),
        cancel: () => map.sketch.replaceChildren(),
      };
    },
    hover: (place) => first && map.sketch.replaceChildren(path(first, place)),
    finish: () => false,
    leave: () => (first = null),
  };
}

function roomParts(store, { center: [x, y], size: [w, d] }) {
  const name = newName(store, WALLS, "room_north").replace("_north", "");
  const wide = round(w + THICK);
  const deep = round(d - THICK);
  const [dx, dy] = [w / 2, d / 2];
  const wall = (side, cx, cy, size) => ({ name: `${name.replace(/(_\d+)?$/, "")}_${side}${/_\d+$/.exec(name)?.[0] ?? ""}`, center: [round(cx), round(cy)], size });
  return [
    `Add a room`,
    [
      wall("north", x, y + dy, [wide, THICK]),
      wall("south", x, y - dy, [wide, THICK]),
      wall("east", x + dx, y, [THICK, deep]),
      wall("west", x - dx, y, [THICK, deep]),
    ],
  ];
}

/** Returns the parts of a wall on both sides of a door, or null. */
function withDoor(wall, place) {
  if (Array.isArray(wall.points)) {
    const { points } = wall;
    const { index } = segmentAt(points, place);
    if (wall.type !== "polyline" || index >= points.length) return null;
    const [a, b] = [points[index - 1], points[index]];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (length < DOOR + 0.2) return null;
    const t = ((place[0] - a[0]) * (b[0] - a[0]) + (place[1] - a[1]) * (b[1] - a[1])) / length;
    const from = Math.min(length - DOOR - 0.1, Math.max(0.1, t - DOOR / 2));
    const at = (s) => [0, 1].map((i) => round(a[i] + (s / length) * (b[i] - a[i])));
    return [
      { ...wall, points: [...points.slice(0, index), at(from)] },
      { ...wall, points: [at(from + DOOR), ...points.slice(index)] },
    ];
  }
  if (!isPoint(wall.center) || !isPoint(wall.size)) return null;
  const axis = wall.size[0] >= wall.size[1] ? 0 : 1;
  const length = wall.size[axis];
  if (length < DOOR + 0.2) return null;
  const yaw = (wall.yaw ?? 0) + (axis ? Math.PI / 2 : 0);
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const t = (place[0] - wall.center[0]) * c + (place[1] - wall.center[1]) * s;
  const middle = Math.max(-length / 2 + DOOR / 2 + 0.1, Math.min(length / 2 - DOOR / 2 - 0.1, t));
  const piece = (low, high) => {
    const size = [...wall.size];
    size[axis] = round(high - low);
    const m = (low + high) / 2;
    return { ...wall, center: [round(wall.center[0] + m * c), round(wall.center[1] + m * s)], size };
  };
  return [piece(-length / 2, middle - DOOR / 2), piece(middle + DOOR / 2, length / 2)];
}

function doorTool(store) {
  return {
    name: "door",
    title: "Door",
    icon: "door",
    key: "d",
    hint: "Click a wall to add a door of 0.9 m.",
    down(place, event, target) {
      const key = target.closest?.("[data-key^='world/walls/']")?.getAttribute("data-key");
      const path = key?.split("/").map((it, i) => (i === 2 ? Number(it) : it));
      const halves = path && withDoor(valueAt(store.data, path), place);
      if (!halves) {
        store.say("A door needs a straight wall of at least 1.1 m: click one.");
        return null;
      }
      const walls = store.get(WALLS);
      const second = { ...halves[1], ...(halves[1].name ? { name: freeName(halves[1].name, new Set(walls.map((it) => it?.name))) } : {}) };
      const ops = [["set", path, halves[0]], ["insert", [...WALLS, path[2] + 1], second]];
      store.edit("Add a door", ops);
      store.tools.choose("select");
      return null;
    },
    finish: () => false,
  };
}

/** Returns the tools for walls and furniture. */
export function worldTools(store, map) {
  const wall = { name: "wall", title: "Wall", icon: "wall", key: "w" };
  const polygon = { name: "polygon", title: "Polygon", icon: "polygon", key: "o" };
  const box = { name: "box", title: "Box", icon: "box", key: "b", hint: "Pull a box from corner to corner." };
  const disc = { name: "disc", title: "Disc", icon: "disc", key: "c", hint: "Pull a disc from its center to its rim." };
  const room = { name: "room", title: "Room of four walls", icon: "room", key: "O", hint: "Pull a room from corner to corner." };
  const one = (stem) => (area) => {
    const name = newName(store, WALLS, stem);
    return [`Add ${name}`, [{ name, ...area }]];
  };
  return [
    lineTool(store, map, wall, { shape: "polyline", least: 2, closes: false }),
    lineTool(store, map, polygon, { shape: "polygon", least: 3, closes: true }),
    areaTool(store, map, box, one("box")),
    areaTool(store, map, disc, one("disc"), DISC),
    areaTool(store, map, room, (area) => roomParts(store, area)),
    doorTool(store),
    furnitureTool(store, map),
  ];
}
