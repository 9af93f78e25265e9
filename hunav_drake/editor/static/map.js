import { atFrame, h, svg } from "./dom.js";
import { keyOf, valueAt } from "./data.js";
import { PLACES, ROBOTS, boundsOf, drawnOf, goalOf, groupOf, isPoint, isPose, nameOf, peopleOf, placesOf, robotsOf, startOf } from "./things.js";
import { ChainShape, PersonShape, PlaceShape, RobotShape, WorldShape, outline } from "./shapes.js";
import { lookOf, robotColor } from "./looks.js";
import { View } from "./view.js";
import { cornersOf, makeBackdrop } from "./backdrop.js";
import { makeMarks } from "./marks.js";
import { drawHandles } from "./handles.js";

/**
 * The map: one SVG with fixed parts, and above it a second one with parts that
 * are dragged, so that a drag repaints only these.
 */

const NONE = {};

/** The layers from back to front; each is a group of the lower SVG. */
const LAYERS = ["areas", "fixtures", "places", "groups", "chains", "robot-goals", "robots", "drawn", "people"];

/**
 * Creates the map of a store.
 */
export function makeMap(store) {
  const view = new View();
  const layers = Object.fromEntries(LAYERS.map((name) => [name, svg("g", { class: name })]));
  const mission = svg("path", { class: "mission" });
  layers.robots.append(mission);
  const world = svg("g", { class: "world" }, ...Object.values(layers));
  const held = svg("g", { class: "held" });
  const ghosts = svg("g", { class: "ghosts", "aria-hidden": "true" });
  const sketch = svg("g", { class: "sketch" });
  const handles = svg("g", { class: "handles" });
  const raised = svg("g", { class: "world" }, ghosts, held, sketch, handles);
  const backdrop = makeBackdrop(store, view);
  const base = svg("svg", { class: "base" }, backdrop.behind, world);
  const lifted = svg("svg", { class: "lifted" }, raised);
  const element = h(
    "div",
    { class: "map", tabindex: 0, role: "application", "aria-label": "Map of the scenario. Tab moves to its parts, ? shows the keys." },
    base,
    lifted,
    backdrop.front,
  );

  /** @type {Map<string, {shape: any, value: any, layer: string}>} */
  const drawn = new Map();
  let shown = { data: store.data, outlines: store.outlines };
  // Whether all was shown once, and whether the view has not changed since.
  let fitted = false;
  let isFitted = false;
  let sized = false;

  const look = (name) => lookOf(store.catalog, name);
  // One object, because another one would recreate the drawings.
  const personDefaults = () => store.catalog.defaults?.human ?? NONE;

  function draw(key, layer, value, make, update, others = []) {
    let entry = drawn.get(key);
    if (!entry) {
      entry = { shape: make(), layer };
      drawn.set(key, entry);
      layers[layer].append(entry.shape.element);
    }
    entry.seen = true;
    const facts = [value, ...others];
    if (entry.facts && facts.every((it, i) => it === entry.facts[i])) return;
    entry.facts = facts;
    update(entry.shape);
    entry.shape.zoomed(view.scale);
  }

  /** Draws data and outlines, and updates only differences. */
  function render(data = store.data, outlines = store.outlines) {
    shown = { data, outlines };
    const focused = element.contains(document.activeElement) ? document.activeElement : null;
    for (const [key, it] of Object.entries(outlines)) {
      const layer = key.startsWith("world/") ? "fixtures" : "areas";
      if (it?.points?.length) draw(key, layer, it, () => new WorldShape(key), (shape) => shape.update(it));
    }
    const { behaviors } = store.catalog;
    const defaults = personDefaults();
    peopleOf(data).forEach((person, i) => {
      const key = `humans/${i}`;
      const facts = [behaviors, defaults];
      draw(key, "people", person, () => new PersonShape(key), (it) => it.update(person, look, defaults), facts);
      draw(`chain:${key}`, "chains", person, () => new ChainShape(key), (it) => it.update(person, look, defaults), facts);
    });
    drawnOf(store, data).forEach(({ human }, i) => {
      const key = `drawn/${i}`;
      draw(key, "drawn", human, () => new PersonShape(key), (it) => it.update(human, look, defaults), [behaviors, defaults]);
    });
    placesOf(data).forEach((place, i) => {
      const path = [PLACES, i];
      const name = nameOf(data, path);
      draw(keyOf(path), "places", data[PLACES][i], () => new PlaceShape(keyOf(path)), (it) => it.update(place, name));
    });
    const robots = robotsOf(data);
    const ways = robots.map((robot, k) => {
      const radius = valueAt(data, [...robot, "radius"]) ?? store.catalog.defaults?.robot?.radius ?? 0.35;
      const places = [valueAt(data, startOf(robot)) ?? store.catalog.defaults?.robot?.start, valueAt(data, goalOf(robot))];
      const color = robotColor(store.catalog, k, robots.length);
      places.forEach((pose, i) => {
        if (!isPose(pose)) return;
        const path = i ? goalOf(robot) : startOf(robot);
        const key = keyOf(path);
        // A single robot has no name.
        const name = i && robots.length === 1 ? "goal" : nameOf(data, path);
        // The start of a robot may be at the goal of another one.
        draw(key, i && robot[0] === ROBOTS ? "robot-goals" : "robots", pose, () => new RobotShape(key, i === 1), (it) => it.update(pose, radius, name, color), [radius, name, color]);
      });
      return places.every(isPose) ? outline(places, false) : "";
    });
    const way = ways.join("");
    // Setting an equal value would repaint the whole lower SVG.
    if (mission.getAttribute("d") !== way) mission.setAttribute("d", way);
    drawGroups(data);
    for (const [key, entry] of drawn) {
      if (!entry.seen) {
        entry.shape.element.remove();
        drawn.delete(key);
      }
      entry.seen = false;
    }
    if (focused && !focused.isConnected) element.focus({ preventScroll: true });
    drawHandles(handles, store, shown, view.scale);
  }

  function drawGroups(data) {
    const groups = new Map();
    for (const person of peopleOf(data)) {
      const id = groupOf(person);
      if (id >= 0 && isPoint(person.pose)) groups.set(id, [...(groups.get(id) ?? []), person.pose]);
    }
    const paths = [...groups.values()].filter((it) => it.length > 1).map((it) => outline(it, it.length > 2));
    const d = paths.join("");
    if (layers.groups.dataset.d === d) return;
    layers.groups.dataset.d = d;
    layers.groups.replaceChildren(...paths.map((it) => svg("path", { class: "group", d: it })));
  }

  /** The box around all parts, and around a background. */
  const bounds = () => boundsOf(store.data, store.outlines, cornersOf(store.background));

  /** Updates it after a change of the view. */
  function showView() {
    world.setAttribute("transform", view.matrix);
    raised.setAttribute("transform", view.matrix);
    element.style.setProperty("--px", String(1 / view.scale));
    backdrop.update();
    if (map.drawnScale !== view.scale) {
      map.drawnScale = view.scale;
      for (const { shape } of drawn.values()) shape.zoomed(view.scale);
      drawHandles(handles, store, shown, view.scale);
    }
    store.tell("view");
  }

  const map = {
    element,
    view,
    sketch,
    ghosts,
    drawn,
    render,
    looked: atFrame(showView),

    /** Pixels per meter. */
    get scale() {
      return view.scale;
    },

    /** The drawn data and outlines, also during a drag. */
    get shown() {
      return shown;
    },

    /** Makes all except the ghosts pale, while a run is shown. */
    dim: (on) => element.classList.toggle("dimmed", on),

    /** Shows the whole scenario. */
    fit() {
      isFitted = true;
      view.fit(bounds());
      showView();
    },

    zoom(factor, px, py) {
      isFitted = false;
      view.zoom(factor, px, py);
      map.looked();
    },

    pan(dx, dy) {
      isFitted = false;
      view.pan(dx, dy);
      map.looked();
    },

    /** Returns the position of an event on the map, in pixels. */
    pixels(event) {
      const box = element.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    },

    /** Moves drawings to the upper SVG. */
    lift(keys) {
      const focused = document.activeElement;
      for (const key of keys) {
        const entry = drawn.get(key);
        if (!entry || entry.place) continue;
        entry.place = document.createComment("");
        entry.shape.element.replaceWith(entry.place);
        held.append(entry.shape.element);
      }
      if (held.contains(focused)) focused.focus({ preventScroll: true });
    },

    /** Moves them back. */
    drop() {
      const focused = document.activeElement;
      const inside = held.contains(focused);
      for (const entry of drawn.values()) {
        if (!entry.place) continue;
        entry.place.replaceWith(entry.shape.element);
        entry.place = null;
      }
      if (inside) focused.focus({ preventScroll: true });
    },

    /** Focuses a part, if it is drawn, else the map. */
    focus(path) {
      const found = path && element.querySelector(`[data-key="${CSS.escape(keyOf(path))}"]`);
      (found ?? element).focus({ preventScroll: true });
    },
  };

  const marks = makeMarks(store, map);
  const redraw = () => {
    render();
    marks();
    if (!fitted && sized && store.started) {
      fitted = true;
      map.fit();
      store.root.dataset.ready = "";
    }
  };
  store.listen("data", redraw);
  store.listen("catalog", redraw);
  store.listen("drawn", redraw);
  store.listen("state", ({ changes }) => {
    // Another file or template is shown as a whole.
    if (changes.some(([path]) => path.length === 0) && map.fitNext) {
      map.fitNext = false;
      map.fit();
    }
  });
  store.listen("background", () => fitted && isFitted && map.fit());
  store.listen("faults", marks);
  store.listen("selection", () => {
    marks();
    drawHandles(handles, store, shown, view.scale);
  });
  new ResizeObserver(() => {
    const middle = view.middle;
    [view.width, view.height] = [element.clientWidth, element.clientHeight];
    if (!view.width || !view.height) return;
    if (fitted && isFitted) {
      view.fit(bounds());
    } else if (fitted) {
      const [px, py] = view.toScreen(...middle);
      view.pan(view.width / 2 - px, view.height / 2 - py);
    }
    sized = true;
    redraw();
    showView();
  }).observe(element);
  return map;
}
