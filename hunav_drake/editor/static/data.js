/**
 * Immutable plain data by paths. Operations share unchanged parts, so a part
 * has changed exactly if it is another object.
 */

/** @typedef {(string|number)[]} Path */

/** Returns the text of a path, as a key. */
export function keyOf(path) {
  return path.join("/");
}

/** Returns the path of a text made by `keyOf`. */
export function pathOf(key) {
  return key === "" ? [] : key.split("/").map((it) => (/^\d+$/.test(it) ? Number(it) : it));
}

/** Returns the value at a path, or undefined. */
export function valueAt(data, path) {
  let value = data;
  for (const key of path) {
    if (value === null || typeof value !== "object") return undefined;
    value = value[key];
  }
  return value;
}

function changed(value, path, depth, f) {
  if (depth === path.length) return f(value);
  const key = path[depth];
  if (depth === path.length - 1 && f.parent) return f.parent(value, key);
  const copy = Array.isArray(value) ? [...value] : typeof value === "object" ? { ...value } : {};
  copy[key] = changed(copy[key], path, depth + 1, f);
  return copy;
}

function set(data, path, value) {
  return changed(data, path, 0, () => value);
}

function insert(data, path, value) {
  const f = () => value;
  f.parent = (list, index) => {
    const copy = [...(list ?? [])];
    copy.splice(index, 0, value);
    return copy;
  };
  return changed(data, path, 0, f);
}

function remove(data, path) {
  const f = () => null;
  f.parent = (parent, key) => {
    if (Array.isArray(parent)) return parent.filter((_, i) => i !== key);
    const { [key]: _, ...rest } = parent ?? {};
    return rest;
  };
  return changed(data, path, 0, f);
}

/**
 * Returns the data after operations: ["set", path, value],
 * ["insert", path, value], ["remove", path].
 * @param {any} data
 * @param {any[]} ops
 */
export function applied(data, ops) {
  const how = { set, insert, remove };
  return ops.reduce((value, [name, path, it]) => how[name](value, path, it), data);
}

/** Returns whether a path is another one or inside it. */
export function isWithin(path, other) {
  return other.length <= path.length && other.every((key, i) => key === path[i]);
}

/** Returns whether two paths are the same. */
export function samePath(a, b) {
  return a.length === b.length && isWithin(a, b);
}

/** Returns whether two values of plain data are equal. */
export function sameValue(a, b) {
  if (a === b) return true;
  if (a === null || b === null || typeof a !== "object" || typeof b !== "object") return false;
  if (Array.isArray(a) !== Array.isArray(b)) return false;
  const keys = Object.keys(a);
  return keys.length === Object.keys(b).length && keys.every((key) => key in b && sameValue(a[key], b[key]));
}

/** Returns a number rounded to millimeters or milliradians. */
export function round(x) {
  const y = Math.round(x * 1000) / 1000;
  return y === 0 ? 0 : y;
}
