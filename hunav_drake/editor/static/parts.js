import { button, fill, h } from "./dom.js";
import { sameValue, valueAt } from "./data.js";
import { setOp } from "./changes.js";
import { describe, memberOf, skeleton } from "./schema.js";
import { checkField, choiceField, numberField, numberInput, row, textField, tupleField, words } from "./fields.js";

/**
 * Fields of values that consist of others: objects, unions, lists, tables.
 */

/** Returns the field for what a schema says. */
export function makeField(target, root, node, path) {
  switch (node.kind) {
    case "number":
    case "integer":
      return numberField(target, node, path);
    case "boolean":
      return node.optional
        ? choiceField(target, node, path, () => [[true, "yes"], [false, "no"]])
        : checkField(target, node, path);
    case "enum":
      return choiceField(target, node, path);
    case "behavior":
      return choiceField(target, node, path, () => target.store.catalog.behaviors.map((it) => [it.name, words(it.name)]));
    case "text":
      return textField(target, node, path);
    case "tuple":
      return tupleField(target, node, path);
    case "points":
      return pointsField(target, node, path);
    case "object":
      return section(target, node, path, (body) => objectBody(target, root, node, path, body));
    case "union":
      return unionField(target, root, node, path);
    case "list":
      return node.item.kind === "union" || node.item.kind === "object" ? listField(target, root, node, path) : textsField(target, node, path);
    case "map":
      return mapField(target, node, path);
    case "deferred":
      return noteField(path, "Its settings come with the simulator, which is still starting.");
    default:
      return noteField(path, "Edit it in the YAML text.");
  }
}

function noteField(path, text) {
  const element = h("div", { class: "field wide" }, h("span", { class: "label" }, words(path.at(-1) ?? "")), h("p", { class: "help shown" }, text));
  return { element, refresh() {} };
}

/** A part that folds; what is in it is made when it is first unfolded. */
function section(target, node, path, makeBody, { open = false, extra = null } = {}) {
  const body = h("div", { class: "section-body" });
  const badge = h("span", { class: "badge-count", hidden: true });
  const given = h("span", { class: "given", title: "Not all as by default", hidden: true });
  const name = words(path.at(-1) ?? node.title);
  const element = h(
    "details",
    { class: "section", "data-field": path.join("/") },
    h("summary", { title: node.help }, h("span", { class: "section-name" }, name), given, badge, extra),
    body,
  );
  let inner = null;
  function unfold() {
    if (!element.open || inner) return;
    inner = makeBody(body);
    inner.refresh();
  }
  element.addEventListener("toggle", unfold);
  element.open = open;
  unfold();
  return {
    element,
    refresh() {
      const faults = target.faults(path, true).length;
      badge.hidden = !faults;
      badge.textContent = String(faults);
      element.classList.toggle("is-faulty", faults > 0);
      given.hidden = !target.values(path).some((it) => it !== undefined && !(it && typeof it === "object" && !Object.keys(it).length));
      inner?.refresh();
    },
  };
}

/** The fields of an object, those named first in front; unknown keys last. */
export function objectBody(target, root, node, path, body, { without = [], first = [], rest = false } = {}) {
  const keys = Object.keys(node.properties).filter((key) => !without.includes(key));
  keys.sort((a, b) => (first.indexOf(a) + 1 || 99) - (first.indexOf(b) + 1 || 99));
  const fields = [];
  const all = [];
  for (const key of keys) {
    const it = describe(root, node.properties[key]);
    if (it.kind === "const") continue;
    all.push([it, makeField(target, root, it, [...path, key])]);
  }
  // Single values before parts that fold.
  const isPart = ([it]) => ["object", "union", "list"].includes(it.kind);
  for (const pair of [...all.filter((it) => !isPart(it)), ...all.filter(isPart)]) fields.push(pair[1]);
  const unknown = h("div", { class: "unknown" });
  const isFirst = (it) => !rest || first.includes(it.element.dataset.field.split("/").at(-1));
  const others = fields.filter((it) => !isFirst(it));
  const more = others.length ? h("details", { class: "section more" }, h("summary", null, h("span", { class: "section-name" }, "more")), h("div", { class: "section-body" }, others.map((it) => it.element))) : null;
  fill(body, fields.filter(isFirst).map((it) => it.element), unknown, more);
  return {
    refresh() {
      fields.forEach((it) => it.refresh());
      // What is at fault is not hidden.
      if (more?.querySelector(".is-faulty")) more.open = true;
      const value = target.bases.length === 1 ? target.values(path)[0] : null;
      const strange = value && typeof value === "object" && !Array.isArray(value) ? Object.keys(value).filter((key) => !(key in node.properties)) : [];
      const allowed = node.schema.additionalProperties === true;
      fill(
        unknown,
        (allowed ? [] : strange).map((key) =>
          h("p", { class: "field-fault" }, `${key}: there is no such key `, button("bin", `Remove ${key}`, () => target.reset([...path, key]))),
        ),
      );
    },
  };
}

function unionField(target, root, node, path) {
  const body = h("div", { class: "union-body" });
  const { key } = node.members[0];
  const tags = () => [...new Set([...node.names, ...node.members.map((it) => it.tag)])];
  const select = h("select", {
    "aria-label": words(path.at(-1) ?? key),
    onchange() {
      const member = node.members.find((it) => it.tag === select.value);
      const { store, bases } = target;
      const ops = bases.map((base) => {
        const old = valueAt(store.data, [...base, ...path]);
        const kept = Object.entries(old && typeof old === "object" ? old : {}).filter(([name]) => name !== key && member?.schema.properties?.[name]);
        return setOp(store.data, [...base, ...path], { [key]: select.value, ...Object.fromEntries(kept) });
      });
      store.edit(`Choose ${words(select.value)} for ${target.what()}`, ops);
    },
    onclick: (event) => event.stopPropagation(),
  });
  let shown;
  let inner = null;
  const build = () => {
    const { value } = target.value(path);
    const member = memberOf(node, value ?? node.fallback) ?? (value === undefined ? node.members[0] : null);
    const tag = typeof value === "string" ? value : value?.[key] ?? member?.tag;
    const names = tags();
    select.replaceChildren(...(names.includes(tag) ? names : [tag ?? "", ...names]).map((it) => h("option", { value: it }, words(it ?? ""))));
    select.value = tag ?? "";
    if (shown === member?.tag && inner) return;
    shown = member?.tag;
    const it = member && describe(root, member.schema);
    if (it?.kind === "object") inner = objectBody(target, root, it, path, body);
    else {
      fill(body, it?.kind === "deferred" ? h("p", { class: "help shown" }, "Its settings come with the simulator, which is still starting.") : null);
      inner = { refresh() {} };
    }
  };
  const whole = section(target, { ...node, help: node.help }, path, (into) => {
    into.append(body);
    return {
      refresh() {
        build();
        inner.refresh();
      },
    };
  }, { extra: select });
  return {
    element: whole.element,
    refresh() {
      build();
      whole.refresh();
    },
  };
}

/** A table of points, which are reordered by Alt and an arrow. */
function pointsField(target, node, path) {
  const list = h("div", { class: "points", role: "group" });
  const add = button("plus", "Add a point", () => write([...points(), points().at(-1)?.map((it) => it + 1) ?? [0, 0]]), { text: "Add" });
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
    const inputs = ["x", "y"].map((name, axis) =>
      numberInput(node.item.items[axis], {
        label: `${name} of point ${i + 1}`,
        read: () => ({ value: points()[i]?.[axis], mixed: false }),
        write: (number) => write(points().map((it, j) => (j === i ? it.map((old, k) => (k === axis ? number : old)) : it))),
      }),
    );
    const element = h(
      "div",
      {
        class: "point",
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

/** A list of objects: each folds, and can be removed. */
function listField(target, root, node, path) {
  const { item } = node;
  return section(target, node, path, (body) => {
    const box = h("div", { class: "list" });
    const kinds = item.kind === "union" ? item.members : null;
    const choice = kinds && h("select", { "aria-label": `Kind of ${words(path.at(-1))}` }, kinds.map((it) => h("option", { value: it.tag }, words(it.tag))));
    const add = button("plus", `Add to ${words(path.at(-1))}`, () => {
      const member = kinds?.find((it) => it.tag === choice.value);
      const begin = member ? { [member.key]: member.tag, ...skeleton(root, describe(root, member.schema)) } : skeleton(root, item);
      const { store, bases } = target;
      store.edit(`Add to ${words(path.at(-1))}`, bases.map((base) => {
        const list = valueAt(store.data, [...base, ...path]) ?? [];
        return setOp(store.data, [...base, ...path], [...list, begin]);
      }));
    }, { text: "Add" });
    body.append(box, h("div", { class: "list-add" }, choice, add));
    let fields = [];
    let shape = "";
    return {
      refresh() {
        const { value } = target.value(path);
        const list = Array.isArray(value) ? value : [];
        const now = list.map((it) => (item.kind === "union" ? memberOf(item, it)?.tag : "")).join();
        if (now !== shape || fields.length !== list.length) {
          shape = now;
          fields = list.map((_, i) => makeField(target, root, item, [...path, i]));
          fill(box, fields.map((it, i) => h("div", { class: "list-item" }, it.element, button("bin", `Remove ${words(path.at(-1))} ${i + 1}`, () => target.reset([...path, i])))));
        }
        fields.forEach((it, i) => {
          const name = list[i]?.name || (typeof list[i] === "string" ? list[i] : Object.values(list[i] ?? {}).find((v) => typeof v === "string"));
          const title = it.element.querySelector(".section-name");
          if (title) title.textContent = `${i + 1}${name ? ` ${words(name)}` : ""}`;
          it.refresh();
        });
      },
    };
  });
}

/** A list of words or numbers: separated by commas, or boxes to check. */
function textsField(target, node, path) {
  const { item } = node;
  const isNumber = item.kind === "number" || item.kind === "integer";
  if (item.kind === "enum") {
    const boxes = item.values.map((name) => {
      const input = h("input", {
        type: "checkbox",
        onchange() {
          const chosen = item.values.filter((it) => (it === name ? input.checked : present().includes(it)));
          target.set(path, chosen);
        },
      });
      return { name, input, element: h("label", { class: "check" }, input, words(name)) };
    });
    const present = () => target.value(path).value ?? node.fallback ?? [];
    const all = row(target, node, path, h("div", { class: "checks", role: "group" }, boxes.map((it) => it.element)), { wide: true });
    return {
      element: all.element,
      refresh() {
        boxes.forEach((it) => (it.input.checked = present().includes(it.name)));
        all.refresh();
      },
    };
  }
  const input = h("input", {
    type: "text",
    onchange() {
      const texts = input.value.split(",").map((it) => it.trim()).filter(Boolean);
      if (!texts.length) target.reset(path);
      else target.set(path, isNumber ? texts.map((it) => (Number.isFinite(Number(it)) ? Number(it) : it)) : texts);
    },
  });
  const all = row(target, node, path, input, { wide: true });
  return {
    element: all.element,
    refresh() {
      const { value, mixed } = target.value(path);
      input.placeholder = mixed ? "mixed" : `${(Array.isArray(node.fallback) ? node.fallback : []).join(", ") || "separated by commas"}`;
      if (document.activeElement !== input) input.value = Array.isArray(value) ? value.join(", ") : value === undefined ? "" : String(value);
      all.refresh();
    },
  };
}

/** Names with numbers, as weights: "regular: 6, curious: 3". */
function mapField(target, node, path) {
  const input = h("input", {
    type: "text",
    onchange() {
      const pairs = input.value.split(",").map((it) => it.split(":").map((part) => part.trim())).filter(([key]) => key);
      const value = Object.fromEntries(pairs.map(([key, number]) => [key, Number.isFinite(Number(number)) && number ? Number(number) : 1]));
      if (!pairs.length) target.reset(path);
      else if (!sameValue(value, target.value(path).value)) target.set(path, value);
    },
  });
  const all = row(target, node, path, input, { wide: true });
  return {
    element: all.element,
    refresh() {
      const { value } = target.value(path);
      input.placeholder = "name: weight, name: weight";
      if (document.activeElement !== input) {
        input.value = Object.entries(value ?? {}).map(([key, number]) => `${key}: ${number}`).join(", ");
      }
      all.refresh();
    },
  };
}
