import { button, h } from "./dom.js";

/**
 * Creates panels with a bar of tabs.
 * @param {[string, string, HTMLElement][]} panels Title, key and element each.
 * @param {{label: string, folds?: boolean}} options Whether the panels fold
 *   away, and begin so.
 */
export function makeTabs(panels, { label, folds = false }) {
  const bar = h("div", { class: "tab-list", role: "tablist", "aria-label": label });
  const box = h("div", { class: "tab-box" });
  /** @type {Map<string, {tab: HTMLElement, panel: HTMLElement}>} */
  const all = new Map();
  let shown = null;

  const fold = folds
    ? button("fold", "Show or hide this part", () => setFolded(!element.classList.contains("folded")), { class: "button square fold" })
    : null;
  const element = h("div", { class: folds ? "tabs folded" : "tabs" }, h("div", { class: "tab-bar" }, bar, fold), box);

  function setFolded(folded) {
    element.classList.toggle("folded", folded);
    if (!folded && !shown) tabs.show(all.keys().next().value);
    mark();
  }

  function mark() {
    const folded = element.classList.contains("folded");
    for (const [key, { tab, panel }] of all) {
      const on = key === shown && !folded;
      tab.setAttribute("aria-selected", String(on));
      tab.tabIndex = key === (shown ?? all.keys().next().value) ? 0 : -1;
      panel.hidden = key !== shown;
    }
    fold?.setAttribute("aria-expanded", String(!folded));
    element.dispatchEvent(new CustomEvent("shown", { detail: folded ? null : shown }));
  }

  bar.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const keys = [...all.keys()];
    const at = keys.indexOf(shown ?? keys[0]);
    const key = keys[(at + step + keys.length) % keys.length];
    tabs.show(key);
    all.get(key).tab.focus();
    event.preventDefault();
  });

  const tabs = {
    element,

    /** Shows a panel; returns whether it exists. */
    show(key) {
      if (!all.has(key)) return false;
      shown = key;
      if (folds) element.classList.remove("folded");
      mark();
      all.get(key).panel.firstElementChild?.dispatchEvent(new CustomEvent("shown"));
      return true;
    },

    /** Adds a panel, by default as the last. */
    add(title, key, panel, place = all.size) {
      if (all.has(key)) return;
      const tab = h(
        "button",
        {
          type: "button",
          role: "tab",
          class: "tab",
          "data-tab": key,
          onclick: () => (folds && shown === key && !element.classList.contains("folded") ? setFolded(true) : tabs.show(key)),
        },
        h("span", null, title),
        h("span", { class: "count", hidden: true }),
      );
      const page = h("div", { role: "tabpanel", class: "tab-panel", "aria-label": title, hidden: true }, panel);
      bar.insertBefore(tab, bar.children[place] ?? null);
      box.append(page);
      all.set(key, { tab, panel: page });
      panel.addEventListener("count", (event) => {
        const count = tab.lastElementChild;
        count.hidden = !event.detail;
        count.textContent = event.detail ? String(event.detail) : "";
      });
      panel.addEventListener("show", () => tabs.show(key));
      mark();
    },

    /** Removes a panel. */
    take(key) {
      const found = all.get(key);
      if (!found) return;
      found.tab.remove();
      found.panel.remove();
      all.delete(key);
      if (shown === key) tabs.show(all.keys().next().value);
    },

    get shown() {
      return shown;
    },
  };
  for (const [title, key, panel] of panels) tabs.add(title, key, panel);
  mark();
  return tabs;
}
