// Settings of the page and their trace in the address: only what differs from the start.

/** Settings by key, with the fields that they belong to. */
export class State extends EventTarget {
  constructor(session) {
    super();
    this.fields = new Map(session.fields.map((field) => [field.key, field]));
    this.choices = new Map(session.choices.map((choice) => [choice.key, choice]));
    this.start = {};
    for (const one of [...session.fields, ...session.choices]) this.start[one.key] = one.value;
    this.values = { ...this.start, ...this.read() };
  }

  /** What differs from the start. */
  changes() {
    return Object.fromEntries(
      Object.entries(this.values).filter(([key, value]) => value !== this.start[key]),
    );
  }

  /**
   * Take new values: "move" while a slider moves, "commit" when it rests (a step for the back
   * button), "restore" when they come from the address.
   */
  set(values, how = "commit") {
    Object.assign(this.values, values);
    if (how !== "restore") this.write(how);
    this.dispatchEvent(new CustomEvent("change", { detail: { how } }));
  }

  reset() {
    this.set({ ...this.start });
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

  write(how) {
    const hash = new URLSearchParams(this.changes()).toString();
    const address = location.pathname + (hash ? `#${hash}` : "");
    if (how === "move") {
      // Browsers allow some hundred changes of the address in half a minute.
      clearTimeout(this.later);
      this.later = setTimeout(() => history.replaceState(null, "", address), 300);
      return;
    }
    clearTimeout(this.later);
    if (address !== this.committed) history.pushState(null, "", address);
    this.committed = address;
  }

  /** Settings of the address again, after the back button. */
  restore() {
    clearTimeout(this.later);
    this.committed = location.pathname + location.hash;
    const values = { ...this.start, ...this.read() };
    // The back button is told twice: by popstate and by hashchange.
    if (Object.keys(values).some((key) => values[key] !== this.values[key])) this.set(values, "restore");
  }
}
