import { button, fill, h, icon } from "./dom.js";

/** The speeds relative to real time. */
const PACES = [1, 2, 5, 10];

/** How near to an event its text is shown, in seconds. */
const SOON = 0.15;

/** Creates a time slider with play and pause. */
export function makePlayer(move) {
  let times = [0];
  let playing = 0;
  let before = 0;
  const slider = h("input", { type: "range", min: 0, max: 1, step: 0.05, value: 0, "aria-label": "Time of the run in seconds" });
  const clock = h("span", { class: "clock" });
  const play = button("run", "Play", () => (playing ? pause() : begin()), { class: "button square play" });
  const pace = h("select", { "aria-label": "Pace" }, PACES.map((n) => h("option", { value: n, selected: n === 5 }, `${n} ×`)));
  const marks = h("div", { class: "marks" });
  const note = h("span", { class: "event-note", "aria-live": "polite" });
  const earlier = button("up", "Event before (Alt+Left)", () => jump(-1), { class: "button square event-before" });
  const after = button("up", "Next event (Alt+Right)", () => jump(1), { class: "button square event-after" });
  const track = h("div", { class: "track" }, slider, marks);
  const element = h("div", { class: "player" }, play, earlier, track, after, clock, pace);
  let events = [];

  const time = () => Number(slider.value);
  function show() {
    clock.textContent = `${time().toFixed(1)} / ${times.at(-1).toFixed(1)} s`;
    slider.setAttribute("aria-valuetext", `${time().toFixed(1)} seconds`);
    const now = events.filter((it) => it.begin - SOON <= time() && time() <= it.end + SOON).map((it) => it.text);
    const text = now.length > 3 ? `${now.slice(0, 3).join(", ")} and ${now.length - 3} more` : now.join(", ");
    if (note.textContent !== text) note.textContent = text;
    move(time());
  }
  /** Goes to a time. */
  function go(to) {
    pause();
    slider.value = String(to);
    show();
  }
  /** Goes to the next event, or to the one before. */
  function jump(way) {
    const begins = [...new Set(events.map((it) => it.begin))];
    const to = way > 0 ? begins.find((it) => it > time() + SOON) : begins.findLast((it) => it < time() - SOON);
    if (to !== undefined) go(to);
  }
  function pause() {
    cancelAnimationFrame(playing);
    playing = 0;
    play.title = "Play";
    play.setAttribute("aria-label", "Play");
    fill(play, icon("run"));
  }
  function begin() {
    if (time() >= times.at(-1) - 0.01) slider.value = 0;
    play.title = "Pause";
    play.setAttribute("aria-label", "Pause");
    fill(play, icon("stop"));
    before = performance.now();
    const step = (now) => {
      const next = time() + (Math.max(now - before, 0) / 1000) * Number(pace.value);
      before = now;
      slider.value = Math.min(next, times.at(-1));
      show();
      if (next >= times.at(-1)) pause();
      else playing = requestAnimationFrame(step);
    };
    playing = requestAnimationFrame(step);
  }
  slider.addEventListener("keydown", (event) => {
    const way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!way || !event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    jump(way);
  });
  slider.addEventListener("input", () => {
    pause();
    show();
  });

  return {
    element,
    /** What happens at the shown time. */
    note,
    pause,
    get time() {
      return time();
    },
    /** Sets the times of a run with its events, and moves to its end. */
    load(given, told = []) {
      pause();
      times = given;
      events = told;
      const whole = Math.max(times.at(-1), 0.01);
      fill(
        marks,
        events.map((it) => {
          const mark = h("span", { class: `mark-of is-${it.kind}`, title: `${it.begin.toFixed(1)} s: ${it.text}`, onclick: () => go(it.begin) });
          mark.style.left = `${(100 * it.begin) / whole}%`;
          mark.style.width = `${(100 * (it.end - it.begin)) / whole}%`;
          return mark;
        }),
      );
      for (const it of [earlier, after]) it.disabled = !events.length;
      slider.max = String(times.at(-1));
      // Fine enough for the last time, which is not a multiple of the step.
      slider.step = "any";
      slider.value = String(times.at(-1));
      show();
    },
  };
}
