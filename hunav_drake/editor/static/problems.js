import { button, h, refill } from "./dom.js";
import { isOnMap, nameOf, ROBOT, ROBOTS, startOf } from "./things.js";
import { sentence } from "./fields.js";

/** Returns a fault in a line that names its part: "ana pose: is inside ...". */
export const told = (store, fault) => `${fault.path.length ? nameOf(store.data, fault.path) : "The text"}: ${fault.message}`;

/** Does what the button of a fault says: an edit, or a request. */
export const applyFix = (store, { label, ops, do: request }) => (request ? store.ask({ do: request }) : store.edit(label, ops));

/** Selects the part with a fault, and shows its form. */
function showFault(store, fault) {
  for (let n = fault.path.length; n >= 2; n--) {
    const path = fault.path.slice(0, n);
    if (isOnMap(path) && store.get(path) !== undefined) {
      store.select([path]);
      store.map.focus(path);
      store.showTab("properties");
      return;
    }
  }
  const [head, index] = fault.path;
  if (head === ROBOT) store.select([startOf([ROBOT])]);
  else if (head === ROBOTS && index !== undefined) store.select([startOf([ROBOTS, index, ROBOT])]);
  else store.showTab(fault.path.length ? "trial" : "yaml");
}

/** Creates the list of all faults. */
export function makeProblemsPanel(store) {
  const list = h("ul", { class: "problems" });
  const element = h("div", { class: "panel" }, list);

  function remedy(fault) {
    if (!fault.fix) return null;
    return button("check", fault.fix.label, () => applyFix(store, fault.fix), { text: fault.fix.label, class: "button fix" });
  }

  function show() {
    element.dispatchEvent(new CustomEvent("count", { detail: store.faults.length }));
    if (!store.faults.length) {
      refill(list, h("li", { class: "empty" }, "No problems. The scenario can be run."));
      return;
    }
    refill(
      list,
      store.faults.map((fault) =>
        h(
          "li",
          { class: fault.severity === "warning" ? "problem is-warning" : "problem" },
          h(
            "button",
            { type: "button", class: "problem-text", onclick: () => showFault(store, fault) },
            h("span", { class: "problem-place" }, fault.path.length ? nameOf(store.data, fault.path) : "text", fault.line ? h("span", { class: "row-note" }, ` line ${fault.line}`) : null),
            h("span", null, sentence(fault)),
          ),
          remedy(fault),
        ),
      ),
    );
  }
  store.listen("faults", show);
  show();
  return element;
}
