import { h, fill } from "./dom.js";
import { membersOf, defaultsOf } from "./schema.js";
import { addParts, boxOutline, newName } from "./newparts.js";

const FURNITURE = ["world", "furniture"];

/** A palette of furniture, which is placed by clicks. */
export function furnitureTool(store, map) {
  let kind = null;
  const search = h("input", { type: "search", placeholder: "Furniture …", "aria-label": "Kind of furniture", oninput: () => showKinds() });
  const list = h("div", { class: "palette-list" });
  const palette = h("div", { class: "palette", hidden: true, role: "group", "aria-label": "Furniture" }, search, list);
  map.element.append(palette);

  const members = () => membersOf(store.catalog.schema, ["world", "furniture", 0]);
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
    fill(
      list,
      found().map((it) =>
        h("button", { type: "button", class: "chip", "aria-pressed": String(kind?.tag === it.tag), onclick: () => choose(it) }, it.tag.replace(/_/g, " ")),
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
      addParts(store, `Add ${name}`, [{ list: FURNITURE, value }], [boxOutline({ center: place, size, height }, kind.tag)]);
      return null;
    },
    finish: () => false,
    leave() {
      palette.hidden = true;
    },
  };
  return tool;
}
