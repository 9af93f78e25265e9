import { applied, isWithin, keyOf, samePath, valueAt } from "./data.js";
import { COHORTS, HUMANS, ROBOT, ROBOTS, cohortsOf, drawnOf, groupOf, isPerson, isPoint, isRobotPlace, moveOps, nameOf, peopleOf, robotPath, robotsOf, startOf } from "./things.js";

/**
 * Edits as operations on the parts at paths. None of them uses
 * the page.
 */

/** Returns "bruno", or "5 parts". */
export function wordsFor(data, paths) {
  if (paths.length === 1) return nameOf(data, paths[0]);
  return paths.every(isPerson) ? `${paths.length} people` : `${paths.length} parts`;
}

/** Returns the data with the starts of robots, which may be missing. */
export function withStart(data, defaults) {
  const missing = robotsOf(data).map(startOf).filter((it) => valueAt(data, it) === undefined);
  return applied(data, missing.map((it) => ["set", it, defaults?.robot?.start ?? [0, 0, 0]]));
}

/** Returns paths without those inside others, the last first in each list. */
function fromTheEnd(paths) {
  const whole = paths.filter((it) => !paths.some((other) => other !== it && isWithin(it, other) && !samePath(it, other)));
  return [...whole].sort((a, b) => {
    for (let i = 0; i < Math.min(a.length, b.length); i++) {
      if (a[i] !== b[i]) return a[i] < b[i] ? 1 : -1;
    }
    return b.length - a.length;
  });
}

/** Returns the numbers of people: their own, or the next one that is free. */
function numbersOf(people) {
  const taken = new Set(people.map((it) => it.id));
  let next = 0;
  return people.map((it) => {
    if (Number.isInteger(it.id)) return it.id;
    do next++;
    while (taken.has(next));
    return next;
  });
}

/**
 * Returns the operations that delete parts; the start of a robot stands for it.
 * Where behaviors name people by their numbers, those who stay keep theirs.
 */
export function deleteOps(data, paths) {
  const starts = robotsOf(data).map((it) => keyOf(startOf(it)));
  const parts = paths.map((it) => (it[0] === ROBOTS && starts.includes(keyOf(it)) ? robotPath(it) : it));
  // One robot stays.
  const isLast = (it) => it[0] === ROBOTS && it.length === 2 && it[1] === 0 && parts.filter((one) => one[0] === ROBOTS && one.length === 2).length === starts.length;
  const people = peopleOf(data);
  const gone = paths.filter(isPerson).map((it) => it[1]);
  const stay = people.map((_, i) => i).filter((i) => !gone.includes(i));
  const [before, after] = [numbersOf(people), numbersOf(stay.map((i) => people[i]))];
  const moved = stay.filter((i, k) => data[HUMANS][i] && before[i] !== after[k]);
  const isNamed = /people|_id|\.xml/.test(JSON.stringify(people.map((it) => it.behavior)));
  const removed = fromTheEnd(parts).filter((it) => keyOf(it) !== keyOf(startOf([ROBOT])) && !isLast(it));
  return [...(isNamed ? moved.map((i) => ["set", [HUMANS, i, "id"], before[i]]) : []), ...removed.map((it) => ["remove", it])];
}

/** Returns a name that is not taken: bruno, bruno_2, bruno_3. */
export function freeName(name, taken) {
  if (!name || !taken.has(name)) return name;
  const [, stem, number] = /^(.*?)(?:_(\d+))?$/.exec(name);
  let n = Number(number ?? 1);
  do n += 1;
  while (taken.has(`${stem}_${n}`));
  return `${stem}_${n}`;
}

/** Returns a copy of a part of a list, with a unique name and id; parts without an id have their order. */
export function ownCopy(value, list) {
  const copy = structuredClone(value);
  if (!copy || typeof copy !== "object" || Array.isArray(copy)) return copy;
  if (copy.name) copy.name = freeName(copy.name, new Set(list.map((it) => it?.name)));
  const usual = list.length + 1;
  const ids = new Set(list.map((it, i) => it?.id ?? i + 1));
  let id = Number.isInteger(copy.id) ? copy.id : usual;
  while (ids.has(id)) id += 1;
  if (Number.isInteger(copy.id) || id !== usual) copy.id = id;
  return copy;
}

/**
 * Returns the operations that add values to lists, and their new paths.
 * @param {any} data
 * @param {{list: (string|number)[], value: any}[]} parts
 */
export function addOps(data, parts) {
  const ops = [];
  const paths = [];
  let after = data;
  for (const { list, value } of parts) {
    const items = valueAt(after, list) ?? [];
    const op = ["insert", [...list, items.length], ownCopy(value, items)];
    after = applied(after, [op]);
    ops.push(op);
    paths.push(op[1]);
  }
  return { ops, paths, after };
}

/** Returns those parts at paths that can be copied: people, walls, goals, one of several robots. */
export function copied(data, paths) {
  return paths
    .map((it) => (it[0] === ROBOTS && it.at(-1) === "start" ? robotPath(it) : it))
    .filter((it) => !isRobotPlace(it))
    .map((it) => ({ list: it.slice(0, -1), value: valueAt(data, it) }))
    .filter(({ value }) => value !== undefined);
}

/** Returns operations that add copies of parts, moved by (dx, dy) with their goals. */
export function duplicateOps(data, parts, dx, dy) {
  const { ops, paths, after } = addOps(data, parts);
  const moves = paths.flatMap((it) => moveOps(after, it, dx, dy));
  return { ops: [...ops, ...moves], paths: paths.map(selectable) };
}

/** Returns the path that is selected for a part. */
export const selectable = (path) => (path[0] === ROBOTS ? startOf([...path, ROBOT]) : path);

/**
 * Returns the operations that add a robot like the last one, beside it, and its
 * path. A single robot becomes the first one of several, with its planner and
 * its sensors.
 */
export function robotOps(data, defaults, outlines) {
  const ops = [];
  let list = data[ROBOTS] ?? [];
  if (!list.length) {
    const kept = (it) => (it?.mount ?? ROBOT) === ROBOT;
    const sensors = (data.sensors ?? []).filter(kept);
    const robot = typeof data.robot === "string" ? { type: data.robot } : data.robot ?? {};
    const first = { name: "robot_1", robot: { ...robot, start: robot.start ?? defaults?.robot?.start ?? [0, 0, 0] } };
    if (data.planner !== undefined) first.planner = data.planner;
    if (sensors.length) first.sensors = sensors;
    list = [first];
    for (const key of [ROBOT, "planner"]) if (data[key] !== undefined) ops.push(["remove", [key]]);
    if (sensors.length) ops.push(sensors.length < data.sensors.length ? ["set", ["sensors"], data.sensors.filter((it) => !kept(it))] : ["remove", ["sensors"]]);
    ops.push(["set", [ROBOTS], list]);
  }
  const after = { ...data, [ROBOTS]: list };
  const last = list.length - 1;
  // Below or above, away from other robots, and if possible from walls.
  const taken = robotsOf(after).map((it) => valueAt(after, startOf(it)) ?? [0, 0]);
  const radius = list[last].robot?.radius ?? defaults?.robot?.radius ?? 0.35;
  const places = [taken[last], ...[list[last].robot?.goal].filter(isPoint)];
  const steps = Array.from({ length: 2 * taken.length + 6 }, (_, i) => (i % 2 ? 3 : -3) * radius * (1 + Math.floor(i / 2)));
  const isFree = (dy) => taken.every((it) => Math.hypot(it[0] - taken[last][0], it[1] - taken[last][1] - dy) >= 2.5 * radius);
  const isClear = (dy) => isFree(dy) && places.every(([x, y]) => wallDistance(outlines, [x, y + dy]) > radius);
  const copy = duplicateOps(after, [{ list: [ROBOTS], value: list[last] }], 0, steps.find(isClear) ?? steps.find(isFree));
  return { ops: [...ops, ...copy.ops], path: copy.paths[0] };
}

/**
 * Returns the operations that make the people of a cohort people of their own,
 * where they were drawn; and their paths.
 */
export function ownPeopleOps(store, index) {
  const { data } = store;
  const drawn = drawnOf(store, data).filter((it) => it.source === cohortsOf(data)[index]);
  const { ops, paths } = addOps(data, drawn.map(({ human }) => ({ list: [HUMANS], value: human })));
  if (drawn.length) ops.push(resetOp(data, [...COHORTS, index]));
  return { ops, paths };
}

/** Returns operations that repeat parts in columns and rows, with steps in meters. */
export function arrayOps(data, parts, { columns, rows, across, up }) {
  const ops = [];
  let after = data;
  for (let n = 1; n < columns * rows; n++) {
    const more = duplicateOps(after, parts, (n % columns) * across, Math.floor(n / columns) * up).ops;
    ops.push(...more);
    after = applied(after, more);
  }
  return ops;
}

/** Returns operations that make one group of people, or that separate them. */
export function groupOps(data, paths, together) {
  const people = paths.filter(isPerson);
  const taken = new Set(peopleOf(data).map(groupOf));
  let free = 1;
  while (taken.has(free)) free += 1;
  return people.map((it) => ["set", [...it, "group_id"], together ? free : -1]);
}

/**
 * Returns a "set" for a value whose parents may be missing, including the
 * missing ones.
 */
export function setOp(data, path, value) {
  let n = 1;
  while (n < path.length && valueAt(data, path.slice(0, n)) !== undefined && valueAt(data, path.slice(0, n)) !== null) n += 1;
  const inner = path.slice(n).reduceRight((it, key) => ({ [key]: it }), value);
  return ["set", path.slice(0, n), inner];
}

/** Returns a "remove", also of parents that would be left empty. */
export function resetOp(data, path) {
  let n = path.length;
  while (n > 1) {
    const parent = valueAt(data, path.slice(0, n - 1));
    const alone = parent && !Array.isArray(parent) && Object.keys(parent).length === 1;
    if (!alone || typeof path[n - 2] === "number") break;
    n -= 1;
  }
  return ["remove", path.slice(0, n)];
}

/** Returns the index at which to insert a place into a chain of points, and the distance to the chain. */
export function segmentAt(points, [x, y]) {
  let best = { index: points.length, distance: Infinity };
  for (let i = 0; i + 1 < points.length; i++) {
    const [[ax, ay], [bx, by]] = [points[i], points[i + 1]];
    const [dx, dy] = [bx - ax, by - ay];
    const t = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
    const distance = Math.hypot(x - ax - t * dx, y - ay - t * dy);
    if (distance < best.distance) best = { index: i + 1, distance };
  }
  return best;
}

/** Returns the distance of a place to the nearest wall or piece of furniture. */
function wallDistance(outlines, at) {
  const solid = Object.values(outlines).filter((it) => it?.height > 0 && it.points?.length);
  return Math.min(...solid.map(({ points, closed }) => segmentAt(closed ? [...points, points[0]] : points, at).distance));
}

/** Returns the corner nearest to a place within a distance, or null. */
export function cornerNear(outlines, [x, y], reach, besides = null) {
  let best = null;
  let least = reach;
  for (const [key, it] of Object.entries(outlines)) {
    if (key === besides) continue;
    for (const point of it?.points ?? []) {
      const distance = Math.hypot(point[0] - x, point[1] - y);
      if (distance < least) [best, least] = [point, distance];
    }
  }
  return best;
}

/** Returns operations that align the centers of parts in x (0) or y (1). */
export function alignOps(data, places, axis) {
  const known = places.filter(({ at }) => at);
  const mean = known.reduce((sum, { at }) => sum + at[axis], 0) / (known.length || 1);
  return known.flatMap(({ path, at }) => {
    const step = mean - at[axis];
    return moveOps(data, path, axis === 0 ? step : 0, axis === 1 ? step : 0);
  });
}

