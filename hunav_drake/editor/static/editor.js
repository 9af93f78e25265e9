import { h, fill } from "./dom.js";
import { makeStore } from "./store.js";
import { makeTabs } from "./tabs.js";
import { makeMap } from "./map.js";
import { makeTools } from "./tools.js";
import { addGestures } from "./gestures.js";
import { addKeys } from "./keys.js";
import { makeTopBar } from "./topbar.js";
import { makeOutline } from "./outline.js";
import { makeFormPanel, makeTrialPanel } from "./form.js";
import { makeProblemsPanel, told } from "./problems.js";
import { makeBehaviorPanel } from "./behavior.js";
import { makeMetricsPanel } from "./metrics.js";
import { makeRunsPanel } from "./runs.js";
import { makeTextPanel } from "./text.js";
import { addDialogs } from "./dialogs.js";

/** The width in pixels below which the left side becomes a tab. */
const NARROW = 1100;

/** The width in pixels below which the settings are below the map. */
const SLIM = 640;

/** The tabs on the right: title, key, panel. */
function rightPanels(store) {
  return [
    ["Properties", "properties", makeFormPanel(store)],
    ["Behavior", "behavior", makeBehaviorPanel(store)],
    ["Metrics", "metrics", makeMetricsPanel(store)],
    ["Trial", "trial", makeTrialPanel(store)],
  ];
}

/** The tabs below the map. */
function bottomPanels(store) {
  return [
    ["Problems", "problems", makeProblemsPanel(store)],
    ["YAML", "yaml", makeTextPanel(store)],
    ["Runs", "runs", makeRunsPanel(store)],
  ];
}

/**
 * Builds the editor in an element, and requests the scenario.
 * @param {HTMLElement} root
 * @param {{send: function(Object): void, on: function(function(Object): void): void}} host
 * @param {{leftFolded?: boolean, embedded?: boolean, openResult?: function(number, string, string): void}} options
 *   `embedded` in a page of others; `openResult` shows a file of a run where links lead nowhere.
 * @returns the store
 */
export function startEditor(root, host, options = {}) {
  const store = makeStore(host);
  store.root = root;
  store.openResult = options.openResult ?? null;
  store.embedded = options.embedded ?? false;
  root.classList.add("hunav-editor");

  const map = makeMap(store);
  store.map = map;
  store.ghosts = map.ghosts;
  store.dim = map.dim;
  const tools = makeTools(store, map);
  store.tools = tools;
  const gestures = addGestures(store, map, tools);
  addKeys(store, map, tools, gestures, root);

  const outline = makeOutline(store);
  const right = makeTabs(rightPanels(store), { label: "Settings" });
  const bottom = makeTabs(bottomPanels(store), { label: "Details", folds: true });
  store.showTab = (key) => right.show(key) || bottom.show(key);

  const left = h("aside", { class: "left", "aria-label": "Outline" }, outline);
  const live = h("div", { class: "unseen", "aria-live": "polite", role: "status" });
  const toast = h("div", { class: "toast", hidden: true });
  fill(
    root,
    makeTopBar(store, tools, map),
    h(
      "div",
      { class: "body" },
      left,
      h(store.embedded ? "section" : "main", { class: "middle", "aria-label": "Map and details" }, map.element, bottom.element),
      h("aside", { class: "right", "aria-label": "Settings" }, right.element),
    ),
    live,
    toast,
  );
  addDialogs(store, root);
  layOut(root, left, outline, right, options);
  tellAloud(store, live, toast);
  right.show("properties");
  return store;
}

/** Puts the outline on the left, or into a tab if there is no room. */
function layOut(root, left, outline, right, { leftFolded = false }) {
  let narrow = null;
  root.classList.toggle("left-folded", leftFolded);
  new ResizeObserver(() => {
    root.classList.toggle("slim", root.clientWidth < SLIM);
    const now = root.clientWidth < NARROW;
    if (now === narrow) return;
    narrow = now;
    root.classList.toggle("narrow", narrow);
    if (narrow) {
      right.add("Outline", "outline", outline, 0);
    } else {
      right.take("outline");
      left.append(outline);
    }
  }).observe(root);
}

/** Shows short messages; screen readers also read the number of faults. */
function tellAloud(store, live, toast) {
  let timer = 0;
  let number = 0;
  store.listen("say", ({ message, error = true }) => {
    live.textContent = message;
    toast.textContent = message;
    toast.hidden = false;
    toast.classList.toggle("is-error", error);
    clearTimeout(timer);
    timer = setTimeout(() => (toast.hidden = true), 6000);
  });
  store.listen("faults", () => {
    if (store.faults.length === number) return;
    number = store.faults.length;
    live.textContent = number ? `${number} ${number === 1 ? "problem" : "problems"}: ${told(store, store.faults[0])}` : "No problems";
  });
  store.listen("result", (it) => {
    live.textContent = it.error ?? `Run ${it.planner}, seed ${it.seed}: ${it.end_reason}`;
  });
}
