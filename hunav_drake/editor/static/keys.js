import { applied, keyOf, round, valueAt } from "./data.js";
import { goalsOf, headingOf, isOnMap, isPerson, isPoint, moveOps, nameOf, outlinesAfter, personPath, placeOf, turnOps } from "./things.js";
import { addOps, copied, deleteOps, duplicateOps, groupOps, selectable, withStart, wordsFor } from "./changes.js";
import { partsOf } from "./outline.js";

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** The type of copied parts, which distinguishes them from other text. */
const MARK = "hunav_drake parts";

/**
 * Adds the keys: those of the map while it has the focus, and those of the whole
 * editor. Handled keys do not propagate.
 */
export function addKeys(store, map, tools, gestures, root) {
  const { element } = map;

  function edit(label, ops) {
    const base = withStart(store.data, store.catalog.defaults);
    store.edit(label, ops, outlinesAfter(base, store.outlines, ops));
  }

  function nudge(event, [dx, dy]) {
    const size = event.shiftKey ? 0.5 : event.altKey ? 0.01 : 0.05;
    const corner = cornerInHand();
    if (corner) {
      const points = [...valueAt(store.data, corner.path).points];
      const [x, y] = points[corner.index];
      points[corner.index] = [round(x + dx * size), round(y + dy * size)];
      edit(`Move a corner of ${nameOf(store.data, corner.path)}`, [["set", [...corner.path, "points"], points]]);
      return;
    }
    const base = withStart(store.data, store.catalog.defaults);
    const paths = store.selection.filter(isOnMap);
    edit(`Move ${wordsFor(store.data, paths)}`, paths.flatMap((it) => moveOps(base, it, dx * size, dy * size)));
  }

  /** The corner whose handle has the focus, or null. */
  function cornerInHand() {
    const name = document.activeElement?.getAttribute?.("data-handle") ?? "";
    const [kind, index] = name.split(" ");
    return kind === "corner" ? { path: store.selection[0], index: Number(index) } : null;
  }

  function turn(sign, fine) {
    const base = withStart(store.data, store.catalog.defaults);
    const step = (sign * (fine ? 1 : 15) * Math.PI) / 180;
    const paths = store.selection.filter((it) => headingOf(base, it));
    edit(`Turn ${wordsFor(store.data, paths)}`, paths.flatMap((it) => turnOps(base, it, headingOf(base, it).yaw + step)));
  }

  function remove() {
    const corner = cornerInHand();
    if (corner) {
      const points = valueAt(store.data, corner.path).points.filter((_, i) => i !== corner.index);
      edit(`Remove a corner of ${nameOf(store.data, corner.path)}`, [["set", [...corner.path, "points"], points]]);
      return;
    }
    const ops = deleteOps(store.data, store.selection);
    if (ops.length) store.edit(`Delete ${wordsFor(store.data, store.selection)}`, ops);
  }

  function goalAhead() {
    const path = store.selection.map(personPath).find((it) => it && isPerson(it));
    if (!path) return;
    const person = valueAt(store.data, path);
    const goals = goalsOf(person);
    const last = goals.at(-1)?.at ?? person.pose;
    const yaw = person.pose?.[2] ?? 0;
    const at = [round(last[0] + Math.cos(yaw)), round(last[1] + Math.sin(yaw))];
    store.edit(`Add a goal to ${nameOf(store.data, path)}`, [["insert", [...path, "goals", goals.length], at]]);
  }

  /**
   * Moves to the next part in the order of the outline; false at the ends, where
   * Tab moves on as usual.
   */
  function next(step) {
    const here = document.activeElement?.getAttribute?.("data-key");
    if (!here && (step < 0 || document.activeElement !== element)) return false;
    const all = partsOf(store.data).flatMap(({ items }) =>
      items.flatMap((path) => (isPerson(path) ? [path, ...goalsOf(valueAt(store.data, path)).map(({ i }) => [...path, "goals", i])] : [path])),
    );
    const drawn = all.filter((path) => map.element.querySelector(`[data-key="${CSS.escape(keyOf(path))}"]`));
    const at = here ? drawn.findIndex((it) => keyOf(it) === here) : -1;
    const path = drawn[at + step];
    if (!path) return false;
    store.select([path]);
    map.focus(path);
    return true;
  }

  function selectAll() {
    store.select([...map.drawn.keys()].filter((it) => !it.startsWith("chain:")).map((it) => it.split("/").map((k) => (/^\d+$/.test(k) ? Number(k) : k))).filter(isOnMap));
  }

  function duplicate() {
    const { ops, paths } = duplicateOps(store.data, copied(store.data, store.selection), 0.5, -0.5);
    store.edit(`Copy ${wordsFor(store.data, store.selection)}`, ops);
    if (paths.length) store.select(paths);
  }

  function group(together) {
    const people = store.selection.filter(isPerson);
    if (people.length) store.edit(`${together ? "Group" : "Ungroup"} ${wordsFor(store.data, people)}`, groupOps(store.data, people, together));
  }

  const simple = {
    Delete: remove,
    Backspace: () => (tools.current.back ? tools.current.back() : remove()),
    "[": (event) => turn(1, event.shiftKey),
    "]": (event) => turn(-1, event.shiftKey),
    "{": () => turn(1, true),
    "}": () => turn(-1, true),
    "+": () => map.zoom(1.4),
    "=": () => map.zoom(1.4),
    "-": () => map.zoom(1 / 1.4),
    0: () => map.fit(),
    G: goalAhead,
    s: () => store.tell("snap"),
    "?": () => store.tell("help"),
    Enter: () => (tools.current.name === "select" ? cornersOf() : enter()),
  };

  const control = {
    a: selectAll,
    d: duplicate,
    g: () => group(true),
    G: () => group(false),
  };

  /** Focuses the first corner of the selection. */
  function cornersOf() {
    element.querySelector("[data-handle^='corner']")?.focus();
  }

  function enter() {
    const points = ["person", "robot", "robot-goal"];
    if (points.includes(tools.current.name) && tools.current.finish() === false) tools.pressCursor();
    else if (!points.includes(tools.current.name)) tools.finish();
  }

  function onMap(event) {
    const { key } = event;
    const ctrl = event.ctrlKey || event.metaKey;
    const arrow = ARROWS[key];
    if (key === "Tab") return cornerInHand() ? nextCorner(event.shiftKey ? -1 : 1) : next(event.shiftKey ? -1 : 1);
    if (arrow && ctrl) return map.pan(-80 * arrow[0], 80 * arrow[1]), true;
    if (arrow && tools.current.down) return tools.moveCursor(...arrow.map((it) => it * (event.shiftKey ? 1 : event.altKey ? 0.01 : 0.1))), true;
    if (arrow) return nudge(event, arrow), true;
    if (key === " " && tools.current.down) return tools.pressCursor(), true;
    if (key === " ") return (tools.spaceHeld = true);
    if (ctrl && control[key]) return control[key](), true;
    if (ctrl || event.altKey) return false;
    if (simple[key] && !(key === "Enter" && event.target.closest("button"))) return simple[key](event), true;
    const tool = tools.list.find((it) => it.key === key);
    if (tool) tools.choose(tool.name);
    return Boolean(tool);
  }

  function nextCorner(step) {
    const all = [...element.querySelectorAll("[data-handle^='corner']")];
    const to = all[all.indexOf(document.activeElement) + step];
    to?.focus();
    return Boolean(to);
  }

  function everywhere(event) {
    const ctrl = event.ctrlKey || event.metaKey;
    const inField = event.target.closest("input, textarea, select");
    if (event.key === "Escape" && !inField) {
      if (gestures.cancel()) return true;
      if (tools.current.name !== "select") return tools.finish(), true;
      if (store.selection.length && element.contains(event.target)) return store.select([]), element.focus(), true;
      return false;
    }
    if (!ctrl) return false;
    const letter = event.key.toLowerCase();
    if (letter === "s") return store.tell("save"), true;
    if (event.key === "Enter") return store.tell("run"), true;
    if (event.key === ".") return store.send({ do: "cancel" }), true;
    // A field handles these keys.
    if (inField && !inField.matches("[type=checkbox], select")) return false;
    if (letter === "z") return event.shiftKey ? store.redoStep() : store.undoStep(), true;
    if (letter === "y") return store.redoStep(), true;
    return false;
  }

  /** Keys that also mean the map while a button, a list or nothing has the focus. */
  const isAnywhere = ({ key }) => key.length === 1 ? key !== " " : key === "Delete";

  // In a page of its own, keys count before anything has the focus.
  const scope = store.embedded ? root : document;
  scope.addEventListener("keydown", (event) => {
    if (event.isComposing || root.querySelector("dialog[open]") || event.target.closest("dialog")) return;
    const inField = event.target.closest("input, textarea, select");
    const onPage = event.target === document.body && event.key !== "Tab";
    const inMap = !inField && (element.contains(event.target) || onPage || isAnywhere(event));
    const held = gestures.busy && event.key !== "Escape";
    if (held || everywhere(event) || (inMap && onMap(event))) {
      event.preventDefault();
      event.stopPropagation();
    } else if (inMap || event.target.closest("input, textarea, select")) {
      // Jupyter's keys would otherwise delete cells.
      if (store.embedded) event.stopPropagation();
    }
  });
  root.addEventListener("keyup", (event) => {
    if (event.key === " ") tools.spaceHeld = false;
  });

  const isFree = (target) => !target.closest?.("input, textarea, select, dialog");
  function toClipboard(event) {
    const parts = copied(store.data, store.selection);
    if (!parts.length || !isFree(event.target) || String(getSelection())) return false;
    // JSON is YAML, too.
    event.clipboardData.setData("text/plain", JSON.stringify({ [MARK]: parts }, null, 1));
    event.preventDefault();
    return true;
  }
  scope.addEventListener("copy", toClipboard);
  scope.addEventListener("cut", (event) => toClipboard(event) && remove());
  scope.addEventListener("paste", (event) => {
    if (!isFree(event.target)) return;
    let parts;
    try {
      parts = JSON.parse(event.clipboardData.getData("text/plain"))[MARK];
    } catch {
      return;
    }
    if (!Array.isArray(parts) || !parts.every((it) => Array.isArray(it?.list))) return;
    event.preventDefault();
    const { paths, after, ops } = addOps(store.data, parts);
    const places = paths.map((it) => placeOf(after, {}, selectable(it))).filter(isPoint);
    const [x, y] = map.view.middle;
    const mean = (axis) => places.reduce((sum, it) => sum + it[axis], 0) / (places.length || 1);
    // Near the original if it is visible, else in the middle.
    const near = places.some((it) => Math.abs(it[0] - x) < map.view.width / map.scale / 2 && Math.abs(it[1] - y) < map.view.height / map.scale / 2);
    const [dx, dy] = near ? [0.5, -0.5] : [round(x - mean(0)), round(y - mean(1))];
    const moves = paths.flatMap((it) => moveOps(after, it, dx, dy));
    store.edit(`Paste ${parts.length === 1 ? nameOf(applied(after, []), paths[0]) : `${parts.length} parts`}`, [...ops, ...moves]);
    store.select(paths.map(selectable));
  });
}
