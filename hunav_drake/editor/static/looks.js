/**
 * The look of behaviors: a color of Okabe and Ito, and a letter for
 * color-blind people. Names and colors are those of the catalog;
 * before it arrives, those of the package.
 */
const KNOWN = [
  ["regular", "#0072b2"],
  ["impassive", "#d55e00"],
  ["surprised", "#009e73"],
  ["scared", "#cc79a7"],
  ["curious", "#e69f00"],
  ["threatening", "#56b4e9"],
  ["distracted", "#4d4d4d"],
  ["cooperative", "#7f7f7f"],
];

/** Black is invisible on a dark floor. */
const DARK = { "#000000": "#4d4d4d" };

/** Returns the color of one of several robots; nothing for a single one. */
export function robotColor(catalog, index, count) {
  const colors = catalog.robot_colors ?? [];
  return (count > 1 && colors[index % colors.length]) || "";
}

/** Sets the color of the drawing of a robot, if it has one of its own. */
export function paintRobot(element, color) {
  for (const name of ["--robot", "--on-robot"]) element.style.removeProperty(name);
  if (!color) return;
  element.style.setProperty("--robot", color);
  element.style.setProperty("--on-robot", "#ffffff");
}

/** Returns {color, letter} of a behavior; two letters if one is ambiguous. */
export function lookOf(catalog, name) {
  const all = catalog.behaviors?.length ? catalog.behaviors.map((it) => [it.name, it.color]) : KNOWN;
  const color = all.find(([other]) => other === name)?.[1] ?? "#7f7f7f";
  const first = name.slice(0, 1).toUpperCase() || "?";
  const shared = all.some(([other]) => other !== name && other[0]?.toUpperCase() === first);
  return { color: DARK[color.toLowerCase()] ?? color, letter: shared ? first + name.slice(1, 2) : first };
}
