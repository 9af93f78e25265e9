import { svg } from "./dom.js";
import { keyOf, round, valueAt } from "./data.js";
import { PLACES, goalOf, goalsOf, isPerson, isPoint, isRobotPlace, nameOf, peopleOf, personPath, placesOf, robotsOf, startOf } from "./things.js";
import { freeName, ownCopy, segmentAt } from "./changes.js";
import { worldTools } from "./worldtools.js";
import { scaleTool } from "./scaletool.js";

/** The least length of a pull that sets a heading, in pixels. */
const PULL = 8;

/** Reads a place and a heading from press, pull and release. */
export function pulled(store, map, place, opsFor, done) {
  let yaw = 0;
  let label = "";
  let ops = [];
  const show = () => {
    [label, ops] = opsFor([...place, yaw]);
    map.sketch.replaceChildren(
      svg("circle", { class: "sketch-disc", cx: place[0], cy: place[1], r: 0.35 }),
      svg("path", { class: "sketch-line", d: `M${place.join(" ")}l${0.9 * Math.cos(yaw)} ${0.9 * Math.sin(yaw)}` }),
    );
  };
  const stop = () => map.sketch.replaceChildren();
  show();
  return {
    move(event) {
      const [x, y] = map.view.toWorld(...map.pixels(event));
      const [dx, dy] = [x - place[0], y - place[1]];
      if (Math.hypot(dx, dy) * map.scale < PULL) return;
      const part = event.shiftKey ? Math.PI / 12 : Math.PI / 180;
      yaw = round(Math.round(Math.atan2(dy, dx) / part) * part);
      show();
    },
    end() {
      stop();
      store.edit(label, ops);
      done?.();
    },
    cancel: stop,
  };
}

function personTool(store, map) {
  let path = null;
  return {
    name: "person",
    title: "Person",
    icon: "person",
    key: "p",
    get hint() {
      return path ? "Click the goals in order. A double click or Enter ends." : "Press at the start of the person, and pull in its heading.";
    },
    down(place, event) {
      if (path && valueAt(store.data, path)) {
        if (event.detail > 1) return this.finish();
        const { length } = goalsOf(valueAt(store.data, path));
        store.edit(`Add a goal to ${nameOf(store.data, path)}`, [["insert", [...path, "goals", length], place]]);
        return null;
      }
      return this.start(place);
    },
    start(place) {
      const index = peopleOf(store.data).length;
      const name = freeName(`person_${index + 1}`, new Set(peopleOf(store.data).map((it) => it.name)));
      const opsFor = (pose) => [`Add ${name}`, [["insert", ["humans", index], { name, pose }]]];
      return pulled(store, map, place, opsFor, () => {
        path = ["humans", index];
        store.select([path]);
        store.tell("hint", { text: this.hint });
      });
    },
    /** Ends the chain of goals; returns whether there was one. */
    finish() {
      const had = path !== null;
      path = null;
      store.tell("hint", { text: this.hint });
      return had ? null : false;
    },
    leave: () => (path = null),
  };
}

function goalTool(store) {
  const person = () => store.selection.map(personPath).find((it) => it && isPerson(it)) ?? null;
  return {
    name: "goal",
    title: "Goals",
    icon: "goal",
    key: "g",
    get hint() {
      return person() ? "Click the next goal, the path to insert one, or the first goal for a loop." : "Click the person that gets goals.";
    },
    down(place, event, target) {
      if (event.detail > 1) return null;
      const key = target.closest?.("[data-key]")?.getAttribute("data-key") ?? "";
      const onPerson = /^humans\/\d+$/.test(key);
      const path = person();
      if (onPerson || !path) {
        if (onPerson) store.select([["humans", Number(key.split("/")[1])]]);
        store.tell("hint", { text: this.hint });
        return null;
      }
      const value = valueAt(store.data, path);
      const goals = goalsOf(value).map(({ at }) => at);
      const name = nameOf(store.data, path);
      if (key === keyOf([...path, "goals", 0])) {
        store.edit(`${value.cyclic ? "Do not send" : "Send"} ${name} round`, [["set", [...path, "cyclic"], !value.cyclic]]);
      } else if (target.closest?.(`[data-chain="${keyOf(path)}"]`) && goals.length) {
        const ring = [value.pose, ...goals, ...(value.cyclic ? [goals[0]] : [])].filter(isPoint);
        const { index } = segmentAt(ring, place);
        store.edit(`Insert a goal of ${name}`, [["insert", [...path, "goals", index - 1], place]]);
      } else {
        store.edit(`Add a goal to ${name}`, [["insert", [...path, "goals", goals.length], place]]);
      }
      return null;
    },
    finish: () => false,
  };
}

function robotTool(store, map, isGoal) {
  // Of several robots, it places the selected one.
  const place = () => {
    const chosen = store.selection.find(isRobotPlace)?.slice(0, -1) ?? robotsOf(store.data)[0];
    return isGoal ? goalOf(chosen) : startOf(chosen);
  };
  const words = () => (robotsOf(store.data).length > 1 ? nameOf(store.data, place()) : `the ${isGoal ? "robot's goal" : "robot"}`);
  return {
    name: isGoal ? "robot-goal" : "robot",
    title: isGoal ? "Robot's goal" : "Robot",
    icon: isGoal ? "target" : "robot",
    key: isGoal ? "R" : "r",
    get hint() {
      return `Press at the place of ${words()}, and pull in its heading.`;
    },
    down(at) {
      const path = place();
      const opsFor = (pose) => [`Place ${words()}`, [["set", path, pose]]];
      return pulled(store, map, at, opsFor, () => {
        store.select([path]);
        store.tools.choose("select");
      });
    },
    finish: () => false,
  };
}

function placeTool(store, map) {
  return {
    name: "place",
    title: "Place",
    icon: "place",
    key: "l",
    hint: "Press at the place that people go to, and pull in the direction that they face there.",
    down(at) {
      const places = placesOf(store.data);
      const place = ownCopy({ name: `place_${places.length + 1}` }, places);
      const path = [PLACES, places.length];
      const opsFor = (pose) => [`Add ${place.name}`, [["insert", path, { ...place, pose }]]];
      return pulled(store, map, at, opsFor, () => {
        store.select([path]);
        store.tools.choose("select");
      });
    },
    finish: () => false,
  };
}

function measureTool(store, map) {
  return {
    name: "measure",
    title: "Measure",
    icon: "measure",
    key: "m",
    hint: "Pull from one place to another.",
    corners: true,
    down(place) {
      const line = svg("path", { class: "sketch-line" });
      map.sketch.replaceChildren(line);
      return {
        move(event) {
          const [x, y] = map.view.toWorld(...map.pixels(event));
          line.setAttribute("d", `M${place.join(" ")}L${x} ${y}`);
          const [dx, dy] = [x - place[0], y - place[1]];
          const angle = (Math.atan2(dy, dx) * 180) / Math.PI;
          store.tell("hint", { text: `${Math.hypot(dx, dy).toFixed(2)} m, ${angle.toFixed(0)}°` });
        },
        end() {},
        cancel: () => map.sketch.replaceChildren(),
      };
    },
    finish: () => false,
    leave: () => map.sketch.replaceChildren(),
  };
}

/**
 * Creates the tools, one of which handles presses on the map.
 */
export function makeTools(store, map) {
  const select = { name: "select", title: "Select", icon: "select", key: "v", hint: "" };
  const list = [
    select,
    personTool(store, map),
    goalTool(store),
    robotTool(store, map, false),
    robotTool(store, map, true),
    placeTool(store, map),
    ...worldTools(store, map),
    measureTool(store, map),
    scaleTool(store, map),
  ];
  const cursor = svg("path", { class: "cursor" });
  let at = null;

  function showCursor() {
    const px = 1 / map.scale;
    const d = at ? `M${at[0] - 9 * px} ${at[1]}h${18 * px}M${at[0]} ${at[1] - 9 * px}v${18 * px}` : "";
    cursor.setAttribute("d", d);
    if (at && !cursor.isConnected) map.sketch.parentNode.append(cursor);
  }

  const tools = {
    list,
    current: select,
    spaceHeld: false,

    choose(name) {
      const tool = list.find((it) => it.name === name) ?? select;
      tools.current.leave?.();
      map.sketch.replaceChildren();
      tools.current = tool;
      tool.enter?.();
      at = null;
      showCursor();
      map.element.dataset.tool = tool.name;
      store.tell("hint", { text: tool.hint });
      store.tell("tool");
    },

    down(place, event, target) {
      return tools.current.down(place, event, target) || null;
    },

    hover(place, event) {
      tools.current.hover?.(place, event);
    },

    /** Ends the drawing, or else the tool; by Enter or Esc. */
    finish() {
      if (tools.current.finish?.() === false) tools.choose("select");
    },

    /** Moves the keyboard cursor, in meters. */
    moveCursor(dx, dy) {
      at ??= map.view.middle.map((it) => Math.round(it * 10) / 10);
      at = [round(at[0] + dx), round(at[1] + dy)];
      showCursor();
      tools.hover(at, {});
      store.tell("pointer", { at });
    },

    /** Acts like a click at the keyboard cursor. */
    pressCursor() {
      const place = at ?? map.view.middle.map((it) => Math.round(it * 10) / 10);
      const [px, py] = map.view.toScreen(...place);
      const event = { detail: 1, clientX: px, clientY: py };
      const gesture = tools.down(place, event, map.element);
      gesture?.end(event);
    },
  };
  store.listen("view", showCursor);
  store.listen("selection", () => tools.current !== select && store.tell("hint", { text: tools.current.hint }));
  map.element.dataset.tool = "select";
  return tools;
}
