import { button, fill, h } from "./dom.js";
import { sameValue } from "./data.js";
import { isGoal, isPerson, nameOf, peopleOf } from "./things.js";
import { inkOn } from "./shapes.js";
import { words } from "./fields.js";
import { makePorts } from "./ports.js";

/** Returns the tree of a person's behavior: a name, a path or XML. */
function treeOf(person, defaults) {
  const it = person?.behavior ?? defaults?.behavior ?? "regular";
  return typeof it === "string" ? it : String(it.type ?? "");
}

/** Creates the panel of people's behaviors. */
export function makeBehaviorPanel(store) {
  const search = h("input", { type: "search", placeholder: "Search behaviors", "aria-label": "Search behaviors", oninput: () => show() });
  const title = h("h2", { class: "panel-title" });
  const list = h("div", { class: "behaviors", role: "radiogroup", "aria-label": "Behavior" });
  const own = h("input", { type: "text", placeholder: "mine.xml", "aria-label": "Your file, in the folder of the scenario", spellcheck: "false" });
  const ownRow = h("div", { class: "own-tree" }, h("span", { class: "label" }, "Own file"), own, button("check", "Use this file", () => useOwn(), { text: "Use" }));
  const details = h("div", { class: "behavior-details" });
  const matrix = h("div", { class: "matrix-box" });
  const element = h("div", { class: "panel behavior" }, h("div", { class: "panel-head" }, title), h("div", { class: "form-body" }, search, list, ownRow, details, matrix));
  const ports = makePorts(store);
  let detailed = null;

  const defaults = () => store.catalog.defaults?.human ?? {};
  const entries = () => store.catalog.behaviors ?? [];

  function selected() {
    const paths = store.selection.map((it) => (isGoal(it) ? it.slice(0, 2) : it)).filter(isPerson);
    const unique = new Map(paths.map((it) => [it.join("/"), it]));
    return [...unique.values()].filter((it) => store.get(it));
  }

  /** Sets the behavior of people, without the ports of the old one. */
  function choose(paths, tree) {
    const changed = paths.filter((path) => treeOf(store.get(path), defaults()) !== tree);
    const who = changed.length === 1 ? nameOf(store.data, changed[0]) : `${changed.length} people`;
    store.edit(`Let ${who} be ${tree.split("/").at(-1)}`, changed.map((path) => ["set", [...path, "behavior"], tree]));
  }

  function useOwn() {
    const name = own.value.trim();
    if (!/\.xml$/i.test(name)) {
      store.say("Your file must be a .xml in the folder of the scenario.");
      return;
    }
    choose(selected(), /[\\/]/.test(name) ? name : `./${name}`);
  }

  function disc({ color, letter }) {
    return h("span", { class: "mark who", style: { "--who": color, "--ink": inkOn(color) } }, letter);
  }

  function option(entry, trees, paths) {
    const on = trees.size === 1 && trees.has(entry.name);
    return h(
      "button",
      {
        type: "button",
        role: "radio",
        class: "behavior-option",
        "aria-checked": String(on),
        "data-behavior": entry.name,
        title: entry.help,
        tabindex: on || (trees.size !== 1 && entry === entries()[0]) || !entries().some((it) => trees.has(it.name)) ? 0 : -1,
        onclick: () => choose(paths, entry.name),
      },
      disc(entry),
      h("span", { class: "behavior-words" }, h("span", { class: "behavior-name" }, entry.name), h("span", { class: "help shown" }, entry.help)),
    );
  }

  list.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 }[event.key];
    const all = [...list.querySelectorAll("button")];
    const at = all.indexOf(document.activeElement);
    if (!step || at < 0) return;
    event.preventDefault();
    const next = all[(at + step + all.length) % all.length];
    next.click();
    list.querySelector(`[data-behavior="${next.dataset.behavior}"]`)?.focus();
  });

  function show() {
    const paths = selected();
    const people = paths.map((path) => store.get(path));
    const trees = new Set(people.map((it) => treeOf(it, defaults())));
    const sought = search.value.trim().toLowerCase();
    const found = entries().filter((it) => !sought || `${it.name} ${it.help}`.toLowerCase().includes(sought));
    const some = paths.length > 0;
    title.textContent = !some ? "Behaviors" : paths.length === 1 ? `Behavior of ${nameOf(store.data, paths[0])}` : `Behavior of ${paths.length} people`;
    for (const it of [search, list, ownRow, details]) it.hidden = !some;
    matrix.hidden = some;
    if (!entries().length) {
      fill(list, h("p", { class: "empty" }, "The behaviors appear when the simulation is loaded."));
      list.hidden = false;
    }
    if (!some) {
      detailed = null;
      fill(details);
      showMatrix();
      return;
    }
    if (entries().length) {
      const focused = list.contains(document.activeElement) ? document.activeElement.dataset.behavior : null;
      fill(list, found.map((it) => option(it, trees, paths)), !found.length && h("p", { class: "empty" }, "There is no such behavior."));
      if (focused) list.querySelector(`[data-behavior="${focused}"]`)?.focus();
    }
    const [tree] = trees;
    const isOwn = trees.size === 1 && !entries().some((it) => it.name === tree);
    if (document.activeElement !== own) own.value = isOwn ? tree : "";
    showDetails(trees.size === 1 ? entries().find((it) => it.name === tree) : null, paths, trees);
  }

  function showDetails(entry, paths, trees) {
    if (!entry) {
      detailed = null;
      const text = trees.size > 1 ? `They have ${trees.size} different behaviors; choose one for all.` : "";
      const faults = paths.flatMap((path) => store.faultsAt([...path, "behavior"]));
      fill(details, text && h("p", { class: "help shown" }, text), faults.map((it) => h("p", { class: "field-fault" }, it.message, it.remedy ? ` ${it.remedy}` : "")));
      return;
    }
    const key = `${entry.name} ${paths.map((it) => it.join("/")).join()}`;
    if (detailed !== key || !details.childElementCount) {
      detailed = key;
      fill(details, picture(entry), ports.build(entry, paths));
    }
    ports.refresh();
  }

  function picture(entry) {
    if (!entry.picture) {
      return h("details", { class: "tree" }, h("summary", null, "Its tree"), h("pre", { class: "tree-text" }, entry.drawing ?? ""));
    }
    const source = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(entry.picture)}`;
    const large = () => {
      const close = button("close", "Close", () => dialog.close());
      const dialog = h("dialog", { class: "dialog tree-dialog" }, h("div", { class: "dialog-head" }, h("h2", null, `The tree of ${entry.name}`), close), h("div", { class: "tree-scroll" }, h("img", { src: source, alt: `The behavior tree of ${entry.name}` })));
      dialog.addEventListener("close", () => dialog.remove());
      store.root.append(dialog);
      dialog.showModal();
    };
    return h("button", { type: "button", class: "tree-picture", title: "Show the tree large", onclick: large }, h("img", { src: source, alt: `The behavior tree of ${entry.name}` }));
  }

  /** The table of all people and behaviors, if nobody is selected. */
  function showMatrix() {
    const people = peopleOf(store.data);
    if (!people.length || !entries().length) {
      fill(matrix, h("p", { class: "help shown" }, people.length ? "" : "There are no people yet. Add one with P."));
      return;
    }
    const head = entries().map((it) => h("th", { scope: "col", title: `${it.name}: ${it.help}` }, disc(it), h("span", { class: "unseen" }, it.name)));
    const rows = people.map((person, i) => {
      const path = ["humans", i];
      const tree = treeOf(person, defaults());
      const name = nameOf(store.data, path);
      return h(
        "tr",
        null,
        h("th", { scope: "row" }, h("button", { type: "button", class: "link", onclick: () => store.select([path]) }, name)),
        entries().map((it) => h("td", null, h("input", { type: "radio", name: `hunav-behavior-${i}`, checked: tree === it.name, "aria-label": `${name}: ${it.name}`, onchange: () => choose([path], it.name) }))),
      );
    });
    const all = h(
      "tr",
      { class: "all" },
      h("th", { scope: "row" }, "all"),
      entries().map((it) => h("td", null, h("button", { type: "button", class: "link", title: `Let all people be ${it.name}`, "aria-label": `All: ${it.name}`, onclick: () => choose(people.map((_, i) => ["humans", i]), it.name) }, "●"))),
    );
    const focused = matrix.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label") : null;
    fill(
      matrix,
      h("p", { class: "help shown" }, "Select people to see the tree and the ports of their behavior."),
      h("table", { class: "matrix" }, h("thead", null, h("tr", null, h("td", null), head)), h("tbody", null, all, rows)),
      h("dl", { class: "legend" }, entries().map((it) => h("div", null, h("dt", null, disc(it), words(it.name)), h("dd", { class: "help shown" }, it.help)))),
    );
    if (focused) [...matrix.querySelectorAll("[aria-label]")].find((it) => it.getAttribute("aria-label") === focused)?.focus();
  }

  let last = null;
  function changed() {
    // Moving people does not change this panel.
    const facts = [store.selection, store.catalog, peopleOf(store.data).map((it) => [it.behavior, it.name])];
    if (last && sameValue(facts, last)) return;
    last = facts;
    show();
  }
  store.listen("selection", changed);
  store.listen("catalog", show);
  store.listen("data", changed);
  store.listen("faults", () => (store.selection.length ? show() : null));
  show();
  return element;
}

