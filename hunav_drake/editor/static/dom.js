/**
 * Elements of the page. Text always becomes a text node, so no text of a
 * scenario can become HTML.
 */

const SVG = "http://www.w3.org/2000/svg";

/** Properties that do not follow the attribute after user input. */
const PROPERTIES = new Set(["value", "checked", "disabled", "indeterminate"]);

/**
 * Sets attributes: functions become listeners ("onclick"), `style` takes a
 * mapping, and null or false is omitted.
 * @param {Element} element
 * @param {Object<string, any>} attributes
 */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") {
      element.addEventListener(name.slice(2), value);
    } else if (name === "style") {
      for (const [key, text] of Object.entries(value)) {
        element.style.setProperty(key, text);
      }
    } else if (PROPERTIES.has(name) && name in element) {
      element[name] = value;
    } else if (value === null || value === undefined || value === false) {
      element.removeAttribute(name);
    } else {
      element.setAttribute(name, value === true ? "" : String(value));
    }
  }
}

function make(element, attributes, children) {
  set(element, attributes ?? {});
  element.append(...children.flat(3).filter((it) => it !== null && it !== undefined && it !== false));
  return element;
}

/**
 * Makes an HTML element.
 * @param {string} tag
 * @param {Object<string, any>?} attributes
 * @param {...any} children Elements and texts; null is skipped.
 * @returns {HTMLElement}
 */
export function h(tag, attributes, ...children) {
  return make(document.createElement(tag), attributes, children);
}

/**
 * Makes an SVG element.
 * @param {string} tag
 * @param {Object<string, any>?} attributes
 * @param {...any} children
 * @returns {SVGElement}
 */
export function svg(tag, attributes, ...children) {
  return make(document.createElementNS(SVG, tag), attributes, children);
}

/** Replaces the children of an element. */
export function fill(element, ...children) {
  element.replaceChildren(...children.flat(3).filter((it) => it !== null && it !== undefined && it !== false));
  return element;
}

const wordsOf = (it) => `${it.tagName} ${it.href ?? ""} ${it.getAttribute("aria-label") ?? it.textContent}`;

/**
 * Replaces the children of an element that may have the focus: then it moves to
 * the new child with the same text, else to the map, so that keys still work.
 */
export function refill(element, ...children) {
  const held = element.contains(document.activeElement) ? document.activeElement : null;
  fill(element, ...children);
  if (!held || held.isConnected) return;
  const same = [...element.querySelectorAll("button, a, input, select")].find((it) => wordsOf(it) === wordsOf(held));
  (same ?? element.closest(".hunav-editor")?.querySelector(".map"))?.focus({ preventScroll: true });
}

/** Returns a function that calls f once, `wait` ms after its last call. */
export function later(wait, f) {
  let timer = 0;
  const call = (...values) => {
    call.stop();
    const act = () => {
      call.stop();
      f(...values);
    };
    timer = setTimeout(act, wait);
    due.set(call, act);
  };
  call.stop = () => {
    clearTimeout(timer);
    due.delete(call);
  };
  return call;
}

/** What `later` has put off. */
const due = new Map();

/** Does at once what `later` has put off, as sending what was typed. */
export const doNow = () => [...due.values()].forEach((act) => act());

/** Returns a function that calls f once at the next frame. */
export function atFrame(f) {
  let asked = false;
  return () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      f();
    });
  };
}

/** The lines of icons, in a square of 24. */
const ICONS = {
  select: "M5 3l14 8-6.5 1.5L9 19z",
  person: "M12 4a3 3 0 1 1 0 6 3 3 0 0 1 0-6zM5.5 20c.5-4 3-6.5 6.5-6.5s6 2.5 6.5 6.5",
  goal: "M6 21V4h11l-2.5 3.5L17 11H6",
  robot: "M5 9h14v9H5zM12 9V5M9 13h.01M15 13h.01M3 12v3M21 12v3",
  place: "M12 21s-6-6.4-6-11a6 6 0 0 1 12 0c0 4.6-6 11-6 11zM12 8a2 2 0 1 1 0 4 2 2 0 0 1 0-4z",
  target: "M12 5a7 7 0 1 1 0 14 7 7 0 0 1 0-14zM12 2v5M12 17v5M2 12h5M17 12h5",
  wall: "M4 19L10 6l10 4",
  polygon: "M12 3l8.5 6.5L17 20H7L3.5 9.5z",
  box: "M4 7h16v10H4z",
  disc: "M12 5a7 7 0 1 1 0 14 7 7 0 0 1 0-14zM12 12h.01",
  room: "M4 5h16v14h-6M4 5v14h6M10 19v-2M14 19v-2",
  door: "M3 20h4M17 20h4M7 20V5h10v15M14 12.5v.01",
  furniture: "M4 10h16M6 10v9M18 10v9M4 10V8h16v2",
  measure: "M3 16L16 3l5 5L8 21zM8 11l2 2M11 8l2 2M14 5l2 2",
  undo: "M8 5L4 9l4 4M4 9h10a5.5 5.5 0 0 1 0 11h-4",
  redo: "M16 5l4 4-4 4M20 9H10a5.5 5.5 0 0 0 0 11h4",
  save: "M5 4h11l3 3v13H5zM8 4v5h7V4M8 20v-6h8v6",
  run: "M7 4.5l12 7.5-12 7.5z",
  stop: "M6 6h12v12H6z",
  menu: "M4 7h16M4 12h16M4 17h16",
  snap: "M6 4v7a6 6 0 0 0 12 0V4h-4v7a2 2 0 0 1-4 0V4zM6 8h4M14 8h4",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  plus: "M12 5v14M5 12h14",
  minus: "M5 12h14",
  bin: "M5 7h14M9 7V4h6v3M7 7l1 13h8l1-13M10 11v5M14 11v5",
  reset: "M5 5v5h5M5.5 10a7.5 7.5 0 1 1-1 5",
  up: "M12 19V6M6 11l6-6 6 6",
  help: "M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.200-1.5 2.4M12 17.5v.01",
  close: "M6 6l12 12M18 6L6 18",
  fold: "M9 6l6 6-6 6",
  warning: "M12 4l9 16H3zM12 10v4M12 17v.01",
  check: "M5 13l4 4L19 7",
  search: "M10.5 4a6.5 6.5 0 1 1 0 13 6.5 6.5 0 0 1 0-13zM15.5 15.5L21 21",
  copy: "M9 9h11v11H9zM15 9V4H4v11h5",
  group: "M8.5 5a3 3 0 1 1 0 6 3 3 0 0 1 0-6zM3 19c.4-3.5 2.5-5.5 5.5-5.5S13.6 15.5 14 19M15.5 6a2.5 2.5 0 1 1 .5 5M17 13.6c2.300.4 3.700 2.4 4 5.4",
  array: "M4 4h6v6H4zM14 4h6v6h-6zM4 14h6v6H4zM14 14h6v6h-6z",
  alignx: "M12 3v18M6 7h12v3H6zM8 14h8v3H8z",
  aligny: "M3 12h18M7 6v12h3V6zM14 8v8h3V8z",
  image: "M4 5h16v14H4zM4 16l5-5 4 4 3-3 4 4M9 9v.01",
  open: "M3 7h6l2 2h10v10H3z",
};

/**
 * Creates an icon.
 * @param {string} name
 * @returns {SVGElement}
 */
export function icon(name) {
  return svg(
    "svg",
    { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true" },
    svg("path", { d: ICONS[name] ?? "" }),
  );
}

/** Creates a button with an icon and perhaps a text. */
export function button(name, title, onclick, { text = "", ...rest } = {}) {
  return h(
    "button",
    { type: "button", title, "aria-label": title, class: text ? "button" : "button square", onclick, ...rest },
    name ? icon(name) : null,
    text ? h("span", null, text) : null,
  );
}
