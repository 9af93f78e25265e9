import { button, fill, h, icon } from "./dom.js";

/** Creates a button that opens a menu of [text, function]. */
function menu(name, title, entries) {
  const list = h("div", { class: "menu", role: "menu", hidden: true });
  const opener = button(name, title, () => toggle(list.hidden), { "aria-haspopup": "menu", "aria-expanded": "false" });
  const element = h("div", { class: "menu-box" }, opener, list);
  function toggle(open) {
    list.hidden = !open;
    opener.setAttribute("aria-expanded", String(open));
    if (!open) return;
    fill(
      list,
      entries().map(([text, act, keys = ""]) =>
        text === "-"
          ? h("hr", null)
          : h("button", { type: "button", role: "menuitem", onclick: () => (toggle(false), act()) }, text, h("kbd", null, keys)),
      ),
    );
    list.querySelector("button")?.focus();
  }
  element.addEventListener("keydown", (event) => {
    const items = [...list.querySelectorAll("button")];
    const at = items.indexOf(document.activeElement);
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step && at >= 0) items[(at + step + items.length) % items.length].focus();
    else if (event.key === "Escape" && !list.hidden) (toggle(false), opener.focus());
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  element.addEventListener("focusout", (event) => {
    if (!element.contains(event.relatedTarget)) toggle(false);
  });
  return element;
}

/** Creates the top bar: file, tools, steps, faults, Save and Run. */
export function makeTopBar(store, tools) {
  const ask = (what) => store.tell("dialog", { what });
  const files = menu("menu", "File", () => [
    ["New from a template …", () => ask("start")],
    ["Open …", () => ask("open")],
    ["Save", () => store.tell("save"), "Ctrl+S"],
    ["Save as …", () => ask("save")],
    ["-"],
    ["Import agents.yaml …", () => ask("agents")],
    ["Import metrics.yaml …", () => ask("metrics")],
    ["Background map or picture …", () => ask("background")],
    ["-"],
    ["Keys and gestures", () => store.tell("help"), "?"],
  ]);
  const name = h(store.embedded ? "span" : "h1", { class: "file-name" });
  const dot = h("span", { class: "unsaved", role: "img", "aria-label": "Not saved", title: "Not saved", hidden: true });

  const toolButtons = new Map(
    tools.list.filter((tool) => tool.icon).map((tool) => {
      const keys = tool.key === tool.key.toUpperCase() ? `Shift+${tool.key}` : tool.key.toUpperCase();
      return [tool.name, button(tool.icon, `${tool.title} (${keys})`, () => tools.choose(tool.name), { "data-tool": tool.name })];
    }),
  );
  const snap = button("snap", "Snap to the grid of 0.1 m and to corners (S)", () => store.tell("snap"), { "aria-pressed": "true" });
  const breaks = { goal: true, "robot-goal": true, furniture: true };
  const toolbar = h(
    "div",
    { class: "tool-bar", role: "toolbar", "aria-label": "Tools" },
    [...toolButtons].flatMap(([key, it], i) => (i === 0 || breaks[key] ? [it, h("span", { class: "bar-gap" })] : [it])),
    snap,
  );

  const step = (kind, title) => {
    const text = h("span", { class: "step-name" });
    const element = h("button", { type: "button", class: `button step ${kind}`, onclick: () => store[`${kind}Step`]() }, icon(kind), text);
    return {
      element,
      show(label) {
        element.disabled = !label;
        text.textContent = label ?? "";
        element.title = label ? `${title}: ${label}` : `Nothing to ${kind}`;
        element.setAttribute("aria-label", element.title);
      },
    };
  };
  const undo = step("undo", "Undo (Ctrl+Z)");
  const redo = step("redo", "Redo (Ctrl+Shift+Z)");

  const faults = h("button", { type: "button", class: "button faults", onclick: () => store.showTab("problems") });
  const save = button("save", "Save (Ctrl+S)", () => store.tell("save"), { text: "Save" });
  const run = button("run", "Run (Ctrl+Enter)", () => store.tell("run"), { text: "Run", class: "button primary" });
  const offline = h("span", { class: "offline", role: "status", hidden: true }, "Connection lost, trying again …");

  store.listen("connection", ({ open }) => (offline.hidden = open));
  store.listen("tool", () => {
    for (const [key, it] of toolButtons) it.setAttribute("aria-pressed", String(key === tools.current.name));
  });
  store.listen("snap", () => {
    store.snap = !store.snap;
    snap.setAttribute("aria-pressed", String(store.snap));
  });
  store.listen("state", () => {
    const { filename } = store;
    name.textContent = filename ? filename.split(/[\\/]/).at(-1) : store.name || "new scenario";
    name.title = filename ?? "Has no file yet";
    dot.hidden = !store.dirty;
    undo.show(store.undo);
    redo.show(store.redo);
  });
  const showFaults = () => {
    const { length } = store.faults;
    faults.classList.toggle("has-faults", length > 0);
    fill(faults, icon(length ? "warning" : "check"), h("span", null, length ? `${length} ${length === 1 ? "problem" : "problems"}` : "No problems"));
  };
  store.listen("faults", showFaults);
  const showWorker = () => {
    const { status, message } = store.worker;
    const ready = status === "ready";
    run.classList.toggle("waits", !ready);
    run.title = ready ? "Run (Ctrl+Enter)" : `Run (Ctrl+Enter) waits. ${message || "Loading the simulation."}`;
  };
  store.listen("worker", showWorker);
  undo.show(null);
  redo.show(null);
  showFaults();
  tools.choose("select");
  for (const [key, it] of toolButtons) it.setAttribute("aria-pressed", String(key === "select"));

  return h(
    "header",
    { class: "top" },
    h("div", { class: "top-part" }, files, h("div", { class: "file" }, name, dot), offline),
    toolbar,
    h("div", { class: "top-part end" }, undo.element, redo.element, faults, save, run),
  );
}
