import { button, fill, h } from "./dom.js";
import { valueAt } from "./data.js";
import { setOp } from "./changes.js";
import { describe, memberOf, skeleton } from "./schema.js";
import { checkField, choiceField, numberField, textField, tupleField, words } from "./fields.js";
import { mapField, pointsField, textsField } from "./lists.js";

/**
 * Fields of composed values: objects, unions, lists, tables.
 */

/** Returns the field for a schema. */
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
      return noteField(path, "Its settings appear when the simulation is loaded.");
    default:
      return noteField(path, "Edit it in the YAML text.");
  }
}

function noteField(path, text) {
  const element = h("div", { class: "field wide", "data-field": path.join("/") }, h("span", { class: "label" }, words(path.at(-1) ?? "")), h("p", { class: "help shown" }, text));
  return { element, refresh() {} };
}

/** A part that folds; its content is created when it is first unfolded. */
function section(target, node, path, makeBody, extra = null) {
  const body = h("div", { class: "section-body" });
  const badge = h("span", { class: "badge-count", hidden: true });
  const given = h("span", { class: "given", title: "Differs from the default", hidden: true });
  const name = words(path.at(-1) ?? node.title);
  const details = h("details", { class: "section" }, h("summary", { title: node.help }, h("span", { class: "section-name" }, name), given, badge), body);
  const element = h("div", { class: "section-choice", "data-field": path.join("/") }, details, extra);
  let inner = null;
  function unfold() {
    if (!details.open || inner) return;
    inner = makeBody(body);
    inner.refresh();
  }
  details.addEventListener("toggle", unfold);
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

/** The fields of an object, with some first and unknown keys last. */
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
      // Faults are not hidden.
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
  const tags = () => [...new Set([...node.names, ...node.members.map((it) => it.tag)])];
  const select = h("select", {
    "aria-label": words(path.at(-1) ?? "type"),
    onchange() {
      const member = node.members.find((it) => it.tag === select.value);
      const { store, bases } = target;
      const ops = bases.map((base) => {
        const old = valueAt(store.data, [...base, ...path]);
        const kept = Object.entries(old && typeof old === "object" ? old : {}).filter(([name]) => name !== "type" && member?.schema.properties?.[name]);
        return setOp(store.data, [...base, ...path], { type: select.value, ...Object.fromEntries(kept) });
      });
      store.edit(`Choose ${words(select.value)} for ${target.what()}`, ops);
    },
  });
  let shown;
  let inner = null;
  const build = () => {
    const { value } = target.value(path);
    const member = memberOf(node, value ?? node.fallback) ?? (value === undefined ? node.members[0] : null);
    const tag = typeof value === "string" ? value : value?.type ?? member?.tag;
    const names = tags();
    select.replaceChildren(...(names.includes(tag) ? names : [tag ?? "", ...names]).map((it) => h("option", { value: it }, words(it ?? ""))));
    select.value = tag ?? "";
    if (shown === member?.tag && inner) return;
    shown = member?.tag;
    const it = member && describe(root, member.schema);
    if (it?.kind === "object") inner = objectBody(target, root, it, path, body);
    else {
      fill(body, it?.kind === "deferred" ? h("p", { class: "help shown" }, "Its settings appear when the simulation is loaded.") : null);
      inner = { refresh() {} };
    }
  };
  const whole = section(target, node, path, (into) => {
    into.append(body);
    return {
      refresh() {
        build();
        inner.refresh();
      },
    };
  }, select);
  return {
    element: whole.element,
    refresh() {
      build();
      whole.refresh();
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
      const begin = member ? { type: member.tag, ...skeleton(root, describe(root, member.schema)) } : skeleton(root, item);
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
