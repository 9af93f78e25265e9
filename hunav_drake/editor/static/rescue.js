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
  // While it is offered, what is kept stays.
  let offered = false;

  const keep = later(200, () => {
    if (offered && !store.dirty) return;
    offered = false;
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

  function offer({ text, time }) {
    offered = true;
    store.tell("ask", {
      question: `There is work on this file from ${new Date(time).toLocaleString()} that was not saved.`,
      yes: "Restore it",
      no: "Discard it",
      again: { do: "text", text },
      never() {
        offered = false;
        keep();
      },
    });
  }

  store.listen("text", () => {
    if (looked !== place()) {
      looked = place();
      const found = kept();
      if (found && !store.dirty && found.text !== store.text) return offer(found);
    }
    return keep();
  });
  store.listen("state", keep);
  // The server may be another one, which knows nothing of the work.
  store.listen("connection", ({ open }) => open && (looked = null));
}
