// Settings of the page and their trace in the address: only what differs from the start.

const ONE_STEP_MS = 1500;

/** Settings by key, with the fields that they belong to. */
export class State extends EventTarget {
  constructor(session) {
    super();
    this.fields = new Map(session.fields.map((field) => [field.key, field]));
    this.choices = new Map(session.choices.map((choice) => [choice.key, choice]));
    this.start = {};
    for (const one of [...session.fields, ...session.choices]) this.start[one.key] = one.value;
    this.values = { ...this.start, ...this.read() };
    this.committed = { address: location.pathname + location.hash, keys: "", at: 0 };
  }

  /** What differs from the start. */
  changes() {
    return Object.fromEntries(
      Object.entries(this.values).filter(([key, value]) => value !== this.start[key]),
    );
  }

  /**
   * Take new values: "move" while a slider moves, "commit" when it rests (a step for the back
   * button), "jump" when many change at once (a step as well), "restore" when they come from the
   * address.
   */
  set(values, how = "commit") {
    Object.assign(this.values, values);
    if (how === "commit" || how === "jump") this.write(Object.keys(values).join());
    this.dispatchEvent(new CustomEvent("change", { detail: { how } }));
  }

  /** Say that a value of a field is not allowed; the values stay. */
  refuse(field, message) {
    this.dispatchEvent(new CustomEvent("refused", { detail: { field, message, allowed: "" } }));
  }

  reset() {
    this.set({ ...this.start }, "jump");
  }

  /** Settings of the address; what is no field or no allowed value is left out. */
  read() {
    const found = {};
    for (const [key, text] of new URLSearchParams(location.hash.slice(1))) {
      const field = this.fields.get(key);
      const choice = this.choices.get(key);
      if (field && !field.fixed && text.trim() !== "") {
        const value = Number(text);
        const good = value >= field.minimum && value <= field.maximum;
        if (good && (!field.whole || Number.isInteger(value))) found[key] = value;
      } else if (choice?.options.some((option) => option.name === text && !option.reason)) {
        found[key] = text;
      }
    }
    return found;
  }

  /** Put the state into the address; arrow keys held on one slider are one step back. */
  write(keys) {
    const hash = new URLSearchParams(this.changes()).toString();
    const address = location.pathname + (hash ? `#${hash}` : "");
    const { committed } = this;
    if (address === committed.address) return;
    const same = keys === committed.keys && performance.now() - committed.at < ONE_STEP_MS;
    if (same) history.replaceState(null, "", address);
    else history.pushState(null, "", address);
    this.committed = { address, keys, at: performance.now() };
  }

  /** Settings of the address again, after the back button. */
  restore() {
    this.committed = { address: location.pathname + location.hash, keys: "", at: 0 };
    const values = { ...this.start, ...this.read() };
    // The back button is told twice: by popstate and by hashchange.
    if (Object.keys(values).some((key) => values[key] !== this.values[key])) this.set(values, "restore");
  }
}
