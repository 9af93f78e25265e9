import { h } from "./dom.js";
import { setOp } from "./changes.js";
import { Target, checkField, choiceField, numberField, textField } from "./fields.js";

/**
 * The ports of a behavior tree, as a form. A behavior is written as its name
 * only, `curious`, or, if a port differs from its default, as a mapping,
 * `{type: curious, distance: 6.0}`.
 */

/** People whose behaviors are treated as mappings. */
class PortTarget extends Target {
  constructor(store, paths, tree) {
    super(store, paths, () => (paths.length === 1 ? tree : `${tree}, ${paths.length} people`));
    this.tree = tree;
  }

  #ports(base) {
    const it = this.store.get([...base, "behavior"]);
    if (!it || typeof it !== "object") return {};
    const { type: _, ...ports } = it;
    return ports;
  }

  #write(label, change) {
    const ops = this.bases.map((base) => {
      const ports = change({ ...this.#ports(base) });
      const value = Object.keys(ports).length ? { type: this.tree, ...ports } : this.tree;
      return setOp(this.store.data, [...base, "behavior"], value);
    });
    this.store.edit(label, ops);
  }

  values([name]) {
    return this.bases.map((base) => this.#ports(base)[name]);
  }

  set([name], value) {
    if (this.values([name]).every((it) => it === value)) return;
    this.#write(`Set ${name} of ${this.what()}`, (ports) => ({ ...ports, [name]: value }));
  }

  reset([name]) {
    if (this.values([name]).every((it) => it === undefined)) return;
    this.#write(`Reset ${name} of ${this.what()}`, ({ [name]: _, ...ports }) => ports);
  }

  faults([name]) {
    return this.bases.flatMap((base) => this.store.faultsAt([...base, "behavior", name]));
  }
}

/** Returns the node of a port, for the forms. */
function nodeOf(port) {
  const schema = port.schema ?? {};
  return {
    kind: port.type,
    schema,
    title: port.name,
    help: port.help,
    unit: schema["x-unit"] ?? "",
    low: schema.minimum ?? schema.exclusiveMinimum,
    high: schema.maximum,
    lowOpen: schema.exclusiveMinimum !== undefined,
    optional: false,
    hasDefault: !port.required,
    fallback: port.default ?? undefined,
    values: schema.enum ?? [],
  };
}

/** Creates the forms of ports, of which one is shown. */
export function makePorts(store) {
  let fields = [];
  return {
    /** Returns the form of the ports of some people's behavior. */
    build(entry, paths) {
      const target = new PortTarget(store, paths, entry.name);
      fields = entry.ports.map((port) => {
        const node = nodeOf(port);
        const path = [port.name];
        if (node.values.length) return choiceField(target, node, path);
        if (port.type === "boolean") return checkField(target, node, path);
        if (port.type === "number" || port.type === "integer") return numberField(target, node, path);
        return textField(target, node, path);
      });
      if (!fields.length) return h("p", { class: "help shown" }, "It has no ports to set.");
      return h("div", { class: "ports" }, h("h3", null, "Its numbers"), fields.map((it) => it.element));
    },
    refresh: () => fields.forEach((it) => it.refresh()),
  };
}
