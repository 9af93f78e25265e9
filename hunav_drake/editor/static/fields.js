import { button, h, later } from "./dom.js";
import { isWithin, sameValue, samePath, valueAt } from "./data.js";
import { resetOp, setOp } from "./changes.js";
import { rangeOf } from "./schema.js";

/**
 * One value in a form, of one or of several parts.
 *
 * A field is {element, refresh}; it is created once, so that typed text and
 * the caret stay, and `refresh` shows the current value.
 */

/** Returns the text of a fault, with its remedy. */
export function sentence({ message, remedy }) {
  return remedy && !message.includes(remedy) ? `${message}: ${remedy}` : message;
}

/** Returns the label of a field: "desired speed". */
export const words = (name) => String(name).replace(/_/g, " ");

/** The subject of a form: parts at `bases`, all with the same schema. */
export class Target {
  constructor(store, bases, what) {
    this.store = store;
    this.bases = bases;
    this.what = what;
  }

  values(path) {
    return this.bases.map((base) => valueAt(this.store.data, [...base, ...path]));
  }

  /** The value, undefined if it is missing, or `mixed`. */
  value(path) {
    const [first, ...others] = this.values(path);
    return others.every((it) => sameValue(it, first)) ? { value: first, mixed: false } : { value: undefined, mixed: true };
  }

  set(path, value, label = `Set ${words(named(path))} of ${this.what()}`) {
    const changed = this.bases.filter((base) => !sameValue(valueAt(this.store.data, [...base, ...path]), value));
    this.store.edit(label, changed.map((base) => setOp(this.store.data, [...base, ...path], value)));
  }

  reset(path) {
    const set = this.bases.filter((base) => valueAt(this.store.data, [...base, ...path]) !== undefined);
    this.store.edit(`Reset ${words(named(path))} of ${this.what()}`, set.map((base) => resetOp(this.store.data, [...base, ...path])));
  }

  /** The faults at a path; at those below, too, if `deep`. */
  faults(path, deep) {
    return this.store.faults.filter((fault) =>
      this.bases.some((base) => {
        const here = [...base, ...path];
        return deep ? isWithin(fault.path, here) : samePath(fault.path, here);
      }),
    );
  }
}

function named(path) {
  return path.filter((it) => typeof it === "string").at(-1) ?? "value";
}

let lastId = 0;

/** A row: label, control, reset arrow, help and faults. */
export function row(target, node, path, control, { deep = true, wide = false, input = control } = {}) {
  const id = `hunav-field-${++lastId}`;
  const name = words(path.at(-1) ?? node.title);
  const range = rangeOf(node);
  const help = [node.help, range && `Range: ${range}.`].filter(Boolean).join(" ");
  const reset = button("reset", `Reset ${name} to its default`, () => target.reset(path), { class: "button square reset" });
  const note = h("p", { class: "help", id: `${id}-help` }, help);
  const fault = h("p", { class: "field-fault", id: `${id}-fault`, hidden: true });
  if (input.tagName !== "DIV") input.id = id;
  else input.setAttribute("aria-label", name);
  input.setAttribute("aria-describedby", `${id}-help ${id}-fault`);
  const label = h(input.tagName === "DIV" ? "span" : "label", { class: "label", title: help, for: id }, name);
  const element = h("div", { class: wide ? "field wide" : "field", "data-field": path.join("/") }, label, h("div", { class: "control" }, control, reset), note, fault);
  return {
    element,
    refresh() {
      const given = target.values(path).some((it) => it !== undefined);
      element.classList.toggle("is-default", !given);
      reset.hidden = !given || !(node.hasDefault || node.optional);
      const faults = target.faults(path, deep);
      fault.hidden = !faults.length;
      const text = faults.map(sentence).join("\n");
      if (fault.textContent !== text) fault.textContent = text;
      if (faults.length) input.setAttribute("aria-invalid", "true");
      else input.removeAttribute("aria-invalid");
      element.classList.toggle("is-faulty", faults.length > 0);
    },
  };
}

/** Returns the number of a text, also in degrees, or null. */
function parseNumber(text, isAngle = false) {
  const found = /^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(deg|°|pi|π)?\s*$/i.exec(text);
  if (!found) return null;
  const value = Number(found[1]);
  if (!found[2]) return value;
  if (!isAngle) return null;
  return Math.round(value * (/deg|°/i.test(found[2]) ? Math.PI / 180 : Math.PI) * 1e6) / 1e6;
}

const shownNumber = (it) => (typeof it === "number" ? String(Math.round(it * 1e6) / 1e6) : it === undefined || it === null ? "" : String(it));

/** Returns the short text of a number. */
export const toMillimeters = (it) => (typeof it === "number" ? Math.round(it * 1e3) / 1e3 : it);

const STEPS = { m: 0.05, "m/s": 0.1, rad: Math.PI / 36, s: 0.5 };

/** An input for a number; `read` and `write` are its value in the data. */
export function numberInput(node, { read, write, clear, label = "" }) {
  const isAngle = node.unit === "rad" || label === "yaw";
  const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", spellcheck: "false", class: "number" });
  if (label) input.setAttribute("aria-label", label);
  const commit = later(300, () => send());
  function send() {
    commit.stop();
    const text = input.value.trim();
    if (text === "") {
      clear?.();
      return;
    }
    const value = parseNumber(text, isAngle);
    input.classList.toggle("unread", value === null);
    if (value === null) input.setCustomValidity("a number");
    if (value === null || (node.kind === "integer" && !Number.isInteger(value))) return;
    write(value);
  }
  input.addEventListener("input", () => commit());
  input.addEventListener("change", () => {
    send();
    refresh(true);
  });
  input.addEventListener("keydown", (event) => {
    const sign = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (event.key === "Enter") send();
    if (!sign || event.altKey) return;
    event.preventDefault();
    const step = node.kind === "integer" ? 1 : isAngle ? STEPS.rad : STEPS[node.unit] ?? 0.1;
    const value = (parseNumber(input.value, isAngle) ?? node.fallback ?? 0) + sign * step * (event.shiftKey ? 10 : 1);
    write(Math.round(value * 1e4) / 1e4);
    refresh(true);
  });
  function refresh(always = false) {
    const { value, mixed, fallback } = read();
    const text = shownNumber(value);
    input.placeholder = mixed ? "mixed" : shownNumber(fallback);
    if (!always && document.activeElement === input && document.hasFocus()) {
      // Text that is being typed stays, unless the value has changed.
      return;
    }
    if (input.value !== text && !(always && input.classList.contains("unread") && input.value)) input.value = text;
  }
  return { input, refresh };
}

export function numberField(target, node, path) {
  const parts = numberInput(node, {
    read: () => ({ ...target.value(path), fallback: node.fallback }),
    write: (value) => target.set(path, value),
    clear: node.hasDefault || node.optional ? () => target.reset(path) : null,
  });
  const unit = node.unit ? h("span", { class: "unit" }, node.unit) : null;
  const all = row(target, node, path, h("span", { class: "with-unit" }, parts.input, unit), { input: parts.input });
  return {
    element: all.element,
    refresh() {
      parts.refresh();
      all.refresh();
    },
  };
}

export function textField(target, node, path) {
  const input = node.long ? h("textarea", { rows: 3 }) : h("input", { type: "text", autocomplete: "off", maxlength: node.schema.maxLength });
  const commit = later(300, () => send());
  // At once where another field is next: a refresh would undo what is typed.
  function send() {
    commit.stop();
    if (input.value === "" && (node.hasDefault || node.optional)) target.reset(path);
    else target.set(path, input.value);
  }
  input.addEventListener("input", () => commit());
  input.addEventListener("change", send);
  const all = row(target, node, path, input, { wide: node.long });
  return {
    element: all.element,
    refresh() {
      const { value, mixed } = target.value(path);
      input.placeholder = mixed ? "mixed" : String(node.fallback ?? "");
      if (document.activeElement !== input) input.value = value ?? "";
      all.refresh();
    },
  };
}

/** A list box for an enum, or for an optional boolean. */
export function choiceField(target, node, path, options = null) {
  const list = () => options?.() ?? node.values.map((it) => [it, words(it)]);
  const select = h("select", {
    onchange() {
      const found = list().find(([value]) => String(value) === select.value);
      if (found) target.set(path, found[0]);
      else target.reset(path);
    },
  });
  const all = row(target, node, path, select);
  return {
    element: all.element,
    refresh() {
      const { value, mixed } = target.value(path);
      const known = list();
      const rows = known.map(([it, text]) => h("option", { value: String(it) }, text));
      if (value !== undefined && value !== null && !known.some(([it]) => it === value)) {
        rows.push(h("option", { value: String(value) }, typeof value === "object" ? "(own)" : String(value)));
      }
      const fallback = known.find(([it]) => it === node.fallback)?.[1] ?? (node.optional ? "not set" : typeof node.fallback === "string" ? words(node.fallback) : "");
      const first = mixed ? "mixed" : fallback ? `${fallback} (default)` : "choose …";
      const unset = value === undefined || value === null;
      if (mixed || unset || node.hasDefault || node.optional) rows.unshift(h("option", { value: "" }, first));
      select.replaceChildren(...rows);
      select.value = unset ? "" : String(value);
      all.refresh();
    },
  };
}

export function checkField(target, node, path) {
  const input = h("input", { type: "checkbox", onchange: () => target.set(path, input.checked) });
  const all = row(target, node, path, input);
  return {
    element: all.element,
    refresh() {
      const { value, mixed } = target.value(path);
      input.checked = (value ?? node.fallback) === true;
      input.indeterminate = mixed;
      all.refresh();
    },
  };
}

export function tupleField(target, node, path) {
  const names = node.labels.length ? node.labels : { 2: ["x", "y"], 3: ["x", "y", "yaw"], 4: ["x min", "y min", "x max", "y max"] }[node.items.length] ?? [];
  const value = () => target.value(path).value ?? node.fallback;
  const parts = node.items.map((item, i) => {
    const label = names[i] ?? String(i + 1);
    return {
      label,
      unit: item.unit,
      ...numberInput(item, {
        label,
        read: () => {
          const all = target.values(path).map((it) => it?.[i]);
          const mixed = all.some((it) => it !== all[0]);
          return { value: mixed ? undefined : toMillimeters(all[0]), mixed, fallback: node.fallback?.[i] };
        },
        write(number) {
          const { store, bases } = target;
          const ops = bases.map((base) => {
            const old = valueAt(store.data, [...base, ...path]) ?? value() ?? node.items.map(() => 0);
            return setOp(store.data, [...base, ...path], node.items.map((_, j) => (j === i ? number : old[j] ?? 0)));
          });
          store.edit(`Set ${words(named(path))} of ${target.what()}`, ops);
        },
      }),
    };
  });
  const control = h(
    "div",
    { class: "tuple", role: "group" },
    parts.map(({ label, input, unit }) => h("label", { class: "tuple-part" }, h("span", { class: "tuple-label" }, label), h("span", { class: "with-unit" }, input, unit ? h("span", { class: "unit" }, unit) : null))),
  );
  const all = row(target, node, path, control, { wide: true });
  return {
    element: all.element,
    refresh() {
      parts.forEach((it) => it.refresh());
      all.refresh();
    },
  };
}
