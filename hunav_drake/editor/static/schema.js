import { valueAt } from "./data.js";

/**
 * The nodes of forms, from a JSON schema.
 * @typedef {{kind: string, optional: boolean, help: string, title: string,
 *   unit: string, low?: number, high?: number, lowOpen?: boolean,
 *   fallback?: any, hasDefault: boolean, schema: any, [more: string]: any}} Node
 */

function resolved(root, node) {
  let it = node ?? {};
  for (let n = 0; it.$ref && n < 20; n++) {
    const { $ref, ...rest } = it;
    it = { ...(root.$defs?.[$ref.split("/").at(-1)] ?? {}), ...rest };
  }
  return it;
}

const isNull = (it) => it.type === "null";
const isOwn = (it) => it.pattern === "^[^:]+:[^:]+$" || Object.values(it.properties ?? {}).some((p) => p?.pattern === "^[^:]+:[^:]+$");

/** Returns the members of a union, which have different `type`. */
function unionOf(root, options) {
  const members = [];
  const names = [];
  for (const option of options) {
    const it = resolved(root, option);
    if (isOwn(it)) continue;
    if (it.enum) names.push(...it.enum);
    const tag = it.properties?.type?.const;
    if (tag !== undefined) members.push({ tag, schema: it });
  }
  return { members, names };
}

/**
 * Returns the node of a schema.
 * @param {any} root The whole schema, for references.
 * @param {any} schema
 * @returns {Node}
 */
export function describe(root, schema) {
  let it = resolved(root, schema);
  let optional = false;
  if (it.anyOf) {
    const { anyOf, ...rest } = it;
    const others = anyOf.filter((option) => !isNull(resolved(root, option)));
    optional = others.length < anyOf.length;
    if (others.length === 1) it = { ...resolved(root, others[0]), ...rest };
    else it = { ...rest, oneOf: others };
  }
  const node = {
    schema: it,
    optional,
    help: it.description ?? "",
    title: it.title ?? "",
    unit: it["x-unit"] ?? "",
    hasDefault: "default" in it,
    fallback: it.default,
    low: it.minimum ?? it.exclusiveMinimum ?? it.ge,
    high: it.maximum ?? it.exclusiveMaximum ?? it.le,
    lowOpen: "exclusiveMinimum" in it,
    kind: "any",
  };
  if (it["x-deferred"]) return { ...node, kind: "deferred" };
  if (it.oneOf) {
    const union = unionOf(root, it.oneOf);
    if (union.members.length) return { ...node, kind: "union", ...union };
    if (union.names.length) return { ...node, kind: "enum", values: union.names };
    const object = it.oneOf.map((option) => resolved(root, option)).find((option) => option.properties?.type);
    return { ...node, kind: object ? "behavior" : "any" };
  }
  if (it.enum) return { ...node, kind: "enum", values: it.enum };
  if (it.const !== undefined) return { ...node, kind: "const" };
  if (it.type === "number" || it.type === "integer") return { ...node, kind: it.type };
  if (it.type === "boolean") return { ...node, kind: "boolean" };
  if (it.type === "string") return { ...node, kind: "text", long: it.maxLength === undefined };
  if (it.type === "array") {
    if (it.prefixItems) {
      return { ...node, kind: "tuple", items: it.prefixItems.map((item) => describe(root, item)), labels: it["x-labels"] ?? [] };
    }
    const item = describe(root, it.items ?? {});
    const isPoints = item.kind === "tuple" && item.items.length < 4 && item.items.every((part) => part.kind === "number");
    return { ...node, kind: isPoints ? "points" : "list", item };
  }
  if (it.properties && Object.keys(it.properties).length) return { ...node, kind: "object", properties: it.properties, required: it.required ?? it.else?.required ?? [] };
  if (it.additionalProperties && it.additionalProperties !== true) {
    return { ...node, kind: "map", item: describe(root, it.additionalProperties) };
  }
  return node;
}

/** Returns the member of a union of a value, or null. */
export function memberOf(node, value) {
  const name = typeof value === "string" ? value : value?.type;
  const isUnnamed = name === undefined && value && typeof value === "object";
  const is = ({ tag, schema }) => (isUnnamed ? !schema.required?.includes("type") : tag === name);
  return node.members.find(is) ?? null;
}

/** Returns the node at a path, for the choices in the data. */
export function nodeAt(root, data, path) {
  let node = describe(root, root);
  for (let i = 0; i < path.length; i++) {
    const value = valueAt(data, path.slice(0, i));
    if (node.kind === "union") {
      const member = memberOf(node, value) ?? memberOf(node, node.fallback) ?? node.members[0];
      node = describe(root, member?.schema);
    }
    if (node.kind === "object") node = describe(root, node.properties[path[i]]);
    else if (node.kind === "list" || node.kind === "map") node = node.item;
    else if (node.kind === "points") node = node.item;
    else if (node.kind === "tuple") node = node.items[path[i]] ?? describe(root, {});
    else return describe(root, {});
  }
  return node;
}

/** Returns the members of the union at a path. */
export function membersOf(root, path) {
  return nodeAt(root, {}, path).members ?? [];
}

/** Returns the defaults of the properties of an object's schema. */
export function defaultsOf(schema) {
  const entries = Object.entries(schema.properties ?? {}).filter(([, it]) => "default" in it);
  return Object.fromEntries(entries.map(([key, it]) => [key, it.default]));
}

/** Returns an initial value, with required keys only. */
export function skeleton(root, node) {
  switch (node.kind) {
    case "union": {
      const { tag, schema } = node.members[0];
      return { type: tag, ...skeleton(root, { ...describe(root, schema), kind: "object" }) };
    }
    case "object": {
      const result = {};
      for (const name of node.required ?? []) {
        const it = describe(root, node.properties[name]);
        if (it.kind !== "const") result[name] = skeleton(root, it);
      }
      // Exactly one of several keys, as in an area.
      if (node.properties?.rectangle && node.properties?.point) result.rectangle = [0, 0, 2, 2];
      return result;
    }
    case "number":
    case "integer":
      return node.hasDefault && node.fallback !== null ? node.fallback : Math.max(node.lowOpen ? 1 : node.low ?? 0, 1);
    case "boolean":
      return node.fallback ?? false;
    case "enum":
      return node.values[0];
    case "tuple":
      return node.items.map((it) => skeleton(root, { ...it, hasDefault: true, fallback: it.low > 0 || it.lowOpen ? 1 : 0 }));
    case "list":
      return node.schema.minItems ? [skeleton(root, node.item)] : [];
    case "points":
      return [];
    case "map":
      return {};
    default:
      return "";
  }
}

/** Returns the range of a number in words: "0 to 10 m/s". */
export function rangeOf({ low, high, lowOpen, unit }) {
  const hasLow = low !== undefined && low > -1e5;
  const hasHigh = high !== undefined && high < 1e5;
  const tail = unit ? ` ${unit}` : "";
  if (hasLow && hasHigh) return `${lowOpen ? "above " : ""}${low} to ${high}${tail}`;
  if (hasLow) return lowOpen && low === 0 ? `above 0${tail}` : `at least ${low}${tail}`;
  return hasHigh ? `at most ${high}${tail}` : "";
}
