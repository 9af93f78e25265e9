import { svg } from "./dom.js";

/**
 * Sets the size of a picture: two clicks on it, and the distance of the
 * places.
 */
export function scaleTool(store, map) {
  let first = null;
  // Without the grid, because the size is not known yet.
  const exact = (place, event) => (event.pointerId ? map.view.toWorld(...map.pixels(event)) : place);
  const draw = (to) => map.sketch.replaceChildren(svg("path", { class: "sketch-line", d: `M${first.join(" ")}L${to.join(" ")}` }));
  return {
    name: "scale",
    title: "Scale of the picture",
    get hint() {
      return first ? "Click the second place." : "Click two places of the picture whose distance you know.";
    },
    down(place, event) {
      const at = exact(place, event);
      if (!first) {
        first = at;
        draw(at);
        store.tell("hint", { text: this.hint });
      } else if (Math.hypot(at[0] - first[0], at[1] - first[1]) * map.scale > 5) {
        store.tell("dialog", { what: "scale", from: first, to: at });
        store.tools.choose("select");
      }
      return null;
    },
    hover: (place) => first && draw(place),
    finish: () => false,
    leave() {
      first = null;
      map.sketch.replaceChildren();
    },
  };
}
