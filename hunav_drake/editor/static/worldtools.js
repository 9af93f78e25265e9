import { svg } from "./dom.js";
import { round } from "./data.js";
import { uncovered, wallLines } from "./walllines.js";
import { outline } from "./shapes.js";
import { addParts, corners, discCorners, newName } from "./newparts.js";
import { furnitureTool } from "./furniture.js";

/** The thickness of the walls of a room, in meters. */
const THICK = 0.15;

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
    if (!values.length) return store.tools.choose("select");
    const parts = values.map((value) => ({ list: WALLS, value: { type: shape.type, ...value } }));
    addParts(store, label, parts, values.map((it) => ({ points: shape.corners(it), closed: true, kind: shape.type, height: 2.5 })));
    return store.tools.choose("select");
  }
  return {
    ...face,
    corners: true,
    down(place, event) {
      // With the keyboard, each press sets a corner.
      if (!event.pointerId) {
        place = store.snapped(place, event, { corners: true, lines: face.lines, from: first ?? place });
        if (first) end(first, place);
        first = first ? null : place;
        return null;
      }
      let to = place;
      return {
        move(now) {
          const at = map.view.toWorld(...map.pixels(now));
          to = store.snapped(at, now, { corners: true, lines: face.lines, from: place });
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

/**
 * Returns the walls of a room. Where a wall stands already, it is shared; so
 * are its doors.
 */
function roomParts(store, { center: [x, y], size: [w, d] }) {
  const name = newName(store, WALLS, "room_north").replace("_north", "");
  const [dx, dy, half] = [w / 2, d / 2, THICK / 2];
  const old = wallLines(store.get(WALLS));
  const called = (side) => `${name.replace(/(_\d+)?$/, "")}_${side}${/_\d+$/.exec(name)?.[0] ?? ""}`;
  const side = (it, axis, at, from, to) =>
    uncovered(old, axis, at, from, to).map(([a, b]) => {
      const [middle, length] = [round((a + b) / 2), round(b - a)];
      const across = round(at);
      return { name: called(it), center: axis ? [across, middle] : [middle, across], size: axis ? [THICK, length] : [length, THICK] };
    });
  const values = [
    ...side("north", 0, y + dy, x - dx - half, x + dx + half),
    ...side("south", 0, y - dy, x - dx - half, x + dx + half),
    ...side("east", 1, x + dx, y - dy + half, y + dy - half),
    ...side("west", 1, x - dx, y - dy + half, y + dy - half),
  ];
  if (!values.length) store.say("The room has no walls of its own: all of them stand already.");
  return ["Add a room", values];
}

function doorTool(store, map) {
  return {
    name: "door",
    title: "Door",
    icon: "door",
    key: "d",
    hint: "Click a wall to add a door of 0.9 m. It cuts all walls that stand there side by side.",
    down(place) {
      store.ask({ do: "door", at: place, reach: Math.min(10, Math.max(0.2, 12 / map.scale)) });
      // The numbers of walls change.
      store.select([]);
      store.tools.choose("select");
      return null;
    },
    finish: () => false,
  };
}

/** Returns the tools for walls and furniture. */
export function worldTools(store, map) {
  const wall = { name: "wall", title: "Wall", icon: "wall", key: "w", lines: true };
  const polygon = { name: "polygon", title: "Polygon", icon: "polygon", key: "o" };
  const box = { name: "box", title: "Box", icon: "box", key: "b", hint: "Pull a box from corner to corner." };
  const disc = { name: "disc", title: "Disc", icon: "disc", key: "c", hint: "Pull a disc from its center to its rim." };
  const room = { name: "room", title: "Room of four walls", icon: "room", key: "O", hint: "Pull a room from corner to corner. It snaps to other walls, and shares them.", lines: true };
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
    doorTool(store, map),
    furnitureTool(store, map),
  ];
}
