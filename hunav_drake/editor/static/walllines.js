import { round } from "./data.js";
import { isPoint } from "./things.js";

/**
 * The middle lines of walls along x and y, by which rooms snap and share walls.
 */

/** The thickest box that is a wall, in meters. */
const THICKEST = 0.5;
/** Lines that are nearer than this are the same, in meters. */
const SAME = 0.03;
/** A gap that is shorter is a door, or an opening between two walls, in meters. */
const OPENING = 1.5;
/** A shorter piece of a wall is left out, in meters. */
const LEAST = 0.05;

/** Returns [axis, at, from, to]: a line along x (0) or y (1). */
function lineOf([ax, ay], [bx, by]) {
  if (Math.abs(ay - by) < SAME && Math.abs(ax - bx) > SAME) return [0, (ay + by) / 2, Math.min(ax, bx), Math.max(ax, bx)];
  if (Math.abs(ax - bx) < SAME && Math.abs(ay - by) > SAME) return [1, (ax + bx) / 2, Math.min(ay, by), Math.max(ay, by)];
  return null;
}

/** Returns the lines of walls that run along x or y. */
export function wallLines(walls) {
  const lines = (Array.isArray(walls) ? walls : []).flatMap((wall) => {
    if (wall?.type === "polyline" && Array.isArray(wall.points) && wall.points.every(isPoint)) {
      return wall.points.slice(1).map((it, i) => lineOf(wall.points[i], it));
    }
    if (wall?.type !== "box" || !isPoint(wall.center) || !isPoint(wall.size) || Math.min(...wall.size) > THICKEST) return [];
    const long = wall.size[0] >= wall.size[1] ? 0 : 1;
    const [c, s] = [Math.cos(wall.yaw ?? 0), Math.sin(wall.yaw ?? 0)];
    const [ux, uy] = long ? [-s, c] : [c, s];
    const half = wall.size[long] / 2;
    const [x, y] = wall.center;
    return [lineOf([x - half * ux, y - half * uy], [x + half * ux, y + half * uy])];
  });
  return lines.filter(Boolean);
}

/** Returns the stretches [from, to] of a new wall where none stands; doors of others stay open. */
export function uncovered(lines, axis, at, from, to) {
  const taken = lines
    .filter((it) => it[0] === axis && Math.abs(it[1] - at) < SAME)
    .map((it) => [it[2], it[3]])
    .sort((a, b) => a[0] - b[0]);
  const free = [];
  let begin = from;
  taken.forEach(([low, high], i) => {
    const isDoor = i > 0 && low - taken[i - 1][1] < OPENING;
    if (!isDoor && low > begin) free.push([begin, Math.min(low, to)]);
    begin = Math.max(begin, high);
  });
  if (begin < to) free.push([begin, to]);
  return free.filter(([a, b]) => b - a > LEAST);
}

/**
 * Returns a place on the lines of walls that are near it, each of x and y by
 * itself; null if there are none. `from` is the opposite corner of a room.
 */
export function onLines(walls, at, reach, from = at) {
  const lines = wallLines(walls);
  const snapped = [1, 0].map((axis) => {
    // A line along y sets x, and one along x sets y.
    const [across, along] = axis ? [0, 1] : [1, 0];
    const [low, high] = [Math.min(from[along], at[along]) - reach, Math.max(from[along], at[along]) + reach];
    const near = lines.filter((it) => it[0] === axis && Math.abs(it[1] - at[across]) < reach && it[3] > low && it[2] < high);
    near.sort((a, b) => Math.abs(a[1] - at[across]) - Math.abs(b[1] - at[across]));
    return near.length ? round(near[0][1]) : null;
  });
  return snapped.every((it) => it === null) ? null : snapped;
}
