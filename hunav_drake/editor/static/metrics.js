import { button, fill, h } from "./dom.js";
import { setOp, resetOp } from "./changes.js";

const PATH = ["evaluator", "metrics"];

const SIGNS = { lower: ["↓", "lower is better"], higher: ["↑", "higher is better"], none: ["", "neither is better"] };

/** Returns the families of metrics, with their members. */
function familiesOf(metrics) {
  const families = new Map();
  for (const it of metrics) families.set(it.family, [...(families.get(it.family) ?? []), it]);
  return families;
}

/** Returns the paragraphs of a text; indented lines stay lines. */
function paragraphs(text) {
  return text.split(/\n\s*\n/).map((part) => (/^\s/m.test(part) ? part : part.replace(/\n/g, " ")));
}

/** Returns the metrics of a list of names, families, "paper" and "all". */
function chosenBy(list, metrics) {
  const chosen = new Set();
  for (const word of list) {
    for (const it of metrics) {
      if (word === "all" || it.name === word || it.family === word || (word === "paper" && it.paper) || it.aliases.includes(word)) chosen.add(it.name);
    }
  }
  return chosen;
}

/** Returns the shortest list for metrics. */
function shortest(chosen, metrics) {
  if (metrics.every((it) => chosen.has(it.name))) return ["all"];
  const cover = (list, left) => {
    const words = [...list];
    for (const [family, members] of familiesOf(metrics)) {
      const missing = members.filter((it) => left.has(it.name));
      if (!missing.length) continue;
      if (missing.length > 1 && members.every((it) => chosen.has(it.name))) words.push(family);
      else words.push(...missing.map((it) => it.name));
    }
    return words;
  };
  const lists = [cover([], chosen)];
  const paper = metrics.filter((it) => it.paper);
  if (paper.length && paper.every((it) => chosen.has(it.name))) {
    lists.push(cover(["paper"], new Set([...chosen].filter((name) => !paper.some((it) => it.name === name)))));
  }
  return lists.reduce((a, b) => (b.length < a.length ? b : a));
}

/** Creates the panel to choose the metrics of the trial. */
export function makeMetricsPanel(store) {
  const search = h("input", { type: "search", placeholder: "Search metrics", "aria-label": "Search metrics", oninput: () => show() });
  const whole = h("div", { class: "metric-sets" });
  const body = h("div", { class: "metric-families" });
  const count = h("span", { class: "row-note" });
  const element = h("div", { class: "panel metrics" }, h("div", { class: "panel-head" }, h("h2", { class: "panel-title" }, "Metrics"), count), h("div", { class: "form-body" }, whole, search, body));
  const open = new Set();
  const unfolded = new Set();

  const list = () => store.get(PATH) ?? store.catalog.defaults?.evaluator?.metrics ?? ["all"];
  const metrics = () => store.catalog.metrics ?? [];

  function choose(names, on, what) {
    const chosen = chosenBy(list(), metrics());
    for (const name of names) {
      if (on) chosen.add(name);
      else chosen.delete(name);
    }
    write(shortest(chosen, metrics()), `${on ? "Choose" : "Leave out"} ${what}`);
  }

  function write(words, label) {
    // Unknown ones are not changed, and have a fault.
    const unknown = list().filter((word) => !chosenBy([word], metrics()).size);
    store.edit(label, [setOp(store.data, PATH, [...words, ...unknown])]);
  }

  function box(names, chosen, label, what) {
    const all = names.every((name) => chosen.has(name));
    const some = names.some((name) => chosen.has(name));
    return h("input", { type: "checkbox", checked: all, indeterminate: some && !all, "aria-label": label, "data-choice": label, onchange: () => choose(names, !all, what) });
  }

  function details(it) {
    return h(
      "div",
      { class: "metric-details" },
      paragraphs(it.definition).map((text) => h("p", { class: "definition" }, text)),
      h("p", { class: "help shown" }, [`Source: ${it.source}.`, it.aliases.length ? `Also called ${it.aliases.join(", ")}.` : "", `${SIGNS[it.direction][1]}.`].filter(Boolean).join(" ")),
    );
  }

  function row(it, chosen) {
    const [sign, meaning] = SIGNS[it.direction] ?? SIGNS.none;
    const toggle = () => {
      if (!unfolded.delete(it.name)) unfolded.add(it.name);
      show();
    };
    return [
      h(
        "div",
        { class: "metric-row" },
        box([it.name], chosen, it.name, it.name.replace(/_/g, " ")),
        h("button", { type: "button", class: "metric-name", "aria-expanded": String(unfolded.has(it.name)), "data-metric": it.name, onclick: toggle }, it.name.replace(/_/g, " ")),
        h("span", { class: "row-note" }, it.unit === "-" ? "" : it.unit),
        h("span", { class: "metric-sign", title: meaning }, sign),
      ),
      unfolded.has(it.name) && details(it),
    ];
  }

  function show() {
    const all = metrics();
    const place = document.activeElement?.dataset ?? {};
    const chosen = chosenBy(list(), all);
    const sought = search.value.trim().toLowerCase().replace(/\s+/g, "_");
    count.textContent = all.length ? `${chosen.size} of ${all.length}` : "";
    search.hidden = !all.length;
    if (!all.length) {
      fill(body, h("p", { class: "empty" }, "The metrics appear when the simulation is loaded."));
      return;
    }
    const names = (some) => some.map((it) => it.name);
    const paper = all.filter((it) => it.paper);
    fill(
      whole,
      h("label", { class: "check" }, box(names(all), chosen, "all", "all metrics"), "all"),
      paper.length > 0 && h("label", { class: "check", title: "The 28 metrics of Table I of HuNavSim's paper" }, box(names(paper), chosen, "paper", "the paper's metrics"), "paper"),
      store.get(PATH) !== undefined && button("reset", "Reset to the default", () => store.edit("Reset the metrics", [resetOp(store.data, PATH)])),
    );
    const faults = store.faultsAt(PATH).map((it) => h("p", { class: "field-fault" }, it.message));
    const families = [...familiesOf(all)].map(([family, members]) => {
      const found = members.filter((it) => !sought || [it.name, family, ...it.aliases].some((word) => word.toLowerCase().includes(sought)));
      if (!found.length) return null;
      const isOpen = Boolean(sought) || open.has(family);
      const toggle = () => {
        if (!open.delete(family)) open.add(family);
        show();
      };
      const title = family.replace(/_/g, " ");
      const number = members.filter((it) => chosen.has(it.name)).length;
      return h(
        "section",
        { class: "metric-family" },
        h("div", { class: "metric-row of-family" }, box(names(members), chosen, family, title), h("button", { type: "button", class: "family-head", "aria-expanded": String(isOpen), "data-family": family, onclick: toggle }, h("span", null, title)), h("span", { class: "row-note" }, `${number} of ${members.length}`)),
        isOpen && found.map((it) => row(it, chosen)),
      );
    });
    fill(body, faults, families, sought && !families.some(Boolean) && h("p", { class: "empty" }, "There is no such metric."));
    for (const [key, value] of Object.entries(place)) {
      if (!["choice", "metric", "family"].includes(key)) continue;
      [...element.querySelectorAll(`[data-${key}]`)].find((it) => it.dataset[key] === value)?.focus();
    }
  }

  let last = null;
  store.listen("data", () => {
    if (last === store.get(PATH)) return;
    last = store.get(PATH);
    show();
  });
  store.listen("catalog", show);
  store.listen("faults", show);
  show();
  return element;
}
