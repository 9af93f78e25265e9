import { atFrame, button, doNow, fill, h, refill } from "./dom.js";
import { makeGhosts } from "./ghosts.js";
import { makePlayer } from "./player.js";
import { told } from "./problems.js";
import { csvOf, endOf, makeRunTable } from "./runtable.js";

/** The maximum number of runs; for more, use `hunav bench`. */
const MOST_RUNS = 1000;

/** The colors of runs that are laid over another one (Okabe and Ito). */
const OVER = ["#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

const SPEEDS = [
  ["", "as fast as possible"],
  ["1", "real time"],
  ["2", "2 × real time"],
  ["5", "5 × real time"],
  ["10", "10 × real time"],
];

/**
 * Returns the seeds of a text such as "0-4" or "1, 5, 9"; null if it
 * is invalid.
 */
function readSeeds(text) {
  const seeds = new Set();
  for (const part of text.split(",").map((it) => it.trim()).filter(Boolean)) {
    const found = /^(\d{1,15})(?:\s*[-–]\s*(\d{1,15}))?$/.exec(part);
    if (!found) return null;
    const [low, high] = [Number(found[1]), Number(found[2] ?? found[1])];
    if (high < low || high - low >= MOST_RUNS) return null;
    for (let seed = low; seed <= high; seed++) seeds.add(seed);
  }
  return [...seeds];
}

/** Creates the panel of runs: settings, progress and results. */
export function makeRunsPanel(store) {
  /** @type {Map<number, any>} */
  const runs = new Map();
  const ghosts = makeGhosts(store);
  /** Runs that are laid over the chosen one: their number, and their drawing. */
  const overlaid = new Map();
  const player = makePlayer((time) => [ghosts, ...overlaid.values()].forEach((it) => it.at(time)));
  const chosenPlanners = new Set();
  let summary = [];
  let revision = null;
  let seen = null;
  let shown = null;
  let onMap = true;

  const seeds = h("input", { type: "text", value: "", placeholder: "the scenario's own", "aria-label": "Seeds", title: "0-4, or 1, 5, 9" });
  const speed = h("select", { "aria-label": "Speed" }, SPEEDS.map(([value, text]) => h("option", { value }, text)));
  const workers = h("select", { "aria-label": "Processes" }, [1, 2, 4].map((n) => h("option", { value: n }, n === 1 ? "1 process" : `${n} processes`)));
  const planners = h("div", { class: "chips", role: "group", "aria-label": "Planners" });
  const start = button("run", "Run (Ctrl+Enter)", () => run(), { text: "Run", class: "button primary" });
  const stop = button("stop", "Stop the runs (Ctrl+.)", () => store.send({ do: "cancel" }), { text: "Stop", hidden: true });
  const state = h("p", { class: "run-state", role: "status" });
  const progress = h("div", { class: "run-progress", hidden: true });
  const outdated = h("p", { class: "outdated", hidden: true }, "The scenario was changed after these runs. Run it again.");
  const command = h("code", { class: "run-command" });
  const copy = button("copy", "Copy the command for a terminal", () => navigator.clipboard?.writeText(command.textContent).then(() => store.say("The command is on the clipboard.", false)));
  const map = h("label", { class: "check" }, h("input", { type: "checkbox", checked: true, onchange: (event) => showOnMap(event.target.checked) }), "on the map");
  const csv = button("save", "Download the table as a CSV file", () => download(), { text: "CSV", class: "button" });
  const table = makeRunTable(store, choose, overlay);
  const empty = h("p", { class: "empty run-empty" });
  const bar = h("div", { class: "run-bar", hidden: true }, player.element, player.note, map);
  const reason = h("p", { class: "run-reason", hidden: true });
  const line = h("div", { class: "run-line", hidden: true }, h("span", { class: "run-note" }, "In a terminal:"), command, copy, csv);
  const field = (text, control, note = "") => h("label", { class: "run-field" }, h("span", { class: "label" }, text), control, note && h("span", { class: "help shown" }, note));
  const element = h(
    "div",
    { class: "panel runs" },
    h(
      "div",
      { class: "run-side" },
      field("Seeds", seeds),
      h("div", { class: "run-field" }, h("span", { class: "label" }, "Planners"), planners),
      field("Speed", speed),
      field("At a time", workers),
      h("div", { class: "row" }, start, stop),
      state,
      progress,
    ),
    h("div", { class: "run-main" }, outdated, bar, reason, empty, table.element, line),
  );

  const isBusy = () => [...runs.values()].some((it) => !it.result);
  const refresh = atFrame(() => {
    const all = [...runs.values()];
    const done = all.filter((it) => it.result);
    const chosen = runs.get(shown)?.result;
    table.show(all, summary, shown, new Map([...overlaid.keys()].map((it) => [it, colorOf(it)])));
    empty.hidden = done.length > 0;
    empty.textContent = isBusy() ? "The metrics of the trial appear here when it has ended." : "Press Run. The robots and the people then move on the map, and the metrics of the trial appear here.";
    bar.hidden = !chosen?.paths;
    const early = (chosen?.ends ?? []).map((it) => `${it.robot ? `${it.robot}: ` : ""}${endOf({ end_reason: it.reason })} at (${it.at.map((x) => x.toFixed(2)).join(", ")})${it.message ? `: ${it.message}` : ""}`);
    reason.hidden = !early.length;
    reason.textContent = early.join("; ");
    line.hidden = !chosen;
    command.textContent = chosen?.command ?? "";
    outdated.hidden = !done.length || revision === store.revision;
    element.classList.toggle("is-outdated", !outdated.hidden);
    start.hidden = isBusy();
    stop.hidden = !isBusy();
    showState(all, done);
    element.dispatchEvent(new CustomEvent("count", { detail: 0 }));
  });

  function showState(all, done) {
    const { status, message } = store.worker;
    const going = all.filter((it) => !it.result);
    state.classList.toggle("is-dead", status === "dead");
    if (status === "dead") state.textContent = message;
    else if (status !== "ready" && !(all.some((it) => it.result || it.progress !== undefined))) state.textContent = `${message || "Loading the simulation."}${going.length ? " The run begins when it is ready." : ""}`;
    else if (going.length) state.textContent = all.length > 1 ? `${done.length} of ${all.length} runs are done` : "";
    else state.textContent = done.length === 1 ? [endOf(done[0].result), done[0].result.error ?? ""].filter(Boolean).join(": ") : done.length ? `${done.length} runs are done` : "";
    const moving = going.filter((it) => it.progress !== undefined).slice(0, 4);
    progress.hidden = !moving.length;
    fill(
      progress,
      moving.map((it) => h("div", { class: "run-going" }, h("span", null, [it.planner, it.seed === null ? "" : `seed ${it.seed}`].filter(Boolean).join(", ") || "run"), h("progress", { max: 1, value: it.progress, "aria-label": "Progress" }), h("span", { class: "clock" }, `${it.time.toFixed(1)} s`))),
    );
  }

  function showPlanners() {
    // Several robots have planners of their own.
    const own = store.data.robots?.length ? null : store.get(["planner"]) ?? store.catalog.defaults?.planner;
    const name = typeof own === "string" ? own : (own?.type ?? "");
    const known = store.catalog.planners?.length ? store.catalog.planners : name ? [{ name, help: "" }] : [];
    refill(
      planners,
      known.map((it) => {
        const pressed = chosenPlanners.has(it.name);
        const flip = () => {
          if (!chosenPlanners.delete(it.name)) chosenPlanners.add(it.name);
          showPlanners();
        };
        return h("button", { type: "button", class: "chip", title: it.help, "aria-pressed": String(pressed), onclick: flip }, it.name === name ? `${it.name} (scenario)` : it.name);
      }),
    );
  }

  function run() {
    doNow();
    store.showTab("runs");
    const wanted = readSeeds(seeds.value);
    seeds.toggleAttribute("aria-invalid", false);
    if (wanted === null) {
      seeds.setAttribute("aria-invalid", "true");
      store.say("Seeds are whole numbers, as in 0-4 or 1, 5, 9.");
      return;
    }
    const errors = store.faults.filter((it) => it.severity !== "warning");
    if (errors.length) {
      store.showTab("problems");
      store.say(`The scenario cannot run. ${told(store, errors[0])}`);
      return;
    }
    const request = { do: "run", seeds: wanted, planners: [...chosenPlanners], speed: speed.value ? Number(speed.value) : null, workers: Number(workers.value) };
    store.ask(request);
  }

  /** Shows a finished run on the map. */
  function choose(number) {
    const { paths, events, ends } = runs.get(number)?.result ?? {};
    shown = number;
    overlay(number, false);
    if (paths) {
      const others = [...overlaid.keys()].map((it) => runs.get(it).result.paths.times);
      player.load([paths.times, ...others].sort((a, b) => a.at(-1) - b.at(-1)).at(-1), events);
      if (onMap) {
        ghosts.paths(number, paths, ends);
        for (const [other, it] of overlaid) it.paths(other, runs.get(other).result.paths, runs.get(other).result.ends);
        [ghosts, ...overlaid.values()].forEach((it) => it.at(player.time));
      }
    }
    refresh();
  }

  const colorOf = (number) => OVER[[...runs.keys()].indexOf(number) % OVER.length];

  /** Lays a run over the chosen one, or takes it away. */
  function overlay(number, on) {
    overlaid.get(number)?.clear();
    overlaid.delete(number);
    if (!on || number === shown) return refresh();
    overlaid.set(number, makeGhosts(store, colorOf(number)));
    if (!onMap) showOnMap(true);
    return choose(shown);
  }

  function clearGhosts() {
    for (const it of [ghosts, ...overlaid.values()]) it.clear();
  }

  function showOnMap(on) {
    onMap = on;
    map.firstElementChild.checked = on;
    if (!on) {
      player.pause();
      clearGhosts();
    } else if (shown !== null) {
      choose(shown);
    }
  }

  function download() {
    const address = URL.createObjectURL(new Blob([csvOf([...runs.values()])], { type: "text/csv" }));
    h("a", { href: address, download: `${store.name || "runs"}.csv` }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
  }

  store.listen("run", run);
  store.listen("runs", (message) => {
    // They are sent again when another page is opened.
    if (message.runs.some(({ run: number }) => runs.has(number))) return;
    runs.clear();
    summary = [];
    revision = message.revision;
    shown = null;
    player.pause();
    clearGhosts();
    overlaid.clear();
    for (const it of message.runs) runs.set(it.run, { ...it });
    // A new page gets earlier runs, but shows the scenario.
    showOnMap(element.offsetParent !== null);
    refresh();
    if (!onMap) return;
    // The panel may cover a part of the map.
    requestAnimationFrame(() => requestAnimationFrame(() => store.map.fit()));
  });
  store.listen("frame", (message) => {
    const it = runs.get(message.run);
    if (!it || it.result) return;
    it.progress = message.progress;
    it.time = message.time;
    const first = [...runs.values()].find((other) => !other.result && other.progress !== undefined);
    if (first === it && onMap) ghosts.frame(message);
    refresh();
  });
  store.listen("result", (message) => {
    const it = runs.get(message.run);
    if (!it) return;
    const isFirst = !it.result;
    it.result = message;
    if (isFirst && message.paths && shown === null) choose(message.run);
    if (isFirst && !isBusy()) {
      if (shown !== null && onMap) choose(shown);
      else if (shown === null) ghosts.clear();
    }
    refresh();
  });
  store.listen("summary", (message) => {
    summary = message.rows;
    refresh();
  });
  store.listen("state", () => {
    // An edit shows the scenario again, also during runs.
    const isEdit = seen !== store.revision && revision !== null && revision !== store.revision;
    seen = store.revision;
    if (isEdit && onMap) showOnMap(false);
    refresh();
    showPlanners();
  });
  store.listen("worker", refresh);
  store.listen("catalog", () => {
    showPlanners();
    refresh();
  });
  showPlanners();
  return element;
}
