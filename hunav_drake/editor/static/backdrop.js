import { button, h, refill, svg } from "./dom.js";
import { sentence } from "./fields.js";
import { applyFix } from "./problems.js";

/** Returns the corners of a background, in meters. */
export function cornersOf(background) {
  if (!background) return [];
  const { width_m: w, height_m: d, origin: [x, y, yaw = 0] } = background;
  const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
  return [[0, 0], [w, 0], [w, d], [0, d]].map(([u, v]) => [x + c * u - s * v, y + s * u + c * v]);
}

/**
 * The parts behind and beside the map: the grid, the background image,
 * the scale bar, the coordinates and the buttons of the view.
 */
export function makeBackdrop(store, view) {
  const fine = svg("path", { class: "grid" });
  const bold = svg("path", { class: "grid bold" });
  const axes = svg("path", { class: "grid axes" });
  const image = svg("image", { class: "background", preserveAspectRatio: "none" });
  const behind = svg("g", { class: "backdrop", "aria-hidden": "true" }, image, fine, bold, axes);

  const bar = h("div", { class: "scale-bar" });
  const coordinates = h("output", { class: "coordinates", "aria-live": "off" });
  const hint = h("div", { class: "hint", hidden: true });
  const buttons = h(
    "div",
    { class: "view-buttons", role: "group", "aria-label": "View" },
    button("plus", "Zoom in (+)", () => store.map.zoom(1.4)),
    button("minus", "Zoom out (-)", () => store.map.zoom(1 / 1.4)),
    button("fit", "Show all (0)", () => store.map.fit()),
    button("help", "Keys and gestures (?)", () => store.tell("help")),
  );
  const offer = h("div", { class: "offer", role: "status", hidden: true });
  const front = h("div", { class: "over-map" }, hint, offer, coordinates, bar, buttons);

  // A picture without walls misleads, so what to do is offered at once.
  let refused = null;
  function offerTrace() {
    const fault = store.faults.find((it) => it.fix?.do === "trace");
    offer.hidden = !fault || !store.background || refused === store.background.image;
    if (offer.hidden) return;
    refill(offer, [
      h("span", null, sentence(fault)),
      h(
        "span",
        { class: "row" },
        store.background.is_map ? null : button("measure", "Set the size of the picture by two places with a known distance", () => store.tools.choose("scale"), { text: "Set scale" }),
        button("polygon", "Trace the walls of the picture", () => applyFix(store, fault.fix), { text: "Trace walls", class: "button primary" }),
        button("close", "Not now; the list of problems has it, too", () => ((refused = store.background.image), offerTrace()), { text: "Not now" }),
      ),
    ]);
  }
  store.listen("faults", offerTrace);

  store.listen("hint", ({ text }) => {
    hint.textContent = text;
    hint.hidden = !text;
  });
  store.listen("pointer", ({ at }) => {
    coordinates.textContent = at ? `${at.map((it) => (Math.round(it * 100) / 100 + 0).toFixed(2)).join(", ")} m` : "";
  });
  store.background = null;
  store.listen("background", (message) => {
    store.background = message.image ? message : null;
    image.style.display = store.background ? "" : "none";
    offerTrace();
    if (store.background) {
      const [x, y, yaw = 0] = message.origin;
      image.setAttribute("href", message.image);
      image.setAttribute("width", message.width_m);
      image.setAttribute("height", message.height_m);
      const turn = (yaw * 180) / Math.PI;
      const place = `translate(${x} ${y}) rotate(${turn}) translate(0 ${message.height_m}) scale(1 -1)`;
      image.setAttribute("transform", place);
      image.style.opacity = String(message.opacity ?? 0.6);
    }
  });
  store.listen("background-opacity", ({ value }) => {
    image.style.opacity = String(value);
  });

  return {
    behind,
    front,

    /** Updates it after a change of the view. */
    update() {
      behind.setAttribute("transform", view.matrix);
      const [some, others] = view.grid();
      fine.setAttribute("d", some);
      bold.setAttribute("d", others);
      axes.setAttribute("d", `M0 -0.5V0.5M-0.5 0H0.5`);
      const length = view.scaleLength();
      bar.style.width = `${length * view.scale}px`;
      bar.textContent = length >= 1 ? `${length} m` : `${length * 100} cm`;
    },
  };
}
