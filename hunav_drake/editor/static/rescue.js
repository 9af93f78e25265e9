import { later } from "./dom.js";

const PREFIX = "hunav-edit:";
const DAYS = 14;

/**
 * Keeps unsaved text in the browser, by file, and offers it
 * when the file is opened again, as after a crash.
 */
export function keepUnsaved(store) {
  const place = () => PREFIX + (store.filename ?? "");
  let looked = null;
  // Not while it is offered.
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
      // There may be no storage, as in a private window.
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
      question: `There are unsaved changes of this file from ${new Date(time).toLocaleString()}.`,
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
  // The server may be another one, which does not have the changes.
  store.listen("connection", ({ open }) => open && (looked = null));
}
