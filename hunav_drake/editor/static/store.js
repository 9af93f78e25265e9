import { COHORTS } from "./things.js";
import { applied, isWithin, samePath, sameValue, valueAt } from "./data.js";

/**
 * The state of the session for all panels, and its changes.
 *
 * An edit shows at once: the data are those confirmed by Python, with the
 * pending operations. Python answers one edit after another,
 * so an answer always has the revision of its edit.
 */

/**
 * Creates the store.
 * @param {{send: function(Object): void, on: function(function(Object): void): void}} host
 */
export function makeStore(host) {
  /** @type {Map<string, Set<function(any): void>>} */
  const listeners = new Map();
  // Ids are unique among all pages of the session.
  let lastId = Math.floor(Math.random() * 2 ** 30) * 2 ** 20;
  let confirmed = {};
  let confirmedFaults = [];
  let confirmedOutlines = {};
  let queue = [];
  let waiting = null;
  let textRevision = null;
  let nextPreview = null;
  let previewId = null;

  const store = {
    data: {},
    outlines: {},
    faults: [],
    catalog: { schema: {}, defaults: {}, behaviors: [], planners: [], models: [], robots: [], metrics: [], templates: [], examples: [], furniture: [], ready: false },
    drawn: [],
    selection: [],
    text: "",
    places: [],
    revision: 0,
    undo: null,
    redo: null,
    dirty: false,
    readable: true,
    started: false,
    name: "",
    filename: null,
    worker: { status: "starting", message: "" },

    /** Calls f with each message of a kind, or when the selection changes. */
    listen(kind, f) {
      if (!listeners.has(kind)) listeners.set(kind, new Set());
      listeners.get(kind).add(f);
      return () => listeners.get(kind).delete(f);
    },

    /** Calls the listeners of a kind. */
    tell(kind, message = {}) {
      for (const f of [...(listeners.get(kind) ?? [])]) f(message);
    },

    /** Sends a message at once, and returns its id. */
    send(message) {
      const id = ++lastId;
      host.send({ ...message, id });
      return id;
    },

    /** Sends a message that changes the session, after the edits before it. */
    ask(message, ops = []) {
      queue.push({ message, ops });
      next();
      mark();
    },

    /** Changes the scenario by operations: one step with a name. */
    edit(label, ops, outlines = null) {
      if (!ops.length) return;
      if (!store.readable) {
        store.say("The text cannot be read; fix it first, or undo.");
        return;
      }
      nextPreview = null;
      previewId = null;
      store.ask({ do: "edit", label, ops }, ops);
      show(outlines);
    },

    /** Has operations checked without applying them; null ends it. */
    preview(ops) {
      if (!store.readable) return;
      nextPreview = ops;
      if (ops === null) {
        previewId = null;
        setFaults(confirmedFaults);
      } else if (previewId === null) {
        sendPreview();
      }
    },

    undoStep: () => store.ask({ do: "undo" }),
    redoStep: () => store.ask({ do: "redo" }),

    /** Selects parts by their paths. */
    select(paths) {
      const old = store.selection;
      if (old.length === paths.length && old.every((it, i) => samePath(it, paths[i]))) return;
      store.selection = paths;
      store.tell("selection");
    },

    isSelected: (path) => store.selection.some((it) => samePath(it, path)),
    get: (path) => valueAt(store.data, path),

    /** Returns the faults at a path and below it. */
    faultsAt: (path) => store.faults.filter((fault) => isWithin(fault.path, path)),

    /** Shows a line of text for a while, also to screen readers. */
    say: (message, error = true) => store.tell("say", { message, error }),
  };

  /** Writes the shown revision on the page; none while edits are pending. */
  function mark() {
    if (store.root) store.root.dataset.revision = queue.length || textRevision !== store.revision ? "" : String(store.revision);
  }

  function next() {
    if (waiting || !queue.length) return;
    waiting = queue[0];
    waiting.id = ++lastId;
    host.send({ ...waiting.message, id: waiting.id, base: store.revision });
  }

  function sendPreview() {
    if (nextPreview === null) return;
    previewId = store.send({ do: "preview", base: store.revision, ops: nextPreview });
    nextPreview = null;
    // One at a time, and at most one per 100 ms.
    const sent = performance.now();
    sendPreview.done = () => {
      previewId = null;
      const rest = Math.max(0, 100 - (performance.now() - sent));
      setTimeout(() => previewId === null && nextPreview !== null && sendPreview(), rest);
    };
  }

  function show(outlines = null) {
    const ops = queue.flatMap((it) => it.ops);
    store.data = ops.length ? applied(confirmed, ops) : confirmed;
    if (outlines) store.outlines = outlines;
    const kept = store.selection.filter((it) => valueAt(store.data, it) !== undefined);
    const lost = kept.length !== store.selection.length;
    if (lost) store.selection = kept;
    store.tell("data");
    if (lost) store.tell("selection");
  }

  function setFaults(faults) {
    if (sameValue(faults, store.faults)) return;
    store.faults = faults;
    store.tell("faults");
  }

  function answered(message) {
    // A preview for an earlier revision, or an invalid one.
    if (previewId !== null && message.id === previewId) sendPreview.done();
    if (!waiting || message.id !== waiting.id) return;
    waiting = null;
    queue.shift();
  }

  const take = {
    state(message) {
      for (const [path, value] of message.changes) {
        confirmed = path.length ? applied(confirmed, [["set", path, value]]) : value ?? {};
      }
      for (const name of ["revision", "undo", "redo", "dirty", "name", "filename", "readable"]) {
        if (name in message) store[name] = message[name];
      }
      store.started = true;
      if (message.outlines) confirmedOutlines = whole(message.outlines);
      // Older than the shown data, unless nothing is pending.
      show(queue.length ? null : confirmedOutlines);
      store.tell("state", message);
    },
    faults(message) {
      if (message.preview !== undefined && message.preview !== null) {
        if (message.preview !== previewId) return;
        setFaults(message.faults);
        sendPreview.done();
        return;
      }
      confirmedFaults = message.faults;
      if (previewId === null) setFaults(confirmedFaults);
    },
    text(message) {
      store.text = message.text ?? patched(store.text, message.patches ?? []);
      store.places = message.places ?? store.places;
      textRevision = message.revision;
      store.tell("text", message);
    },
    catalog(message) {
      const { kind: _, id: __, ...rest } = message;
      store.catalog = { ...store.catalog, ...rest };
      store.tell("catalog", message);
    },
    drawn({ people, seed }) {
      // The drawing holds as long as its cohort is the same.
      store.drawn = people.map((it) => ({ ...it, seed, source: valueAt(store.data, [...COHORTS, it.cohort]) }));
      store.tell("drawn");
    },
    worker(message) {
      store.worker = message;
      store.tell("worker", message);
    },
    ask(message) {
      store.tell("ask", message);
    },
  };

  host.on((message) => {
    const { kind } = message;
    // The answer of a preview, not of an edit.
    if (kind === "state" || kind === "error" || kind === "ask" || kind === "saved" || kind === "runs") answered(message);
    if (take[kind]) take[kind](message);
    else store.tell(kind, message);
    if (kind === "error") {
      show(queue.length ? null : confirmedOutlines);
      store.say(message.message);
    }
    next();
    mark();
  });

  /** Sends pending edits again after a lost connection. */
  store.restart = () => {
    waiting = null;
    previewId = null;
    store.send({ do: "hello" });
    next();
  };
  return store;
}

/** Returns outlines grouped by part, as its `parts`. */
function whole(outlines) {
  const result = {};
  for (const [key, it] of Object.entries(outlines)) {
    const owner = key.startsWith("world/") ? key.split("/").slice(0, key.startsWith("world/map") ? 2 : 3).join("/") : key;
    if (key === owner || !result[owner]) result[key] = it;
    else result[owner] = { ...result[owner], parts: [...(result[owner].parts ?? [result[owner].points]), it.points] };
  }
  return result;
}

/** Returns a text after patches [start, end, new] against the earlier text. */
function patched(text, patches) {
  // Python counts characters, JavaScript units of 16 bits.
  if (/[\ud800-\udfff]/.test(text)) {
    const letters = Array.from(text);
    const place = (n) => letters.slice(0, n).join("").length;
    patches = patches.map(([start, end, piece]) => [place(start), place(end), piece]);
  }
  let result = "";
  let at = 0;
  for (const [start, end, piece] of patches) {
    result += text.slice(at, start) + piece;
    at = end;
  }
  return result + text.slice(at);
}

