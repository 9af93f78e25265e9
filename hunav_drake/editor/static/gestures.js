import { applied, keyOf, pathOf, round, samePath, valueAt } from "./data.js";
import { headingOf, isGoal, isOnMap, moveOps, outlinesAfter, placeOf, turnOps } from "./things.js";
import { copied, cornerNear, duplicateOps, wordsFor, withStart } from "./changes.js";
import { addWheelAndPinch } from "./zoom.js";
import { svg } from "./dom.js";
import { outline } from "./shapes.js";

/** A press becomes a drag after so many pixels. */
const THRESHOLD = 3;

/**
 * Adds what the mouse, a pen or a finger does on the map: select, move, turn,
 * resize, select by a box, pan. Adding is the tools'.
 */
export function addGestures(store, map, tools) {
  const { element } = map;
  /** @type {{move: Function, end: Function, cancel: Function}|null} */
  let gesture = null;
  let last = null;
  let framed = false;
  let lastPress = { time: 0, at: [0, 0] };
  const pointers = addWheelAndPinch(store, map, () => gesture?.cancel());
  store.snap = true;

  const world = (event) => map.view.toWorld(...map.pixels(event));

  /** Returns a place on the grid of 0.1 m, or on a corner nearby. */
  function snapped(at, event, { corners = false, besides = null } = {}) {
    if (!store.snap || event.altKey) return at.map(round);
    const corner = corners && cornerNear(store.outlines, at, 10 / map.scale, besides);
    return corner ? corner.slice(0, 2).map(round) : at.map((it) => round(Math.round(it * 10) / 10));
  }

  store.snapped = snapped;

  /** Shows operations that are not an edit yet, and has them checked. */
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
      gesture = null;
    };
    return {
      move(event) {
        ops = opsFor(base, event);
        show(base, ops);
        // Those that have just come into being, as copies do.
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
      // The opposite side stays where it is.
      const size = value.size.map((old, i) => ([u, v][i] ? Math.max(0.02, [u, v][i] * local[i] + old / 2) : old));
      const shift = [u, v].map((sign, i) => (sign * (size[i] - value.size[i])) / 2);
      const center = [value.center[0] + c * shift[0] - s * shift[1], value.center[1] + s * shift[0] + c * shift[1]];
      return [
        ["set", [...path, "center"], center.map(round)],
        ["set", [...path, "size"], size.map(round)],
      ];
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

  function boxing(from, event) {
    const before = event.shiftKey ? store.selection : [];
    const frame = svg("path", { class: "select-box" });
    map.sketch.append(frame);
    const stop = () => {
      frame.remove();
      gesture = null;
    };
    return {
      move(now) {
        const to = world(now);
        const low = [0, 1].map((i) => Math.min(from[i], to[i]));
        const high = [0, 1].map((i) => Math.max(from[i], to[i]));
        frame.setAttribute("d", outline([low, [high[0], low[1]], high, [low[0], high[1]]]));
        const inside = [...map.drawn.keys()]
          .filter((key) => !key.startsWith("chain:"))
          .map(pathOf)
          .filter((path) => {
            const at = isOnMap(path) && placeOf(store.data, store.outlines, path);
            return at && at.every((it, i) => it >= low[i] && it <= high[i]);
          });
        store.select([...before, ...inside.filter((it) => !before.some((other) => samePath(it, other)))]);
      },
      end: stop,
      cancel: stop,
    };
  }

  function panning(event) {
    let [px, py] = [event.clientX, event.clientY];
    element.classList.add("panning");
    const stop = () => {
      element.classList.remove("panning");
      gesture = null;
    };
    return {
      move(now) {
        map.pan(now.clientX - px, now.clientY - py);
        [px, py] = [now.clientX, now.clientY];
      },
      end: stop,
      cancel: stop,
    };
  }

  /** Waits until a press is a drag; until then it is a click. */
  function pressed(event, start, click = null) {
    const from = [event.clientX, event.clientY];
    return {
      move(now) {
        if (Math.hypot(now.clientX - from[0], now.clientY - from[1]) < THRESHOLD) return;
        gesture = start();
        gesture?.move(now);
      },
      end() {
        gesture = null;
        click?.();
      },
      cancel: () => (gesture = null),
    };
  }

  function onHandle(event, name) {
    const [path] = store.selection;
    const [kind, ...numbers] = name.split(" ");
    const [a, b] = numbers.map(Number);
    if (kind === "corner") store.corner = { path, index: a };
    return pressed(event, () => {
      if (kind === "turn") return turning(path);
      if (kind === "size") return sizing(path, a, b);
      return bending(path, kind, a);
    });
  }

  function onPart(event, path) {
    const again = store.isSelected(path);
    if (event.shiftKey) {
      store.select(again ? store.selection.filter((it) => !samePath(it, path)) : [...store.selection, path]);
    } else if (!again) {
      store.select([path]);
    }
    const from = world(event);
    const copying = event.ctrlKey || event.metaKey;
    return pressed(event, () => moving(path, from, copying), () => !event.shiftKey && store.select([path]));
  }

  /** Returns a press with its number in `detail`: 2 for a double click. */
  function counted({ pointerId, clientX, clientY, shiftKey, altKey, timeStamp }) {
    const [x, y] = lastPress.at;
    const again = timeStamp - lastPress.time < 400 && Math.hypot(clientX - x, clientY - y) < 6;
    lastPress = { time: again ? 0 : timeStamp, at: [clientX, clientY] };
    return { pointerId, clientX, clientY, shiftKey, altKey, detail: again ? 2 : 1 };
  }

  element.addEventListener("pointerdown", (event) => {
    if (event.target.closest("button") || pointers.down(event)) return;
    if (event.button === 1 || (event.button === 0 && tools.spaceHeld)) {
      gesture = panning(event);
    } else if (event.button === 0) {
      const place = snapped(world(event), event, { corners: tools.current.corners });
      const key = event.target.closest("[data-key]")?.getAttribute("data-key");
      const handle = event.target.closest("[data-handle]")?.getAttribute("data-handle");
      if (tools.current.down) {
        gesture = tools.down(place, counted(event), event.target) ?? null;
      } else if (handle) {
        gesture = onHandle(event, handle);
      } else if (key && isOnMap(pathOf(key))) {
        gesture = onPart(event, pathOf(key));
      } else {
        const from = world(event);
        gesture = pressed(event, () => boxing(from, event), () => !event.shiftKey && store.select([]));
      }
      const part = !tools.current.down && (handle || key) && event.target.closest("[tabindex]");
      (part || element).focus({ preventScroll: true });
    }
    if (event.button < 2) event.preventDefault();
    if (gesture) element.setPointerCapture(event.pointerId);
  });

  element.addEventListener("pointermove", (event) => {
    last = event;
    if (pointers.move(event) || framed) return;
    framed = true;
    requestAnimationFrame(() => {
      framed = false;
      const at = world(last);
      store.tell("pointer", { at });
      if (gesture) gesture.move(last);
      else tools.hover(snapped(at, last, { corners: tools.current.corners }), last);
    });
  });

  element.addEventListener("pointerup", (event) => {
    pointers.up(event);
    if (!gesture) return;
    // The last place counts, even if its frame has not come.
    gesture.move(event);
    gesture?.end(event);
    gesture = null;
  });
  element.addEventListener("pointercancel", (event) => {
    pointers.up(event);
    gesture?.cancel();
    gesture = null;
  });
  element.addEventListener("pointerleave", () => store.tell("pointer", { at: null }));
  element.addEventListener("focusin", (event) => {
    // Focus selects, but for that which a press gives.
    const key = event.target.getAttribute?.("data-key");
    if (key && !gesture && event.target.matches(":focus-visible") && isOnMap(pathOf(key))) store.select([pathOf(key)]);
  });

  return {
    snapped,
    get busy() {
      return gesture !== null;
    },
    /** Takes a gesture back; returns whether there was one. */
    cancel() {
      if (!gesture) return false;
      gesture.cancel();
      gesture = null;
      return true;
    },
  };
}
