import { later } from "./dom.js";

const PREFIX = "hunav-edit:";
const DAYS = 14;

/**
 * Keeps text that is not saved in the browser, by its file, and offers it
 * when the file is opened again without it, as after a crash.
 */
export function keepUnsaved(store) {
  const place = () => PREFIX + (store.filename ?? "");
  let looked = null;

  const keep = later(200, () => {
    try {
      if (store.dirty) {
        localStorage.setItem(place(), JSON.stringify({ text: store.text, time: Date.now() }));
      } else {
        localStorage.removeItem(place());
      }
    } catch {
      // Without storage, as in a private window, there is nothing to keep.
    }
  });

  function kept() {
    try {
      const found = JSON.parse(localStorage.getItem(place()) ?? "null");
      const old = found && Date.now() - found.time > DAYS * 86400e3;
      return old ? null : found;
    } catch {
      return null;
    }
  }

  store.listen("text", () => {
    if (looked !== place()) {
      looked = place();
      const found = kept();
      if (found && !store.dirty && found.text !== store.text) {
        const time = new Date(found.time).toLocaleString();
        store.tell("ask", {
          question: `There is work on this file from ${time} that was not saved.`,
          yes: "Restore it",
          no: "Discard it",
          again: { do: "text", text: found.text },
          never: keep,
        });
        return;
      }
    }
    keep();
  });
  store.listen("state", keep);
}
