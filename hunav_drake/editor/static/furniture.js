import { h, fill, svg } from "./dom.js";
import { membersOf, defaultsOf } from "./schema.js";
import { addParts, boxOutline, newName, pictureAt } from "./newparts.js";
import { outline, piecesOf } from "./shapes.js";

const FURNITURE = ["world", "furniture"];

/** The kinds that scenarios have most, in this order. */
const COMMON = ["chair", "shelf", "plant", "desk", "table", "door_frame", "bench", "bed", "counter", "pallet", "pillar", "sofa"];

/** Draws a kind of furniture from above, all in one scale but for large ones. */
function pictureOf(picture) {
  if (!picture) return null;
  const side = Math.max(1, ...picture.points.flat().map((it) => 2.1 * Math.abs(it)));
  const all = [svg("path", { class: "shape", d: outline(picture.points) }), ...piecesOf(picture.pieces)];
  // Its front, +x, points down, as to who looks at the list.
  return svg("svg", { class: "picture", viewBox: `${-side / 2} ${-side / 2} ${side} ${side}`, "aria-hidden": "true" }, svg("g", { class: "fixture", "data-key": "world/furniture", "data-kind": picture.kind, transform: "rotate(90)" }, ...all));
}

/** A palette of furniture, which is placed by clicks. */
export function furnitureTool(store, map) {
  let kind = null;
  const search = h("input", { type: "search", placeholder: "Furniture …", "aria-label": "Kind of furniture", oninput: () => showKinds() });
  const list = h("div", { class: "palette-list" });
  const palette = h("div", { class: "palette", hidden: true, role: "group", "aria-label": "Furniture" }, search, list);
  map.element.append(palette);

  const pictures = () => new Map(store.catalog.furniture.map((it) => [it.type, it]));
  /** The kinds, those first that this scenario has most, then those of others. */
  function members() {
    const used = (tag) => (store.get(FURNITURE) ?? []).filter((it) => it?.type === tag).length;
    const common = (tag) => (COMMON.indexOf(tag) + 1 || 99);
    const all = membersOf(store.catalog.schema, ["world", "furniture", 0]);
    return [...all].sort((a, b) => used(b.tag) - used(a.tag) || common(a.tag) - common(b.tag));
  }
  function choose(member) {
    kind = member;
    // Away from the click targets.
    palette.hidden = true;
    store.tell("hint", { text: tool.hint });
    map.element.focus({ preventScroll: true });
  }
  function found() {
    const words = search.value.trim().toLowerCase().replace(/ /g, "_");
    return members().filter((it) => it.tag.includes(words));
  }
  function showKinds() {
    const known = pictures();
    fill(
      list,
      found().map((it) =>
        h("button", { type: "button", class: "kind-card", "aria-pressed": String(kind?.tag === it.tag), onclick: () => choose(it) }, pictureOf(known.get(it.tag)), h("span", null, it.tag.replace(/_/g, " "))),
      ),
    );
  }
  search.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && found().length) {
      choose(found()[0]);
      tool.down(map.view.middle.map((it) => Math.round(it * 10) / 10), { detail: 1 });
    } else if (event.key === "Escape") {
      store.tools.choose("select");
      map.element.focus({ preventScroll: true });
    } else if (event.key !== "Enter") {
      return;
    }
    event.preventDefault();
  });
  for (const name of ["pointerdown", "wheel"]) palette.addEventListener(name, (event) => event.stopPropagation());

  const tool = {
    name: "furniture",
    title: "Furniture",
    icon: "furniture",
    key: "f",
    get hint() {
      return kind ? `Click to place the ${kind.tag.replace(/_/g, " ")}; F chooses another kind.` : "Choose a kind of furniture.";
    },
    enter() {
      palette.hidden = false;
      kind ??= members()[0] ?? null;
      showKinds();
      search.focus();
    },
    down(place) {
      if (!kind) return null;
      palette.hidden = true;
      const name = newName(store, FURNITURE, kind.tag);
      const value = { type: kind.tag, name, center: place };
      const { size = [0.5, 0.5], height = 1 } = defaultsOf(kind.schema);
      const picture = pictures().get(kind.tag);
      const shown = picture ? pictureAt(picture, place) : boxOutline({ center: place, size, height }, kind.tag);
      addParts(store, `Add ${name}`, [{ list: FURNITURE, value }], [shown]);
      return null;
    },
    finish: () => false,
    leave() {
      palette.hidden = true;
    },
  };
  return tool;
}
