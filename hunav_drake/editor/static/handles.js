import { svg } from "./dom.js";
import { keyOf, valueAt } from "./data.js";
import { headingOf, isDisc, isPoint, isPose } from "./things.js";

/** The maximum number of corners with handles. */
const MOST_CORNERS = 80;

/** The distance of the turn handle from the outline, in pixels. */
const ARM = 22;

/** Returns the signs of a corner along the part's x and y. */
const SIZES = [
  [-1, -1],
  [0, -1],
  [1, -1],
  [1, 0],
  [1, 1],
  [0, 1],
  [-1, 1],
  [-1, 0],
];

/** Returns the handles of the single selected part, as plain data. */
function handlesOf(data, path, scale) {
  const value = valueAt(data, path);
  const px = 1 / scale;
  const handles = [];
  const heading = headingOf(data, path);
  if (heading) {
    const { at, yaw } = heading;
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    const reach = isPoint(value?.size) ? value.size[0] / 2 : Math.max(value?.radius ?? 0.35, 8 * px);
    const arm = reach + ARM * px;
    handles.push({ name: "turn", x: at[0] + arm * c, y: at[1] + arm * s, from: [at[0] + reach * c, at[1] + reach * s] });
    if (isPoint(value?.size) && !isPose(value)) {
      const [w, d] = value.size;
      for (const [u, v] of SIZES) {
        // Small parts have only handles that do not overlap.
        if (Math.min(w, d) * scale < 24 && (u === 0 || v === 0)) continue;
        const [dx, dy] = [(u * w) / 2, (v * d) / 2];
        handles.push({ name: `size ${u} ${v}`, x: at[0] + c * dx - s * dy, y: at[1] + s * dx + c * dy, square: true });
      }
    }
  }
  if (isDisc(value)) handles.push({ name: "radius", x: value.center[0] + value.radius, y: value.center[1], square: true });
  const points = value?.points;
  if (Array.isArray(points) && points.length <= MOST_CORNERS && points.every(isPoint)) {
    const closed = points.length > 2 && value.type !== "polyline";
    points.forEach(([x, y], i) => {
      handles.push({ name: `corner ${i}`, x, y, square: true });
      const next = points[i + 1] ?? (closed ? points[0] : null);
      if (!next || Math.hypot(next[0] - x, next[1] - y) * scale < 36) return;
      handles.push({ name: `side ${i}`, x: (x + next[0]) / 2, y: (y + next[1]) / 2, faint: true });
    });
  }
  return handles;
}

/** Draws the handles of the selection into a group. */
export function drawHandles(group, store, { data }, scale) {
  const path = store.selection.length === 1 ? store.selection[0] : null;
  const list = path ? handlesOf(data, path, scale) : [];
  const px = 1 / scale;
  const names = list.map((it) => it.name).join(",");
  const key = path ? keyOf(path) : "";
  if (group.dataset.names !== names || group.dataset.of !== key) {
    group.dataset.names = names;
    group.dataset.of = key;
    group.replaceChildren(
      ...list.map((it) =>
        svg(
          "g",
          { class: it.faint ? "handle faint" : "handle", "data-handle": it.name, tabindex: -1, role: "img", "aria-label": it.name },
          svg("line", { class: "arm" }),
          svg("circle", { class: "hit" }),
          svg("path", { class: "grip" }),
        ),
      ),
    );
  }
  list.forEach((it, i) => {
    const element = group.children[i];
    const [arm, hit, grip] = element.children;
    element.setAttribute("transform", `translate(${it.x} ${it.y})`);
    hit.setAttribute("r", 11 * px);
    const r = (it.faint ? 3.5 : it.square ? 4.5 : 6) * px;
    const round = `M${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
    grip.setAttribute("d", it.square ? `M${-r} ${-r}h${2 * r}v${2 * r}h${-2 * r}Z` : round);
    if (it.from) {
      arm.setAttribute("x2", it.from[0] - it.x);
      arm.setAttribute("y2", it.from[1] - it.y);
    }
  });
}
