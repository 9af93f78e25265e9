import { button, fill, h, refill } from "./dom.js";
import { keyOf, valueAt } from "./data.js";
import { PLACES, ROBOT, ROBOTS, isGoal, isOnMap, isPerson, isRobotPlace, placeOf, placesOf, robotPath, robotsOf } from "./things.js";
import { alignOps, deleteOps, duplicateOps, copied, groupOps, wordsFor } from "./changes.js";
import { describe, memberOf, nodeAt } from "./schema.js";
import { Target } from "./fields.js";
import { makeField, objectBody } from "./parts.js";

/** The first fields of a person, a wall or the robot. */
const FIRST = ["name", "number", "type", "slots", "robot", "planner", "sensors", "pose", "start", "goal", "center", "yaw", "size", "behavior", "desired_speed", "goals", "cyclic", "group_id", "radius", "points", "height", "file", "round", "load", "goal_tolerance"];

/** Returns the parts that have forms: the person of a goal, the robot. */
function ownersOf(paths) {
  const owners = paths.map((it) => (isGoal(it) ? it.slice(0, 2) : isRobotPlace(it) ? robotPath(it) : it));
  const seen = new Map(owners.map((it) => [keyOf(it), it]));
  return [...seen.values()];
}

/** Returns the mark of a part: parts with equal marks share a form. */
function markOf(store, path) {
  const node = nodeAt(store.catalog.schema, store.data, path);
  const tag = node.kind === "union" ? memberOf(node, valueAt(store.data, path))?.tag : "";
  return `${path.map((it) => (typeof it === "number" ? "#" : it)).join("/")} ${tag}`;
}

/**
 * Adds a strip below a form with the help of the focused field, so that nothing
 * moves when it changes.
 */
function withHelp(element) {
  const strip = h("div", { class: "help-strip", "aria-hidden": "true", hidden: true });
  const tell = (event) => {
    const field = event.target.closest?.(".field");
    const text = field?.querySelector(":scope > .help")?.textContent ?? "";
    if (!text && event.type === "pointerover") return;
    strip.textContent = text;
    strip.hidden = !text;
  };
  element.addEventListener("focusin", tell);
  element.addEventListener("pointerover", (event) => element.contains(document.activeElement) || tell(event));
  element.addEventListener("pointerleave", () => element.contains(document.activeElement) || (strip.hidden = true));
  return h("div", { class: "with-help" }, element, strip);
}

/** Creates the form of the selected parts. */
export function makeFormPanel(store) {
  const title = h("h2", { class: "panel-title" });
  const actions = h("div", { class: "actions" });
  const body = h("div", { class: "form-body" });
  const element = h("div", { class: "panel form" }, h("div", { class: "panel-head" }, title, actions), body);
  let shown = null;
  let form = null;

  function build() {
    const { selection, catalog } = store;
    const owners = ownersOf(selection);
    const marks = new Set(owners.map((it) => markOf(store, it)));
    const key = `${owners.map(keyOf).join()} ${[...marks].join()}`;
    if (shown !== key || form?.schema !== catalog.schema) {
      shown = key;
      form = null;
      const root = catalog.schema;
      const target = new Target(store, owners, () => wordsFor(store.data, ownersOf(store.selection)));
      if (!owners.length) {
        fill(body, overview(store));
      } else if (marks.size > 1) {
        fill(body, h("p", { class: "help shown" }, "These parts are of different types. They can be moved, aligned, copied and deleted together."));
      } else {
        let node = nodeAt(root, store.data, owners[0]);
        if (node.kind === "union") {
          const member = memberOf(node, valueAt(store.data, owners[0])) ?? (valueAt(store.data, owners[0]) === undefined ? node.members[0] : null);
          node = describe(root, member?.schema ?? {});
        }
        if (node.kind === "object") {
          const fields = h("div");
          const several = owners.length > 1;
          const without = several ? ["name", "id", "pose", "center", "points", "goals"] : [];
          form = objectBody(target, root, node, [], fields, { first: FIRST, without, rest: true });
          fill(body, fields);
          if (owners[0][0] === ROBOTS) fields.querySelector("[data-field=robot] details").open = true;
        } else {
          form = makeField(target, root, node, []);
          fill(body, form.element);
        }
        form.schema = root;
      }
    }
    refresh();
  }

  function refresh() {
    const { data, selection } = store;
    const owners = ownersOf(selection);
    title.textContent = selection.length ? wordsFor(data, selection.length === 1 ? selection : owners) : store.name || "Scenario";
    refill(actions, selection.length ? actionsFor() : []);
    form?.refresh();
  }

  function actionsFor() {
    const { data, selection } = store;
    const people = selection.filter(isPerson);
    const parts = selection.filter(isOnMap);
    const places = parts.map((path) => ({ path, at: placeOf(data, store.outlines, path) }));
    return [
      people.length > 1 && button("group", "Make a group (Ctrl+G)", () => store.edit(`Group ${wordsFor(data, people)}`, groupOps(data, people, true))),
      parts.length > 1 && button("alignx", "Align on one vertical line", () => store.edit(`Align ${wordsFor(data, parts)}`, alignOps(data, places, 0))),
      parts.length > 1 && button("aligny", "Align on one horizontal line", () => store.edit(`Align ${wordsFor(data, parts)}`, alignOps(data, places, 1))),
      parts.length > 0 && button("copy", "Duplicate (Ctrl+D)", () => {
        const { ops, paths } = duplicateOps(data, copied(data, parts), 0.5, -0.5);
        store.edit(`Copy ${wordsFor(data, parts)}`, ops);
        if (paths.length) store.select(paths);
      }),
      parts.length > 0 && button("array", "Repeat in rows and columns", () => store.tell("dialog", { what: "array" })),
      button("bin", "Delete (Del)", () => store.edit(`Delete ${wordsFor(data, selection)}`, deleteOps(data, selection))),
    ].filter(Boolean);
  }

  store.listen("selection", build);
  store.listen("catalog", build);
  store.listen("data", build);
  store.listen("faults", refresh);
  return withHelp(element);
}

/** The text if nothing is selected. */
function overview(store) {
  const count = (n, one, many) => `${n} ${n === 1 ? one : many}`;
  const facts = () => {
    const { data } = store;
    const world = data.world ?? {};
    return [
      count(data.humans?.length ?? 0, "person", "people"),
      count(world.walls?.length ?? 0, "wall", "walls"),
      count(world.furniture?.length ?? 0, "piece of furniture", "pieces of furniture"),
      ...(placesOf(data).length ? [count(placesOf(data).length, "place", "places")] : []),
      robotsOf(data).length > 1 ? `${data.robots.length} robots` : data.robot?.goal ? "a robot with a goal" : "a robot without a goal",
    ];
  };
  const list = h("ul", { class: "facts" });
  const show = () => fill(list, facts().map((it) => h("li", null, it)));
  show();
  const stop = store.listen("data", () => (list.isConnected ? show() : stop()));
  return [
    list,
    h("p", { class: "help shown" }, "Click a part of the map to see its properties, or pull a box around several. Choose a tool above to add something."),
    h("div", { class: "row" }, button("person", "Add a person (P)", () => store.tools.choose("person"), { text: "Person" }), button("room", "Add a room", () => store.tools.choose("room"), { text: "Room" }), button("furniture", "Add furniture (F)", () => store.tools.choose("furniture"), { text: "Furniture" })),
  ];
}

/** Creates the form of the trial: all except people, walls and furniture. */
export function makeTrialPanel(store) {
  const body = h("div", { class: "form-body" });
  const element = h("div", { class: "panel form" }, body);
  let form = null;
  let schema = null;
  let several = false;
  function build() {
    const root = store.catalog.schema;
    const now = robotsOf(store.data)[0][0] === ROBOTS;
    if ((root === schema && several === now) || !root.properties) return form?.refresh();
    schema = root;
    several = now;
    const target = new Target(store, [[]], () => "the trial");
    const node = describe(root, root);
    const box = h("div");
    form = objectBody(target, root, node, [], box, {
      without: ["humans", "world", PLACES, ROBOTS, ...(several ? [ROBOT, "planner"] : [])],
      first: ["name", "description", "simulation", "planner", "robot", "crowd", "evaluator"],
    });
    fill(body, box);
    return form.refresh();
  }
  store.listen("catalog", build);
  store.listen("data", build);
  store.listen("faults", () => form?.refresh());
  return withHelp(element);
}
