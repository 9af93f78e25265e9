import { startEditor } from "./editor.js";
import { keepUnsaved } from "./rescue.js";

/**
 * The host of a page: a WebSocket, which reconnects.
 */
function connect(root) {
  const listeners = [];
  const waiting = [];
  let socket = null;
  let store = null;
  let tries = 0;

  const host = {
    send(message) {
      const text = JSON.stringify(message);
      if (socket && socket.readyState === WebSocket.OPEN) socket.send(text);
      else if (!store) waiting.push(text);
    },
    on: (f) => listeners.push(f),
  };

  function open() {
    const url = new URL("socket", location.href);
    url.protocol = "ws:";
    url.search = "";
    socket = new WebSocket(url);
    socket.onopen = () => {
      tries = 0;
      store.tell("connection", { open: true });
      waiting.splice(0).forEach((text) => socket.send(text));
      store.restart();
    };
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      listeners.forEach((f) => f(message));
    };
    socket.onclose = () => {
      store.tell("connection", { open: false });
      tries += 1;
      setTimeout(open, Math.min(5000, 300 * tries));
    };
  }

  store = startEditor(root, host);
  keepUnsaved(store);
  store.listen("state", () => {
    document.title = `${store.dirty ? "• " : ""}${store.name || "new scenario"} – hunav edit`;
  });
  addEventListener("beforeunload", (event) => {
    if (store.dirty) event.preventDefault();
  });
  open();
}

connect(document.getElementById("editor"));
