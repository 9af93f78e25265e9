import { applied, keyOf, round, valueAt } from "./data.js";
import { COHORTS, cohortsOf, drawnOf, headingOf, isGoal, isOnMap, moveOps, nameOf, outlinesAfter, placeOf, turnOps } from "./things.js";
import { copied, duplicateOps, ownPeopleOps, wordsFor, withStart } from "./changes.js";

/**
 * Creates the drags that change parts: each is a gesture, which shows its
 * effect and becomes one edit when it ends.
 * @param store
 * @param map
 * @param {{world: Function, snapped: Function, ended: Function}} host
 *   The place of an event; the snapped place; and a handler of the end.
 */
export function makeDrags(store, map, { world, snapped, ended }) {
  const { element } = map;

  /** Shows operations as a preview, and has them checked. */
  function show(base, ops) {
    map.render(applied(base, ops), outlinesAfter(base, store.outlines, ops));
    store.preview(ops);
  }

  /** The keys of drawings that follow when parts at paths change. */
  function drawings(paths) {
    const keys = paths.flatMap((path) => {
      const person = keyOf(path.slice(0, 2));
      if (isGoal(path)) return [`chain:${person}`];
      return path[0] === "humans" ? [`chain:${person}`, person] : [keyOf(path)];
    });
    return [...new Set(keys)];
  }

  /** A gesture that changes parts: `opsFor` gives operations for an event. */
  function changing(paths, label, opsFor, after = null) {
    const base = withStart(store.data, store.catalog.defaults);
    let ops = [];
    map.lift(drawings(paths));
    element.classList.add("dragging");
    const stop = () => {
      element.classList.remove("dragging");
      map.drop();
      ended();
    };
    return {
      move(event) {
        ops = opsFor(base, event);
        show(base, ops);
        // New parts, such as copies.
        map.lift(drawings(paths));
      },
      end() {
        stop();
        if (ops.length) {
          store.edit(label, ops, outlinesAfter(base, store.outlines, ops));
          after?.();
        } else {
          store.preview(null);
        }
      },
      cancel() {
        stop();
        store.preview(null);
        map.render();
      },
    };
  }

  function moving(grabbed, from, copying) {
    const { data, outlines } = store;
    let paths = store.selection.filter(isOnMap);
    const anchor = placeOf(withStart(data, store.catalog.defaults), outlines, grabbed) ?? from;
    const step = (event) => {
      const at = world(event);
      let [dx, dy] = [at[0] - from[0], at[1] - from[1]];
      if (event.shiftKey) [dx, dy] = Math.abs(dx) > Math.abs(dy) ? [dx, 0] : [0, dy];
      const to = snapped([anchor[0] + dx, anchor[1] + dy], event);
      if (event.shiftKey) return [dx ? to[0] - anchor[0] : 0, dy ? to[1] - anchor[1] : 0];
      return [to[0] - anchor[0], to[1] - anchor[1]];
    };
    if (copying) {
      const parts = copied(data, paths);
      ({ paths } = duplicateOps(data, parts, 0, 0));
      const label = `Copy ${wordsFor(data, store.selection)}`;
      return changing(paths, label, (base, event) => duplicateOps(base, parts, ...step(event)).ops, () => store.select(paths));
    }
    return changing(paths, `Move ${wordsFor(data, paths)}`, (base, event) => {
      const [dx, dy] = step(event);
      return dx || dy ? paths.flatMap((it) => moveOps(base, it, dx, dy)) : [];
    });
  }

  /** Makes the people of a cohort people of their own, and moves one of them. */
  function owning(number, from) {
    const all = drawnOf(store, store.data);
    const { source, human } = all[number];
    const index = cohortsOf(store.data).indexOf(source);
    const { ops, paths } = ownPeopleOps(store, index);
    const path = paths[all.filter((it) => it.source === source).findIndex((it) => it.human === human)];
    const label = `Make ${paths.length} people of ${nameOf(store.data, [...COHORTS, index])} their own`;
    return changing([path], label, (base, event) => {
      const at = world(event);
      const to = snapped([0, 1].map((i) => human.pose[i] + at[i] - from[i]), event);
      return [...ops, ["set", [...path, "pose"], [...to, human.pose[2]]]];
    }, () => {
      store.select([path]);
      store.say(`${label}: the seed no longer draws them. Undo takes it back.`, false);
    });
  }

  function turning(path) {
    return changing([path], `Turn ${wordsFor(store.data, [path])}`, (base, event) => {
      const { at } = headingOf(base, path);
      const [x, y] = world(event);
      const yaw = Math.atan2(y - at[1], x - at[0]);
      const part = Math.PI / 12;
      const whole = event.shiftKey ? part : Math.PI / 180;
      return turnOps(base, path, event.altKey ? yaw : Math.round(yaw / whole) * whole);
    });
  }

  function sizing(path, u, v) {
    return changing([path], `Resize ${wordsFor(store.data, [path])}`, (base, event) => {
      const value = valueAt(base, path);
      const yaw = headingOf(base, path).yaw;
      const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
      const [x, y] = snapped(world(event), event, { corners: true, besides: keyOf(path) });
      const [dx, dy] = [x - value.center[0], y - value.center[1]];
      const local = [c * dx + s * dy, c * dy - s * dx];
      // The opposite side does not move.
      const size = value.size.map((old, i) => ([u, v][i] ? Math.max(0.02, [u, v][i] * local[i] + old / 2) : old));
      const shift = [u, v].map((sign, i) => (sign * (size[i] - value.size[i])) / 2);
      const center = [value.center[0] + c * shift[0] - s * shift[1], value.center[1] + s * shift[0] + c * shift[1]];
      return [
        ["set", [...path, "center"], center.map(round)],
        ["set", [...path, "size"], size.map(round)],
      ];
    });
  }

  function widening(path) {
    return changing([path], `Resize ${wordsFor(store.data, [path])}`, (base, event) => {
      const { center } = valueAt(base, path);
      const [x, y] = snapped(world(event), event, { corners: true, besides: keyOf(path) });
      return [["set", [...path, "radius"], round(Math.max(0.01, Math.hypot(x - center[0], y - center[1])))]];
    });
  }

  function bending(path, name, index) {
    const isNew = name === "side";
    const at = isNew ? index + 1 : index;
    store.corner = { path, index: at };
    return changing([path], `${isNew ? "Add a corner to" : "Move a corner of"} ${wordsFor(store.data, [path])}`, (base, event) => {
      const points = [...valueAt(base, path).points];
      points.splice(at, isNew ? 0 : 1, snapped(world(event), event, { corners: true, besides: keyOf(path) }));
      return [["set", [...path, "points"], points]];
    });
  }

  return { moving, owning, turning, sizing, widening, bending };
}
