import { button, fill, h, icon } from "./dom.js";

/** The speeds relative to real time. */
const PACES = [1, 2, 5, 10];

/** Creates a time slider with play and pause. */
export function makePlayer(move) {
  let times = [0];
  let playing = 0;
  let before = 0;
  const slider = h("input", { type: "range", min: 0, max: 1, step: 0.05, value: 0, "aria-label": "Time of the run in seconds" });
  const clock = h("span", { class: "clock" });
  const play = button("run", "Play", () => (playing ? pause() : begin()), { class: "button square play" });
  const pace = h("select", { "aria-label": "Pace" }, PACES.map((n) => h("option", { value: n, selected: n === 5 }, `${n} ×`)));
  const element = h("div", { class: "player" }, play, slider, clock, pace);

  const time = () => Number(slider.value);
  function show() {
    clock.textContent = `${time().toFixed(1)} / ${times.at(-1).toFixed(1)} s`;
    slider.setAttribute("aria-valuetext", `${time().toFixed(1)} seconds`);
    move(time());
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
  slider.addEventListener("input", () => {
    pause();
    show();
  });

  return {
    element,
    pause,
    get time() {
      return time();
    },
    /** Sets the times of a run, and moves to its end. */
    load(given) {
      pause();
      times = given;
      slider.max = String(times.at(-1));
      // Fine enough for the last time, which is not a multiple of the step.
      slider.step = "any";
      slider.value = String(times.at(-1));
      show();
    },
  };
}
