import { button, h } from "./dom.js";
import { sameValue } from "./data.js";
import { numberInput, row, toMillimeters, words } from "./fields.js";

/**
 * Fields of lists of plain values: points, words, numbers, weights.
 */

/** A table of points, which Alt and arrows reorder. */
export function pointsField(target, node, path) {
  const list = h("div", { class: "points", role: "group" });
  const add = button("plus", "Add a point", () => write([...points(), points().at(-1)?.map((it, axis) => (axis < 2 ? it + 1 : it)) ?? node.item.items.map(() => 0)]), { text: "Add" });
  const all = row(target, node, path, h("div", null, list, add), { wide: true, input: list });
  let rows = [];
  const points = () => {
    const { value } = target.value(path);
    return Array.isArray(value) ? value : [];
  };
  const label = () => `Change ${words(path.at(-1))} of ${target.what()}`;
  const write = (value) => target.set(path, value, label());
  function move(i, step) {
    const value = [...points()];
    if (i + step < 0 || i + step >= value.length) return;
    value.splice(i + step, 0, ...value.splice(i, 1));
    write(value);
    rows[i + step]?.inputs[0].input.focus();
  }
  function makeRow(i) {
    const inputs = ["x", "y", "yaw"].slice(0, node.item.items.length).map((name, axis) =>
      numberInput(node.item.items[axis], {
        label: `${name} of point ${i + 1}`,
        read: () => ({ value: toMillimeters(points()[i]?.[axis]), mixed: false }),
        write: (number) => write(points().map((it, j) => (j === i ? it.map((old, k) => (k === axis ? number : old)) : it))),
      }),
    );
    const element = h(
      "div",
      {
        class: inputs.length > 2 ? "point posed" : "point",
        onkeydown(event) {
          const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
          if (!step || !event.altKey) return;
          event.preventDefault();
          event.stopPropagation();
          move(i, step);
        },
      },
      h("span", { class: "index" }, String(i + 1)),
      inputs.map((it) => it.input),
      button("up", `Move point ${i + 1} up (Alt+Up)`, () => move(i, -1)),
      button("bin", `Delete point ${i + 1}`, () => write(points().filter((_, j) => j !== i))),
    );
    return { element, inputs };
  }
  return {
    element: all.element,
    refresh() {
      const { mixed } = target.value(path);
      add.disabled = mixed;
      const { length } = points();
      while (rows.length > length) rows.pop().element.remove();
      while (rows.length < length) {
        rows.push(makeRow(rows.length));
        list.append(rows.at(-1).element);
      }
      rows.forEach((it) => it.inputs.forEach((input) => input.refresh()));
      all.refresh();
    },
  };
}

/** Returns the field of a list of words with check boxes. */
function checksField(target, node, path) {
  const { values } = node.item;
  const present = () => target.value(path).value ?? node.fallback ?? [];
  const boxes = values.map((name) => {
    const onchange = () => target.set(path, values.filter((it) => (it === name ? input.checked : present().includes(it))));
    const input = h("input", { type: "checkbox", onchange });
    return { name, input, element: h("label", { class: "check" }, input, words(name)) };
  });
  const all = row(target, node, path, h("div", { class: "checks", role: "group" }, boxes.map((it) => it.element)), { wide: true });
  return {
    element: all.element,
    refresh() {
      boxes.forEach((it) => (it.input.checked = present().includes(it.name)));
      all.refresh();
    },
  };
}

/** A field of one line of text; `parts` of it, separated by commas, are read and shown. */
function lineField(target, node, path, { hint, read, show }) {
  const input = h("input", {
    type: "text",
    onchange() {
      const parts = input.value.split(",").map((it) => it.trim()).filter(Boolean);
      const value = read(parts);
      if (!parts.length) target.reset(path);
      else if (!sameValue(value, target.value(path).value)) target.set(path, value);
    },
  });
  const all = row(target, node, path, input, { wide: true });
  return {
    element: all.element,
    refresh() {
      const { value, mixed } = target.value(path);
      input.placeholder = mixed ? "mixed" : hint;
      if (document.activeElement !== input) input.value = show(value);
      all.refresh();
    },
  };
}

/** A list of words or numbers: separated by commas, or check boxes. */
export function textsField(target, node, path) {
  const { kind } = node.item;
  if (kind === "enum") return checksField(target, node, path);
  const isNumber = kind === "number" || kind === "integer";
  return lineField(target, node, path, {
    hint: (Array.isArray(node.fallback) ? node.fallback : []).join(", ") || "separated by commas",
    read: (parts) => (isNumber ? parts.map((it) => (Number.isFinite(Number(it)) ? Number(it) : it)) : parts),
    show: (value) => (Array.isArray(value) ? value.join(", ") : value === undefined ? "" : String(value)),
  });
}

/** Names with numbers, as weights: "regular: 6, curious: 3". */
export function mapField(target, node, path) {
  const pair = (text) => {
    const [key, number] = text.split(":").map((it) => it.trim());
    return [key, number && Number.isFinite(Number(number)) ? Number(number) : 1];
  };
  return lineField(target, node, path, {
    hint: "name: weight, name: weight",
    read: (parts) => Object.fromEntries(parts.map(pair).filter(([key]) => key)),
    show: (value) => Object.entries(value ?? {}).map(([key, number]) => `${key}: ${number}`).join(", "),
  });
}
