import { fill, h, later } from "./dom.js";
import { isWithin, keyOf, samePath } from "./data.js";
import { isOnMap } from "./things.js";

/** Creates the YAML text, synchronized with the map. */
export function makeTextPanel(store) {
  const gutter = h("div", { class: "gutter", "aria-hidden": "true" });
  const marks = h("div", { class: "line-marks", "aria-hidden": "true" });
  const area = h("textarea", { class: "yaml", spellcheck: "false", autocomplete: "off", autocapitalize: "off", wrap: "off", "aria-label": "The scenario as YAML text" });
  const banner = h("div", { class: "banner", role: "alert", hidden: true });
  const scroller = h("div", { class: "text-box" }, gutter, marks, area);
  const element = h("div", { class: "panel text" }, banner, scroller);
  let lines = 0;
  let typed = false;
  let fromCaret = false;

  const send = later(300, () => {
    typed = false;
    if (area.value !== store.text) store.ask({ do: "text", text: area.value });
  });
  area.addEventListener("input", () => {
    typed = true;
    number();
    send();
  });
  area.addEventListener("keydown", (event) => {
    if (event.key !== "Tab" || event.shiftKey) return;
    // Two spaces, as in written files; Esc, then Tab leaves the field.
    if (area.dataset.leave) return;
    event.preventDefault();
    area.setRangeText("  ", area.selectionStart, area.selectionEnd, "end");
    area.dispatchEvent(new Event("input"));
  });
  area.addEventListener("keyup", (event) => {
    area.dataset.leave = event.key === "Escape" ? "1" : "";
  });

  function lineHeight() {
    return parseFloat(getComputedStyle(area).lineHeight) || 18;
  }

  function number() {
    const count = area.value.split("\n").length;
    if (count === lines) return;
    lines = count;
    fill(gutter, Array.from({ length: count }, (_, i) => h("div", null, String(i + 1))));
    faulty();
  }

  function faulty() {
    const wrong = new Map(store.faults.filter((it) => it.line).map((it) => [it.line, it.message]));
    for (const it of gutter.querySelectorAll(".faulty")) {
      it.classList.remove("faulty");
      it.title = "";
    }
    for (const [line, message] of wrong) {
      gutter.children[line - 1]?.classList.add("faulty");
      gutter.children[line - 1]?.setAttribute("title", message);
    }
  }

  // Only after the faults of a state, one of which is the reason.
  function warn() {
    const broken = !store.readable;
    banner.hidden = !broken;
    const first = store.faults.find((it) => it.line) ?? store.faults[0];
    banner.textContent = broken ? `The text cannot be read${first?.line ? `, line ${first.line}` : ""}: ${first?.message ?? ""}. The map shows it as it was before.` : "";
  }

  function place(path) {
    return store.places.find(([it]) => samePath(it, path)) ?? store.places.find(([it]) => isWithin(path, it) && it.length > 1);
  }

  function mark() {
    const height = lineHeight();
    const found = store.selection.map(place).filter(Boolean);
    fill(
      marks,
      found.map(([, first, last]) => {
        const bar = h("div", { class: "line-mark" });
        bar.style.top = `${(first - 1) * height + 8}px`;
        bar.style.height = `${(last - first + 1) * height}px`;
        return bar;
      }),
    );
    if (!found.length || fromCaret || document.activeElement === area) return;
    const top = (found[0][1] - 1) * height;
    if (top < area.scrollTop || top > area.scrollTop + area.clientHeight - 3 * height) area.scrollTop = Math.max(0, top - 2 * height);
  }

  area.addEventListener("scroll", () => {
    gutter.style.transform = `translateY(${-area.scrollTop}px)`;
    marks.style.transform = `translateY(${-area.scrollTop}px)`;
  });

  const caret = later(120, () => {
    if (document.activeElement !== area || typed) return;
    const line = area.value.slice(0, area.selectionStart).split("\n").length;
    const inside = store.places.filter(([path, first, last]) => first <= line && line <= last && isOnMap(path));
    const best = inside.sort((a, b) => b[0].length - a[0].length)[0];
    if (!best || store.selection.some((it) => keyOf(it) === keyOf(best[0]))) return;
    fromCaret = true;
    store.select([best[0]]);
    fromCaret = false;
  });
  for (const kind of ["keyup", "pointerup"]) area.addEventListener(kind, caret);

  store.listen("text", () => {
    // Text that is being typed is newer.
    if (!typed && area.value !== store.text) {
      const { selectionStart, selectionEnd, scrollTop } = area;
      area.value = store.text;
      area.setSelectionRange(selectionStart, selectionEnd);
      area.scrollTop = scrollTop;
    }
    number();
    warn();
    mark();
  });
  store.listen("faults", () => {
    faulty();
    warn();
  });
  store.listen("selection", mark);
  element.addEventListener("shown", mark);
  return element;
}
