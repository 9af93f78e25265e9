/**
 * Adds zoom by the wheel and by two fingers to a map.
 * @returns handlers of pointers; each returns whether it is a pinch
 */
export function addWheelAndPinch(store, map, began) {
  const { element } = map;
  /** @type {Map<number, [number, number]>} */
  const fingers = new Map();

  element.addEventListener(
    "wheel",
    (event) => {
      // In a notebook the page scrolls until the map has the focus.
      if (store.embedded && !element.contains(document.activeElement)) return;
      event.preventDefault();
      const pixels = event.deltaMode === 1 ? 16 * event.deltaY : event.deltaY;
      if (event.shiftKey && !event.ctrlKey) map.pan(-pixels, 0);
      else map.zoom(Math.exp(-Math.max(-240, Math.min(240, pixels)) * 0.0022), ...map.pixels(event));
    },
    { passive: false },
  );

  const spread = ([a, b]) => ({
    middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2],
    size: Math.hypot(a[0] - b[0], a[1] - b[1]) || 1,
  });

  return {
    down(event) {
      if (event.pointerType !== "touch") return false;
      fingers.set(event.pointerId, map.pixels(event));
      if (fingers.size === 2) began();
      return fingers.size > 1;
    },
    move(event) {
      if (!fingers.has(event.pointerId)) return false;
      if (fingers.size < 2) {
        fingers.set(event.pointerId, map.pixels(event));
        return false;
      }
      const before = spread([...fingers.values()]);
      fingers.set(event.pointerId, map.pixels(event));
      const now = spread([...fingers.values()]);
      map.pan(now.middle[0] - before.middle[0], now.middle[1] - before.middle[1]);
      map.zoom(now.size / before.size, ...now.middle);
      return true;
    },
    up: (event) => fingers.delete(event.pointerId),
  };
}
