import { applied, keyOf, round, valueAt } from "./data.js";

/**
 * The parts on the map, and how to move and turn them. All names
 * of fields that the map knows are in this file.
 */

export const HUMANS = "humans";
export const ROBOT = "robot";
export const ROBOTS = "robots";
export const PLACES = "places";
export const COHORTS = ["population", "cohorts"];
const WORLD = "world";

const TURN = 2 * Math.PI;

/** Returns a list of mappings; in place of what is none, an empty one. */
const mappings = (list) => (Array.isArray(list) ? list.map((it) => (it && typeof it === "object" ? it : {})) : []);

/** Returns the list of people. */
export const peopleOf = (data) => mappings(data[HUMANS]);

/** Returns the list of places. */
export const placesOf = (data) => mappings(data[PLACES]);

/** Returns the cohorts of the population. */
export const cohortsOf = (data) => {
  const cohorts = valueAt(data, COHORTS);
  return Array.isArray(cohorts) ? cohorts : [];
};

/** Returns the people whom the seed draws for the cohorts of data. */
export const drawnOf = (store, data) => store.drawn.filter((it) => it.source && cohortsOf(data).includes(it.source));

/** Returns the poses at which a place is used, apart from its own. */
export const slotsOf = (place) => (Array.isArray(place?.slots) ? place.slots.filter(isPoint) : []);

/** Returns the paths of the robot, or of several robots. */
export function robotsOf(data) {
  const several = Array.isArray(data[ROBOTS]) && data[ROBOTS].length;
  return several ? data[ROBOTS].map((_, i) => [ROBOTS, i, ROBOT]) : [[ROBOT]];
}

export const startOf = (robot) => [...robot, "start"];
export const goalOf = (robot) => [...robot, "goal"];

const isNumber = (it) => typeof it === "number" && Number.isFinite(it);
export const isPoint = (it) => Array.isArray(it) && it.length >= 2 && it.slice(0, 2).every(isNumber);
export const isPose = (it) => isPoint(it) && it.length === 3 && isNumber(it[2]);

/** Returns the goals of a person that can be drawn, with their indices. */
export function goalsOf(person) {
  const goals = Array.isArray(person?.goals) ? person.goals : [];
  return goals.map((at, i) => ({ at, i })).filter(({ at }) => isPoint(at));
}

export const isPerson = (path) => path[0] === HUMANS && path.length === 2;
export const isGoal = (path) => path[0] === HUMANS && path[2] === "goals" && path.length === 4;
/** Returns whether a path is that of a place of a robot; its start stands for the robot. */
export const isRobotPlace = (path) => path.at(-2) === ROBOT && path.length === (path[0] === ROBOTS ? 4 : 2);
/** Returns the path of the robot that has a place: of several, with its planner. */
export const robotPath = (path) => path.slice(0, path[0] === ROBOTS ? 2 : 1);
export const isPlace = (path) => path[0] === PLACES && path.length === 2;
const isWorldPart = (path) => path[0] === WORLD && path.length === 3;
export const isOnMap = (path) => isPerson(path) || isGoal(path) || isRobotPlace(path) || isPlace(path) || isWorldPart(path);

/** Returns the person of a path of a person or of a goal. */
export const personPath = (path) => (path[0] === HUMANS ? path.slice(0, 2) : null);

/** Returns the name of a person's behavior tree. */
export function behaviorOf(person, defaults) {
  const it = person.behavior ?? defaults?.behavior ?? "regular";
  const name = typeof it === "string" ? it : String(it.type ?? "");
  return name.startsWith("<") ? "own tree" : name.split("/").at(-1);
}

export function groupOf(person) {
  return Number.isInteger(person.group_id) ? person.group_id : -1;
}

/** Returns the lists of the world that hold shapes, as [key, items]. */
export function worldLists(data) {
  const lists = Object.entries(data[WORLD] ?? {});
  return lists.filter(([, it]) => Array.isArray(it));
}

/** Returns a short name for the part at a path. */
export function nameOf(data, path) {
  if (isGoal(path)) return `goal ${path[3] + 1} of ${nameOf(data, path.slice(0, 2))}`;
  if (isRobotPlace(path) && ["start", "goal"].includes(path.at(-1))) {
    const name = path[0] === ROBOT ? ROBOT : nameOf(data, robotPath(path));
    return path.at(-1) === "goal" ? `${name}'s goal` : name;
  }
  if (path[0] === ROBOTS && path.length > 2) return [nameOf(data, robotPath(path)), ...path.slice(2)].join(" ");
  // A field of a part is named after it.
  const depth = { [HUMANS]: 2, [PLACES]: 2, [WORLD]: 3, population: 3 }[path[0]];
  if (path.length > depth) return [nameOf(data, path.slice(0, depth)), ...path.slice(depth).filter((it) => typeof it === "string")].join(" ");
  const value = valueAt(data, path);
  if (path.length === 3 && path[1] === "cohorts") return value?.name || `cohort ${path[2] + 1}`;
  if (path.length === 2 && path[0] === HUMANS) return value?.name || `human_${path[1] + 1}`;
  if (isPlace(path)) return value?.name || `place_${path[1] + 1}`;
  if (value && typeof value === "object" && !Array.isArray(value)) {
    const list = valueAt(data, path.slice(0, -1));
    if (value.name || !Array.isArray(list)) return value.name || path.join(" ");
    // As places that furniture brings are named.
    const before = list.slice(0, path.at(-1) + 1).filter((it) => it?.type === value.type);
    return `${value.type ?? String(path.at(-2)).replace(/s$/, "")}_${before.length}`;
  }
  return path.filter((it) => typeof it === "string").join(" ") || "scenario";
}

function shifted([x, y, ...rest], dx, dy) {
  return [round(x + dx), round(y + dy), ...rest];
}

/** Returns the value of the part at a path, moved by (dx, dy). */
export function moveOps(data, path, dx, dy) {
  const value = valueAt(data, path);
  if (isPoint(value)) return [["set", path, shifted(value, dx, dy)]];
  if (!value || typeof value !== "object") return [];
  if (path[0] === ROBOTS) return ["start", "goal"].flatMap((name) => moveOps(data, [...path, ROBOT, name], dx, dy));
  const ops = [];
  for (const name of ["pose", "center", "point"]) {
    if (isPoint(value[name])) ops.push(["set", [...path, name], shifted(value[name], dx, dy)]);
  }
  for (const name of ["points", "slots", "approaches"]) {
    if (!Array.isArray(value[name])) continue;
    ops.push(["set", [...path, name], value[name].map((it) => (isPoint(it) ? shifted(it, dx, dy) : it))]);
  }
  return ops;
}

/** Returns whether a part is a disc of the world. */
export const isDisc = (value) => isPoint(value?.center) && isNumber(value.radius);

/** Returns the path and the value of the heading of a part, or null. */
export function headingOf(data, path) {
  const value = valueAt(data, path);
  if (isPose(value)) return { path: [...path, 2], yaw: value[2], at: value };
  if (isPose(value?.pose)) return { path: [...path, "pose", 2], yaw: value.pose[2], at: value.pose };
  if (isPoint(value?.center) && !isDisc(value)) {
    return { path: [...path, "yaw"], yaw: isNumber(value.yaw) ? value.yaw : 0, at: value.center };
  }
  return null;
}

/** Returns an angle in (-pi, pi]. */
function wrapped(angle) {
  const a = angle - TURN * Math.round(angle / TURN);
  return round(a <= -Math.PI ? a + TURN : a);
}

/** Returns the operations that turn a part to an angle. */
export function turnOps(data, path, yaw) {
  const found = headingOf(data, path);
  if (!found) return [];
  if (found.path.at(-1) === 2) {
    const parent = found.path.slice(0, -1);
    const ops = [["set", parent, [...found.at.slice(0, 2), wrapped(yaw)]]];
    const [c, s] = [Math.cos(yaw - found.yaw), Math.sin(yaw - found.yaw)];
    const turned = ([x, y, ...rest]) => {
      const [dx, dy] = [x - found.at[0], y - found.at[1]];
      return [round(found.at[0] + c * dx - s * dy), round(found.at[1] + s * dx + c * dy), ...rest.map((it) => wrapped(it + yaw - found.yaw))];
    };
    const value = isPlace(path) ? valueAt(data, path) : {};
    for (const name of ["slots", "approaches"]) {
      if (Array.isArray(value[name])) ops.push(["set", [...path, name], value[name].map((it) => (isPoint(it) ? turned(it) : it))]);
    }
    return ops;
  }
  return [["set", found.path, wrapped(yaw)]];
}

function mapped(outline, f) {
  const pieces = outline.pieces?.map(([material, points]) => [material, points.map(f)]);
  return { ...outline, points: outline.points.map(f), parts: outline.parts?.map((it) => it.map(f)), pieces };
}

/** Returns an outline that follows a part from one value to another. */
function followed(outline, from, to) {
  if (!outline || !from || !to) return outline;
  if (Array.isArray(to.points)) {
    return to.points.every(isPoint) ? { ...outline, points: to.points } : outline;
  }
  const place = (it) => {
    const [x, y] = it.center ?? it.pose ?? [0, 0];
    const yaw = (isNumber(it.yaw) ? it.yaw : it.pose?.[2]) ?? 0;
    const size = isDisc(it) ? [it.radius, it.radius] : it.size;
    return { x, y, c: Math.cos(yaw), s: Math.sin(yaw), size };
  };
  const [a, b] = [place(from), place(to)];
  const grow = isPoint(a.size) && isPoint(b.size) ? [b.size[0] / a.size[0], b.size[1] / a.size[1]] : [1, 1];
  return mapped(outline, ([x, y]) => {
    const [dx, dy] = [x - a.x, y - a.y];
    const u = (a.c * dx + a.s * dy) * grow[0];
    const v = (a.c * dy - a.s * dx) * grow[1];
    return [b.x + b.c * u - b.s * v, b.y + b.s * u + b.c * v];
  });
}

/** Returns the outlines after operations on the parts at paths. */
export function outlinesAfter(data, outlines, ops) {
  const keys = new Set();
  for (const [name, path] of ops) {
    if (name !== "set" || path[0] !== WORLD || path.length <= 3) continue;
    keys.add(keyOf(path.slice(0, 3)));
  }
  if (!keys.size) return outlines;
  const result = { ...outlines };
  const after = applied(data, ops);
  for (const key of keys) {
    const path = key.split("/").map((it, i) => (i === 2 ? Number(it) : it));
    result[key] = followed(outlines[key], valueAt(data, path), valueAt(after, path));
  }
  return result;
}

/** Returns the box [x0, y0, x1, y1] around all parts on the map. */
export function boundsOf(data, outlines, more = []) {
  const points = [...more];
  for (const it of Object.values(outlines)) points.push(...(it?.points ?? []));
  for (const person of peopleOf(data)) {
    if (isPoint(person.pose)) points.push(person.pose);
    points.push(...goalsOf(person).map(({ at }) => at));
  }
  for (const place of placesOf(data)) points.push(...[place.pose].filter(isPoint), ...slotsOf(place));
  for (const path of robotsOf(data).flatMap((it) => [startOf(it), goalOf(it)])) {
    const at = valueAt(data, path);
    if (isPoint(at)) points.push(at);
  }
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const [x, y] of points) {
    box[0] = Math.min(box[0], x);
    box[1] = Math.min(box[1], y);
    box[2] = Math.max(box[2], x);
    box[3] = Math.max(box[3], y);
  }
  if (!points.length) return [-5, -4, 5, 4];
  // A single part has some floor around it.
  const grow = (low, high) => Math.max(0, 6 - (high - low)) / 2;
  const [gx, gy] = [grow(box[0], box[2]), grow(box[1], box[3])];
  return [box[0] - gx, box[1] - gy, box[2] + gx, box[3] + gy];
}

/** Returns the middle of a part, in meters, or null. */
export function placeOf(data, outlines, path) {
  const value = valueAt(data, path);
  if (isPoint(value)) return value.slice(0, 2);
  for (const name of ["pose", "center"]) {
    if (isPoint(value?.[name])) return value[name].slice(0, 2);
  }
  const points = outlines[keyOf(path)]?.points;
  if (!points?.length) return null;
  const sum = points.reduce(([x, y], it) => [x + it[0], y + it[1]], [0, 0]);
  return [sum[0] / points.length, sum[1] / points.length];
}
