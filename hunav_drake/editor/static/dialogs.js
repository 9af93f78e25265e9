import { button, doNow, fill, h } from "./dom.js";
import { arrayOps, copied, wordsFor } from "./changes.js";
import { numberInput, words } from "./fields.js";

/** The maximum number of copies at once. */
const MOST_COPIES = 200;

/** All keys and gestures, for the help. */
const HELP = [
  ["Select; add; several; all", "click; Shift+click; pull a box; Ctrl+A"],
  ["Next part; nothing", "Tab; Esc"],
  ["Move", "drag; arrows 0.05 m, Shift 0.5, Alt 0.01"],
  ["Turn", "drag the handle; [ and ] 15°, Shift 1°"],
  ["Along one axis; without snapping", "Shift; Alt while dragging"],
  ["Person, then its goals", "P: press, pull, click; Enter ends"],
  ["Goals; one 1 m ahead", "G; Shift+G"],
  ["Robot; its goal", "R; Shift+R"],
  ["Wall; polygon; box; disc; room; door", "W; O; B; C; Shift+O; D"],
  ["Furniture; measure", "F; M"],
  ["Corners of a wall", "drag; Enter, Tab, arrows, Del"],
  ["Copy", "Ctrl+drag; Ctrl+C, X, V, D"],
  ["Group; ungroup", "Ctrl+G; Ctrl+Shift+G"],
  ["Delete; undo; redo", "Del; Ctrl+Z; Ctrl+Shift+Z"],
  ["Zoom; move the view; all", "wheel, + −; Space+drag, Ctrl+arrows; 0"],
  ["Event of a run before; next", "Alt+Left; Alt+Right on its time"],
  ["Save; run; stop", "Ctrl+S; Ctrl+Enter; Ctrl+."],
];

function read(file, how) {
  return new Promise((done, failed) => {
    const reader = new FileReader();
    reader.onload = () => done(reader.result);
    reader.onerror = () => failed(reader.error);
    reader[how](file);
  });
}

const asText = (file) => read(file, "readAsText");
const asBase64 = async (file) => (await read(file, "readAsDataURL")).split(",")[1] ?? "";

/** Lets the user choose files. */
function pick(accept, multiple) {
  return new Promise((done) => {
    const input = h("input", { type: "file", accept, multiple });
    input.addEventListener("change", () => done([...input.files]));
    input.click();
  });
}

/** Adds the dialogs. */
export function addDialogs(store, root) {
  const dialog = h("dialog", { class: "dialog" });
  root.append(dialog);

  function show(title, ...content) {
    fill(dialog, h("div", { class: "dialog-head" }, h("h2", null, title), button("close", "Close", () => dialog.close())), ...content);
    if (!dialog.open) dialog.showModal();
  }
  const buttons = (...all) => h("div", { class: "dialog-buttons" }, ...all);
  const act = (text, f, primary = false) => button("", text, () => (dialog.close(), f()), { text, class: primary ? "button primary" : "button" });

  function question({ question: text, yes = "Yes", no = "No", again, never }) {
    show(text, buttons(act(no, () => never?.()), act(yes, () => store.ask(again), true)));
  }

  function saveAs() {
    const given = store.filename?.split(/[\\/]/).at(-1) ?? `${store.name || "scenario"}.yaml`;
    const input = h("input", { type: "text", value: given, "aria-label": "File name", autofocus: true });
    const save = () => store.ask({ do: "save", filename: /\.ya?ml$/.test(input.value) ? input.value : `${input.value}.yaml` });
    const form = h("form", { onsubmit: (event) => (event.preventDefault(), dialog.close(), save()) }, h("label", { class: "stacked" }, "File name, in the folder of the scenario", input), buttons(act("Cancel", () => {}), act("Save", save, true)));
    show("Save as", form);
    input.select();
  }

  function examples() {
    return h(
      "div",
      { class: "cards small" },
      store.catalog.examples.map((it) => {
        const name = typeof it === "string" ? it : it.name;
        return h("button", { type: "button", class: "card", title: it.description ?? "", onclick: () => begin({ do: "open", filename: name }) }, words(name));
      }),
    );
  }

  function begin(message) {
    dialog.close();
    store.map.fitNext = true;
    store.ask(message);
  }

  /** Creates a row for each number, which is stored in `values`. */
  function numberRows(values, nodes) {
    return Object.entries(nodes).map(([key, node]) => {
      const { input, refresh } = numberInput(node, {
        label: words(key),
        read: () => ({ value: values[key], mixed: false, fallback: node.fallback }),
        write: (value) => (values[key] = value),
        clear: () => delete values[key],
      });
      refresh(true);
      return h("label", { class: "stacked inline", title: node.help }, h("span", null, words(key)), h("span", { class: "with-unit" }, input, node.unit ? h("span", { class: "unit" }, node.unit) : null));
    });
  }

  /** Asks for the number and the distance of copies. */
  function array() {
    const { data, selection } = store;
    const parts = copied(data, selection);
    if (!parts.length) return store.say("There is only one robot.");
    const what = wordsFor(data, selection);
    const values = { columns: 3, rows: 1, across: 1.5, up: 1.5 };
    const [count, step] = [{ kind: "integer" }, { kind: "number", unit: "m" }];
    function create() {
      const { columns = 0, rows = 0, across = 0, up = 0 } = values;
      if (columns < 1 || rows < 1 || columns * rows > MOST_COPIES) store.say(`The number of copies must be 1 to ${MOST_COPIES}.`);
      else store.edit(`Repeat ${what}`, arrayOps(data, parts, { columns, rows, across, up }));
    }
    return show(`Repeat ${what}`, numberRows(values, { columns: count, rows: count, across: step, up: step }), buttons(act("Cancel", () => {}), act("Repeat", create, true)));
  }

  /** Asks for the distance of two places of the background. */
  function scale({ from, to }) {
    const measured = Math.hypot(to[0] - from[0], to[1] - from[1]);
    const values = {};
    function resize() {
      const factor = values.distance / measured;
      if (!(factor > 0)) return store.say("The distance of the two places must be positive, in meters.");
      const { width_m, origin } = store.background;
      // The first place does not move.
      const [x, y] = origin.map((it, i) => from[i] + factor * (it - from[i]));
      return store.send({ do: "background", files: {}, width_m: width_m * factor, origin: [x, y, origin[2] ?? 0] });
    }
    show("Scale of the picture", numberRows(values, { distance: { kind: "number", unit: "m" } }), buttons(act("Cancel", () => {}), act("Set scale", resize, true)));
  }

  function start() {
    const templates = store.catalog.templates.map((it) => h("button", { type: "button", class: "card", "data-template": it.name, onclick: () => begin({ do: "template", name: it.name }) }, h("strong", null, it.title), h("span", null, it.help)));
    show(
      "New scenario",
      h("div", { class: "cards" }, h("button", { type: "button", class: "card", onclick: () => dialog.close() }, h("strong", null, "Empty"), h("span", null, "An empty floor")), templates),
      h("h3", null, "Shipped scenarios"),
      examples(),
      h("h3", null, "From HuNavSim"),
      h("div", { class: "row" }, act("Import agents.yaml …", () => run("agents")), act("Map or picture …", () => run("background"))),
    );
  }

  function open() {
    const input = h("input", { type: "text", placeholder: "office.yaml", "aria-label": "File name", autofocus: true });
    const go = () => input.value && begin({ do: "open", filename: input.value });
    show("Open", h("form", { onsubmit: (event) => (event.preventDefault(), go()) }, h("label", { class: "stacked" }, "File, in the folder of the scenario", input), buttons(act("Cancel", () => {}), act("Open", go, true))), h("h3", null, "Shipped scenarios"), examples());
  }

  async function importFile(kind) {
    const [file] = await pick(".yaml,.yml");
    if (!file) return;
    const text = await asText(file);
    const send = (mode) => {
      store.map.fitNext = true;
      store.ask({ do: "import", kind, mode, name: file.name, text });
    };
    if (kind !== "agents" || !store.data.humans?.length) return send("replace");
    show(`Import ${file.name}`, h("p", null, "There are people already."), buttons(act("Add to them", () => send("add")), act("Replace them", () => send("replace"), true)));
  }

  async function background(files) {
    const named = await Promise.all(files.map(async (it) => [it.name, await asBase64(it)]));
    const main = files.find((it) => /\.ya?ml$/.test(it.name)) ?? files[0];
    store.send({ do: "background", name: main.name, files: Object.fromEntries(named) });
  }

  const run = (what, message) => {
    if (what === "start") start();
    else if (what === "array") array();
    else if (what === "scale") scale(message);
    else if (what === "open") open();
    else if (what === "save") saveAs();
    else if (what === "background") pick(".yaml,.yml,.pgm,.png,.jpg,.jpeg", true).then((files) => files.length && background(files));
    else importFile(what);
  };
  store.listen("dialog", (message) => run(message.what, message));
  store.listen("ask", question);
  store.listen("note", ({ message }) => store.tell("say", { message, error: false }));
  store.listen("notes", ({ title, notes }) => show(title, h("p", null, "Not imported:"), h("ul", { class: "notes" }, notes.map((it) => h("li", null, it))), buttons(act("Close", () => {}, true))));
  store.listen("save", () => {
    doNow();
    if (store.filename) store.ask({ do: "save" });
    else saveAs();
  });
  store.listen("saved", ({ filename }) => store.tell("say", { message: `Saved ${filename.split(/[\\/]/).at(-1)}`, error: false }));
  store.listen("help", () => show("Keys and gestures", h("table", { class: "keys" }, h("tbody", null, HELP.map(([what, how]) => h("tr", null, h("th", { scope: "row" }, what), h("td", null, how)))))));

  // An empty scenario without a file starts with the templates.
  let begun = false;
  store.listen("text", () => {
    if (begun) return;
    begun = true;
    if (!store.filename && !store.text.trim() && !store.embedded && !dialog.open) start();
  });

  const map = store.map.element;
  map.addEventListener("dragover", (event) => event.preventDefault());
  map.addEventListener("drop", (event) => {
    event.preventDefault();
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length) background(files);
  });
}
