import { atFrame, button, fill, h } from "./dom.js";
import { isWithin, keyOf, pathOf, samePath, valueAt } from "./data.js";
import { COHORTS, HUMANS, PLACES, cohortsOf, ROBOT, ROBOTS, behaviorOf, goalOf, groupOf, isPlace, isPose, isRobotPlace, nameOf, peopleOf, placesOf, robotPath, robotsOf, startOf, worldLists } from "./things.js";
import { lookOf, paintRobot, robotColor } from "./looks.js";
import { inkOn } from "./shapes.js";
import { ownPeopleOps, robotOps } from "./changes.js";

/** Returns the parts by section: [{title, key, items: [path...]}]. */
export function partsOf(data) {
  const parts = [{ title: "People", key: HUMANS, items: peopleOf(data).map((_, i) => [HUMANS, i]) }];
  const cohorts = cohortsOf(data);
  if (cohorts.length) parts.push({ title: "Drawn people", key: "population", items: cohorts.map((_, i) => [...COHORTS, i]) });
  const robots = robotsOf(data);
  const places = robots.flatMap((it) => [startOf(it), goalOf(it)]);
  parts.push({ title: robots.length > 1 ? "Robots" : "Robot", key: ROBOT, items: places.filter((path, i) => i % 2 === 0 || isPose(valueAt(data, path))) });
  const all = placesOf(data);
  if (all.length) parts.push({ title: "Places", key: PLACES, items: all.map((_, i) => [PLACES, i]) });
  for (const [key, items] of worldLists(data)) {
    parts.push({ title: key[0].toUpperCase() + key.slice(1), key: `world/${key}`, items: items.map((_, i) => ["world", key, i]) });
  }
  return parts;
}

/** Adds a robot, and selects it. */
export function addRobot(store) {
  const { ops, path } = robotOps(store.data, store.catalog.defaults, store.outlines);
  store.edit("Add a robot", ops);
  store.select([path]);
}

/** Returns the button that makes the people of the selected cohort people of their own, if they are known. */
function ownButton(store) {
  const [path] = store.selection.filter((it) => it[1] === "cohorts");
  const { ops, paths } = path ? ownPeopleOps(store, path[2]) : { paths: [] };
  if (!paths.length) return null;
  const act = () => {
    store.edit(`Make ${paths.length} people of ${nameOf(store.data, path)} their own`, ops);
    store.select(paths);
  };
  return button("person", "Lists these people where they are; the seed no longer draws them", act, { text: "Make them your own" });
}

/** Creates the list of all parts, with a search. */
export function makeOutline(store) {
  const search = h("input", { type: "search", placeholder: "Search", "aria-label": "Search the parts", oninput: () => show() });
  const tree = h("div", { class: "outline-tree" });
  const background = h("div", { class: "outline-background" });
  const element = h("div", { class: "panel outline" }, h("div", { class: "search" }, search), tree, background);
  const folded = new Set();
  const rows = new Map();

  function rowFor(path) {
    const key = keyOf(path);
    if (rows.has(key)) return rows.get(key);
    const mark = h("span", { class: "mark", "aria-hidden": "true" });
    const name = h("span", { class: "row-name" });
    const note = h("span", { class: "row-note" });
    const fault = h("span", { class: "row-fault", hidden: true }, "!");
    const row = h(
      "button",
      {
        type: "button",
        class: "row-item",
        "data-row": key,
        onclick(event) {
          if (event.shiftKey || event.ctrlKey || event.metaKey) {
            const others = store.selection.filter((it) => !samePath(it, path));
            store.select(others.length === store.selection.length ? [...others, path] : others);
          } else {
            store.select([path]);
            store.showTab("properties");
          }
        },
        ondblclick: () => store.map.focus(path),
      },
      mark,
      name,
      note,
      fault,
    );
    rows.set(key, { row, mark, name, note, fault });
    return rows.get(key);
  }

  function update(path) {
    const { row, mark, name, note, fault } = rowFor(path);
    const { data, catalog } = store;
    name.textContent = nameOf(data, path);
    const isPerson = path[0] === HUMANS;
    const person = isPerson ? data[HUMANS][path[1]] : null;
    if (person) {
      const behavior = behaviorOf(person, catalog.defaults?.human);
      const { color, letter } = lookOf(catalog, behavior);
      mark.textContent = letter;
      mark.style.setProperty("--who", color);
      mark.style.setProperty("--ink", inkOn(color));
      note.textContent = groupOf(person) >= 0 ? `group ${groupOf(person)}` : "";
    }
    if (path[1] === "cohorts") note.textContent = String(store.get(path)?.number ?? "");
    mark.className = person ? "mark who" : `mark of-${isPlace(path) ? "place" : isRobotPlace(path) ? `robot-${path.at(-1)}` : path.length === 2 ? path.join("-") : path[1]}`;
    if (isRobotPlace(path)) paintRobot(mark, robotColor(catalog, path[1], robotsOf(data).length));
    const faults = store.faults.filter((it) => isWithin(it.path, path) || (path[0] === ROBOTS && path.at(-1) === "start" && isWithin(it.path, robotPath(path)) && it.path[3] !== "goal"));
    fault.hidden = !faults.length;
    row.title = faults.map((it) => it.message).join("\n");
    const on = store.selection.some((it) => isWithin(it, path));
    row.classList.toggle("selected", on);
    row.setAttribute("aria-pressed", String(on));
    return row;
  }

  function show() {
    const wanted = search.value.trim().toLowerCase();
    const focused = document.activeElement?.dataset?.row;
    const matches = (path) => !wanted || `${nameOf(store.data, path)} ${JSON.stringify(store.get(path))}`.toLowerCase().includes(wanted);
    const seen = new Set();
    const groups = partsOf(store.data).map(({ title, key, items }) => {
      const found = items.filter(matches);
      if (wanted && !found.length) return null;
      items.forEach((path) => seen.add(keyOf(path)));
      const open = wanted || !folded.has(key);
      return h(
        "section",
        null,
        h(
          "button",
          {
            type: "button",
            class: "group-head",
            "aria-expanded": String(Boolean(open)),
            onclick() {
              if (!folded.delete(key)) folded.add(key);
              show();
            },
          },
          title,
          h("span", { class: "row-note" }, String(items.length)),
        ),
        open ? found.map(update) : null,
        open && key === "population" && !wanted ? ownButton(store) : null,
        open && key === ROBOT && !wanted ? button("plus", "Add a robot beside the last one, with the same properties", () => addRobot(store), { text: "Add robot" }) : null,
      );
    });
    fill(tree, groups);
    for (const key of rows.keys()) if (!seen.has(key)) rows.delete(key);
    if (focused) rows.get(focused)?.row.focus({ preventScroll: true });
  }

  const later = atFrame(show);
  for (const kind of ["data", "catalog", "drawn"]) store.listen(kind, later);
  let wrong = [];
  store.listen("faults", () => {
    // Only rows whose faults have changed.
    const now = [...rows.keys()].filter((key) => store.faults.some((it) => isWithin(it.path, pathOf(key))));
    for (const key of new Set([...wrong, ...now])) {
      if (rows.has(key) && store.get(pathOf(key)) !== undefined) update(pathOf(key));
    }
    wrong = now;
  });
  store.listen("selection", () => {
    later();
    const [path] = store.selection;
    if (path) requestAnimationFrame(() => rows.get(keyOf(path.slice(0, path[0] === HUMANS ? 2 : 4)))?.row.scrollIntoView?.({ block: "nearest" }));
  });

  store.listen("background", (message) => {
    if (!message.image) return fill(background);
    const opacity = h("input", {
      type: "range",
      min: 0,
      max: 1,
      step: 0.05,
      value: String(message.opacity ?? 0.6),
      "aria-label": "Opacity of the background",
      oninput: () => store.tell("background-opacity", { value: Number(opacity.value) }),
    });
    return fill(
      background,
      h("div", { class: "group-head" }, "Background"),
      h("div", { class: "row-item" }, h("span", { class: "row-name" }, message.name || "picture"), button("bin", "Remove the background", () => store.send({ do: "background", files: {}, remove: true }))),
      opacity,
      message.is_map ? null : button("measure", "Set the size of the picture by two places with a known distance", () => store.tools.choose("scale"), { text: "Set scale" }),
      button("polygon", "Convert dark areas to walls", () => store.ask({ do: "trace" }), { text: "Trace walls" }),
    );
  });
  return element;
}
