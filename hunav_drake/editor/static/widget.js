/**
 * The editor in a notebook. A widget is one module, so the others are
 * texts, each after its imports, which get their own addresses here.
 */

const IMPORT = /from "\.\/([\w-]+\.js)"/g;

function load(modules) {
  const addresses = new Map();
  for (const [name, text] of modules) {
    const code = text.replace(IMPORT, (_, other) => `from "${addresses.get(other)}"`);
    addresses.set(name, URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
  }
  return import(addresses.get("editor.js"));
}

/** Follows the colors of JupyterLab or VS Code; else those of the system. */
function followTheme(root) {
  const { body } = document;
  const show = () => {
    const light = body.dataset.jpThemeLight ?? body.dataset.vscodeThemeKind;
    const isDark = light === "false" || /dark|high-contrast$/.test(light ?? "");
    root.style.colorScheme = light === undefined ? "" : isDark ? "dark" : "light";
  };
  show();
  const observer = new MutationObserver(show);
  observer.observe(body, { attributes: true });
  return () => observer.disconnect();
}

/** Shows a file of a run, without access to the notebook. */
function showFile(root, name, text) {
  if (name.endsWith(".csv")) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    return;
  }
  const dialog = document.createElement("dialog");
  dialog.className = "dialog result-dialog";
  const close = document.createElement("button");
  close.type = "button";
  close.className = "button";
  close.textContent = "Close";
  close.addEventListener("click", () => dialog.close());
  const frame = document.createElement("iframe");
  frame.title = name.replace(".html", "");
  frame.setAttribute("sandbox", "allow-scripts");
  frame.srcdoc = text;
  dialog.append(close, frame);
  dialog.addEventListener("close", () => dialog.remove());
  root.append(dialog);
  dialog.showModal();
}

async function render({ model, el }) {
  const { startEditor } = await load(model.get("_modules"));
  const root = document.createElement("div");
  root.style.height = `${model.get("_height")}px`;
  // JupyterLab's Lumino ignores keys inside.
  root.setAttribute("data-lm-suppress-shortcuts", "true");
  el.append(root);
  const listeners = [];
  const take = (message, buffers) => {
    if (message.kind === "result_file") {
      showFile(root, message.name, new TextDecoder().decode(buffers[0]));
    } else {
      for (const f of listeners) f(message);
    }
  };
  const host = {
    send: (message) => model.send(message),
    on: (f) => listeners.push(f),
  };
  const openResult = (run, name) => model.send({ do: "result_file", run, name });
  const store = startEditor(root, host, { leftFolded: true, embedded: true, openResult });
  model.on("msg:custom", take);
  store.restart();
  const unfollow = followTheme(root);
  return () => {
    model.off("msg:custom", take);
    unfollow();
  };
}

export default { render };
