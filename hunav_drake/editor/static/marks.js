import { svg } from "./dom.js";
import { keyOf, pathOf, valueAt } from "./data.js";
import { ROBOT, ROBOTS, behaviorOf, drawnOf, goalsOf, nameOf, peopleOf, startOf } from "./things.js";

/** Returns the key of the nearest drawing to a path, or null. */
function nearest(drawn, path) {
  for (let n = path.length; n >= 2; n--) {
    const key = keyOf(path.slice(0, n));
    if (drawn.has(key)) return key;
    // Goals are drawn with their person.
    if (n === 4 && path[2] === "goals") return key;
  }
  if (path[0] === ROBOTS && path.length > 1) return keyOf(startOf([...path.slice(0, 2), ROBOT]));
  return path[0] === ROBOT ? keyOf(startOf([ROBOT])) : null;
}

/** Shows the faults of a drawing as its tooltip. */
function tell(element, title, faults) {
  const text = faults.map((it) => it.message).join("\n");
  if (element.told === `${title}\n${text}`) return;
  element.told = `${title}\n${text}`;
  element.setAttribute("aria-label", faults.length ? `${title}, fault: ${text}` : title);
  if (faults.length) element.setAttribute("aria-description", text);
  else element.removeAttribute("aria-description");
  let tip = element.querySelector(":scope > title");
  if (!tip) element.prepend((tip = svg("title", null)));
  const words = faults.length ? `${title}\n${text}` : title;
  if (tip.textContent !== words) tip.textContent = words;
}

/**
 * Returns a function that marks parts that are selected, faulty, or used by a
 * fault, and describes them in words.
 */
export function makeMarks(store, map) {
  function titleOf(path) {
    const { data, catalog } = store;
    if (path[0] === "drawn") {
      const { human, seed } = drawnOf(store, data)[path[1]] ?? {};
      return `${human?.name || "somebody"}, drawn by the seed ${seed}; drag to make the people of this cohort your own`;
    }
    const name = nameOf(data, path);
    if (path[0] !== "humans" || path.length !== 2) return name;
    const person = peopleOf(data)[path[1]];
    const goals = goalsOf(person).length;
    return `${name}, ${behaviorOf(person, catalog.defaults?.human)}, ${goals} ${goals === 1 ? "goal" : "goals"}`;
  }

  function goalTitle(path) {
    const person = valueAt(store.data, path.slice(0, 2));
    const all = goalsOf(person).length;
    return `${nameOf(store.data, path.slice(0, 2))}, goal ${path[3] + 1} of ${all}`;
  }

  return () => {
    const { drawn, element } = map;
    const selected = new Set(store.selection.map(keyOf));
    const faults = new Map();
    const used = new Set();
    for (const fault of store.faults) {
      const key = nearest(drawn, fault.path);
      if (key) faults.set(key, [...(faults.get(key) ?? []), fault]);
      for (const path of fault.uses ?? []) {
        const other = nearest(drawn, path);
        if (other && other !== key) used.add(other);
      }
    }
    element.classList.toggle("has-selection", selected.size > 0);
    for (const [key, { shape }] of drawn) {
      const { classList } = shape.element;
      if (key.startsWith("chain:")) {
        const person = key.slice(6);
        let inside = selected.has(person);
        for (const { element: dot } of shape.dots) {
          const goal = dot.getAttribute("data-key");
          const on = selected.has(goal);
          inside ||= on;
          dot.classList.toggle("selected", on);
          dot.classList.toggle("faulty", faults.has(goal));
          dot.classList.toggle("used", used.has(goal));
          tell(dot, goalTitle(pathOf(goal)), faults.get(goal) ?? []);
        }
        classList.toggle("selected", inside);
        continue;
      }
      const on = selected.has(key);
      const bad = faults.get(key) ?? [];
      classList.toggle("selected", on);
      classList.toggle("faulty", bad.some((it) => it.severity !== "warning"));
      classList.toggle("warned", bad.length > 0 && bad.every((it) => it.severity === "warning"));
      classList.toggle("used", used.has(key));
      tell(shape.element, titleOf(pathOf(key)), bad);
    }
  };
}
