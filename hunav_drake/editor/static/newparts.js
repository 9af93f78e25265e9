import { addOps, freeName } from "./changes.js";

/**
 * New parts of the world, with names and outlines.
 */

/** Returns a name for a new part of a list: wall_1, wall_2. */
export function newName(store, list, stem) {
  return freeName(`${stem}_1`, new Set((store.get(list) ?? []).map((it) => it?.name)));
}

/** Adds parts of the world with preliminary outlines, and selects them. */
export function addParts(store, label, parts, outlines) {
  const { ops, paths } = addOps(store.data, parts);
  const shown = { ...store.outlines };
  paths.forEach((path, i) => {
    if (outlines[i]) shown[path.join("/")] = outlines[i];
  });
  store.edit(label, ops, shown);
  store.select(paths);
}

/** Returns the corners of a box. */
export function corners({ center: [x, y], size: [w, d], yaw = 0 }) {
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  const signs = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
  return signs.map(([u, v]) => [x + (c * u * w - s * v * d) / 2, y + (s * u * w + c * v * d) / 2]);
}

/** Returns points on the rim of a disc. */
export function discCorners({ center: [x, y], radius }) {
  const angles = Array.from({ length: 24 }, (_, i) => (i * Math.PI) / 12);
  return angles.map((it) => [x + radius * Math.cos(it), y + radius * Math.sin(it)]);
}

/** Returns the preliminary outline of furniture: its picture at a place. */
export const pictureAt = (picture, [x, y]) => {
  const moved = ([u, v]) => [u + x, v + y];
  return { ...picture, points: picture.points.map(moved), pieces: picture.pieces.map(([material, it]) => [material, it.map(moved)]) };
};

/** Returns the preliminary outline of a box, before Python sends it. */
export const boxOutline = (box, kind = "box") => ({ points: corners(box), closed: true, kind, height: box.height ?? 2.5 });
