import { h, refill } from "./dom.js";

/** The maximum number of runs with their own columns. */
const MOST = 40;

const ENDS = {
  goal: "reached the goal",
  timeout: "time is over",
  stuck: "stuck",
  planner_failed: "planner failed",
  cancelled: "stopped",
  failed: "not possible",
  end: "ended",
  running: "running",
};

/** Returns the end of a run in words. */
export const endOf = (result) => ENDS[result.end_reason] ?? result.end_reason ?? "";

const SIGNS = { lower: ["↓", "lower is better"], higher: ["↑", "higher is better"], none: ["", ""] };

function resultText(result, name) {
  if (!(name in result.metrics)) return "";
  return result.texts?.[name] ?? String(result.metrics[name] ?? "-");
}

/**
 * Creates the table of metrics: a row for each, by family; a column for each
 * run, and before them mean and interval of each planner with several runs.
 * @param store
 * @param {function(number): void} choose Called with a run that is clicked.
 * @param {function(number, boolean): void} overlay Called to lay a run over the chosen one.
 */
export function makeRunTable(store, choose, overlay) {
  const table = h("table", { class: "run-table" });
  const element = h("div", { class: "run-table-box", tabindex: 0, role: "region", "aria-label": "Metrics of the runs" }, table);
  const folded = new Set();

  /** A box that lays a run over the chosen one. */
  function overBox(run, result, color) {
    const box = h("input", { type: "checkbox", checked: color !== undefined, onchange: () => overlay(run, box.checked) });
    const label = h("label", { class: "run-over", title: "Lay this run over the chosen one on the map" }, box, "over");
    label.style.setProperty("--run", color ?? "transparent");
    return result.paths ? label : null;
  }

  function heads(runs, planners, shown, overlaid) {
    const numbers = planners.map(({ planner, n }) =>
      h("th", { scope: "col", class: "mean" }, h("span", { class: "run-planner" }, planner), h("span", { class: "run-note" }, `mean of ${n}, 95 %`)),
    );
    const columns = runs.map(({ run, seed, planner, result }) =>
      h(
        "th",
        { scope: "col", class: run === shown ? "chosen" : "" },
        h(
          "button",
          { type: "button", class: "run-head", "aria-pressed": String(run === shown), title: "Show this run on the map", onclick: () => choose(run), disabled: !result.paths },
          h("span", { class: "run-planner" }, result.planner ?? planner ?? ""),
          h("span", { class: "run-note" }, `seed ${result.seed ?? seed ?? ""}${result.drawn === "nothing" ? ", all alike" : ""}`),
        ),
        h("span", { class: `run-end is-${result.end_reason}`, title: result.error ?? result.message ?? "" }, endOf(result)),
        h("span", { class: "run-links" }, links(run, result)),
        runs.length > 1 && run !== shown && overBox(run, result, overlaid.get(run)),
      ),
    );
    return h("thead", null, h("tr", null, h("th", { scope: "col", class: "metric" }, "Metric"), numbers, columns));
  }

  function links(run, result) {
    const files = [["Report", result.report_url], ["Replay", result.replay_url], ["CSV", result.csv_url]];
    if (!files.some(([, url]) => url)) return result.metrics && Object.keys(result.metrics).length ? h("span", { class: "run-note" }, "writing …") : "";
    return files.map(([text, url]) => {
      if (!url) return null;
      if (!store.openResult) return h("a", { href: url, target: "_blank", rel: "noopener" }, text);
      return h("button", { type: "button", class: "link", onclick: () => store.openResult(run, url.split("/").at(-1), text) }, text);
    });
  }

  /** Shows runs with their results, statistics, and the chosen run. */
  function show(runs, summary, shown, overlaid) {
    const done = runs.filter((it) => it.result);
    const named = done.slice(0, MOST);
    const all = [...new Set(done.flatMap((it) => Object.keys(it.result.metrics)))];
    const counts = new Map();
    for (const { result } of done) if (Object.keys(result.metrics).length) counts.set(result.planner, (counts.get(result.planner) ?? 0) + 1);
    const planners = [...counts].filter(([, n]) => n > 1).map(([planner, n]) => ({ planner, n }));
    const means = new Map(summary.map((row) => [`${row.planner} ${row.metric}`, row]));
    const known = new Map((store.catalog.metrics ?? []).map((it) => [it.name, it]));
    // Of several robots, "anna.path_length" is a metric "path_length".
    const baseOf = (name) => (known.has(name) ? name : name.slice(name.indexOf(".") + 1));
    const bases = Map.groupBy(all, baseOf);
    const families = new Map();
    for (const [base, names] of bases) {
      const family = known.get(base)?.family ?? "other";
      families.set(family, [...(families.get(family) ?? []), ...names]);
    }
    const width = 1 + planners.length + named.length;

    const body = [...families].map(([family, members]) => {
      const open = !folded.has(family);
      const toggle = () => {
        if (!folded.delete(family)) folded.add(family);
        show(runs, summary, shown, overlaid);
      };
      return h(
        "tbody",
        null,
        h("tr", { class: "family" }, h("th", { scope: "rowgroup", colspan: width }, h("button", { type: "button", class: "family-head", "aria-expanded": String(open), onclick: toggle }, h("span", null, family.replace(/_/g, " "))))),
        open && members.map((name) => row(name, baseOf(name))),
      );
    });

    function row(name, base) {
      const metric = known.get(base);
      const robot = metric ? name.slice(0, -base.length - 1) : "";
      const [sign, words] = SIGNS[metric?.direction] ?? SIGNS.none;
      const unit = metric?.unit && metric.unit !== "-" ? metric.unit : "";
      return h(
        "tr",
        { "data-metric": name },
        h("th", { scope: "row", class: "metric", title: metric?.definition ?? "" }, h("span", null, (metric ? base : name).replace(/_/g, " ")), robot && h("span", { class: "run-note" }, ` ${robot} `), h("span", { class: "run-note" }, ` ${unit} `, h("span", { title: words }, sign))),
        planners.map(({ planner }) => {
          const it = means.get(`${planner} ${name}`);
          const interval = it && it.low !== null ? `${it.low_text} – ${it.high_text}` : "";
          return h("td", { class: "mean" }, it?.mean_text ?? "-", h("span", { class: "run-note" }, interval));
        }),
        named.map(({ run, result }) => h("td", { class: run === shown ? "chosen" : "" }, resultText(result, name))),
      );
    }

    const rest = done.length - named.length;
    const top = element.scrollTop;
    refill(table, heads(named, planners, shown, overlaid), body, rest > 0 && h("caption", null, `${rest} more runs are in the means; their files are in the folder of results.`));
    element.scrollTop = top;
    element.hidden = !done.length;
  }

  return { element, show };
}

/** Returns the metrics of runs as CSV: a row for each run. */
export function csvOf(runs) {
  const done = runs.filter((it) => it.result);
  const names = [...new Set(done.flatMap((it) => Object.keys(it.result.metrics)))];
  const cell = (it) => {
    const text = it === null || it === undefined ? "" : String(it);
    return /[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
  };
  const rows = done.map(({ result: it }) => [it.planner, it.seed, it.end_reason, it.end_time, ...names.map((name) => it.metrics[name])]);
  return [["planner", "seed", "end_reason", "end_time", ...names], ...rows].map((row) => row.map(cell).join(",")).join("\n") + "\n";
}
