import { pathOf, round, samePath } from "./data.js";
import { COHORTS, cohortsOf, drawnOf, isOnMap, placeOf } from "./things.js";
import { cornerNear } from "./changes.js";
import { makeDrags } from "./drags.js";
import { onLines } from "./walllines.js";
import { addWheelAndPinch } from "./zoom.js";
import { svg } from "./dom.js";
import { outline } from "./shapes.js";

/** The distance after which a press becomes a drag, in pixels. */
const THRESHOLD = 3;

/**
 * Adds the gestures of mouse, pen and finger on the map: select, move, turn,
 * resize, select by a box, pan. The tools add parts.
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

  /** Returns a place on the grid of 0.1 m, on a near corner, or on the middle of walls. */
  function snapped(at, event, { corners = false, besides = null, lines = false, from = at } = {}) {
    if (!store.snap || event.altKey) return at.map(round);
    const grid = at.map((it) => round(Math.round(it * 10) / 10));
    // Walls nearer than their thickness would overlap.
    const middle = lines && onLines(store.get(["world", "walls"]), at, Math.max(0.16, 10 / map.scale), from);
    if (middle) return middle.map((it, i) => it ?? grid[i]);
    const corner = corners && cornerNear(store.outlines, at, 10 / map.scale, besides);
    return corner ? corner.slice(0, 2).map(round) : grid;
  }

  store.snapped = snapped;
  const drags = makeDrags(store, map, { world, snapped, ended: () => (gesture = null) });

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
      if (kind === "turn") return drags.turning(path);
      if (kind === "size") return drags.sizing(path, a, b);
      if (kind === "radius") return drags.widening(path);
      return drags.bending(path, kind, a);
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
    return pressed(event, () => drags.moving(path, from, copying), () => !event.shiftKey && store.select([path]));
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
      const place = snapped(world(event), event, tools.current);
      const key = event.target.closest("[data-key]")?.getAttribute("data-key");
      const handle = event.target.closest("[data-handle]")?.getAttribute("data-handle");
      if (tools.current.down) {
        gesture = tools.down(place, counted(event), event.target) ?? null;
      } else if (handle) {
        gesture = onHandle(event, handle);
      } else if (key?.startsWith("drawn/")) {
        const from = world(event);
        const number = Number(key.slice(6));
        // A click shows the cohort.
        const { source } = drawnOf(store, store.data)[number] ?? {};
        const path = [...COHORTS, cohortsOf(store.data).indexOf(source)];
        gesture = pressed(event, () => drags.owning(number, from), () => store.select([path]));
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
      else tools.hover(snapped(at, last, tools.current), last);
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
    // Focus selects, except after a press.
    const key = event.target.getAttribute?.("data-key");
    if (key && !gesture && event.target.matches(":focus-visible") && isOnMap(pathOf(key))) store.select([pathOf(key)]);
  });

  return {
    snapped,
    get busy() {
      return gesture !== null;
    },
    /** Cancels the gesture; returns whether there was one. */
    cancel() {
      if (!gesture) return false;
      gesture.cancel();
      gesture = null;
      return true;
    },
  };
}
