// Sizing: the best design, what limits it, and what would help where there is none.

import { element, spoken, stepped } from "./format.js";
import { Gone } from "./api.js";

const REQUIRED = "mission.required_excess_time_h";
const MAIN = ["airframe.wingspan_m", "battery.mass_kg", "modules.area_m2"];
const KEPT = "solar-uav sizing"; // a result, kept in the tab over a reload

/** What a sizing found, without what it was for. */
const outcome = (headline) => {
  const state = headline.split(": ").slice(1).join(": ");
  return state[0].toUpperCase() + state.slice(1);
};

const list = (title, items) =>
  items.length
    ? [element("h3", {}, title), element("ul", {}, ...items.map((item) => element("li", {}, item)))]
    : [];

/** Form and result of sizings. */
export class Sizing {
  constructor(form, result, session, state, api) {
    Object.assign(this, { form, result, state, api, version: session.version });
    const why = session.cannot_size;
    const field = state.fields.get(REQUIRED);
    this.objective = element("select", { id: "objective" });
    for (const one of session.objectives) {
      this.objective.append(element("option", { value: one.name, selected: one.name === "min_mass" }, one.label));
    }
    this.scenarios = element("select", { id: "scenarios" });
    this.scenarios.append(element("option", { value: "point" }, "point shown"));
    const several = session.mission.scenarios.length;
    if (several > 1) {
      this.scenarios.append(element("option", { value: "mission", selected: true }, `all ${several} scenarios`));
    }
    this.required = element("input", {
      type: "number", id: "required", step: "any", min: field.minimum, max: field.maximum,
      inputMode: "decimal", title: field.allowed,
      "aria-label": "required excess time in hours",
    });
    this.required.addEventListener("change", () => {
      const value = Number(this.required.value);
      if (this.required.value.trim() !== "" && this.required.checkValidity()) state.set({ [REQUIRED]: value });
      else this.required.reportValidity();
    });
    this.go = element("button", { type: "submit", className: "main" }, "Size it");
    this.ask = element("button", { type: "button" }, "What would it take?");
    this.stop = element("button", { type: "button", hidden: true }, "Cancel");
    const labelled = (text, input, unit = "") =>
      element("div", { className: "line" }, element("label", { htmlFor: input.id }, text), input, element("span", { className: "unit" }, unit));
    form.append(
      labelled("objective", this.objective),
      labelled("scenarios", this.scenarios),
      labelled("required excess", this.required, "h"),
      element("div", { className: "line buttons" }, this.go, this.ask, this.stop),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.run(true);
    });
    this.ask.addEventListener("click", () => this.run(false));
    this.stop.addEventListener("click", () => this.abort?.abort());
    state.addEventListener("change", () => {
      this.show();
      this.fade();
    });
    this.show();
    this.cannot = why;
    if (why) {
      for (const input of [this.objective, this.scenarios, this.go]) input.disabled = true;
      result.append(element("p", {}, `${why[0].toUpperCase()}${why.slice(1)}.`));
    } else this.recall();
  }

  show() {
    this.required.value = stepped(this.state.values[REQUIRED], 0.01);
  }

  /** Settings that a result holds for; one for the mission's scenarios holds at every point. */
  settings() {
    const changes = { ...this.state.changes() };
    if (this.scenarios.value === "mission") {
      delete changes["mission.latitude_deg"];
      delete changes["mission.day_of_year"];
    }
    return JSON.stringify(Object.entries(changes).sort());
  }

  /** Grey a result while the settings are not those that it was found for. */
  fade() {
    const moved = this.held !== undefined && this.held !== this.settings();
    this.result.classList.toggle("moved", moved);
  }

  /** Show again what was found before the page was loaded anew. */
  recall() {
    const kept = JSON.parse(sessionStorage.getItem(KEPT) ?? "null");
    if (kept?.page !== location.origin || kept.version !== this.version) return;
    this.objective.value = kept.objective;
    this.scenarios.value = kept.scenarios;
    this.tell(kept.found, kept.taken, kept.held);
  }

  /** Take the flight that is shown: what would make a limited one perpetual. */
  fly(numbers) {
    this.flight = numbers;
  }

  busy(is) {
    this.go.disabled = this.ask.disabled = is;
    this.stop.hidden = !is;
    this.form.setAttribute("aria-busy", String(is));
  }

  /** Size; `take` moves the sliders to the optimum. */
  async run(take) {
    if (this.cannot) {
      this.result.replaceChildren(...this.gap());
      return;
    }
    this.abort = new AbortController();
    this.busy(true);
    this.held = undefined;
    this.fade();
    this.result.replaceChildren(element("p", { className: "quiet" }, "Sizing …"));
    try {
      const settings = { ...this.state.changes() };
      let held = this.settings();
      const where = this.scenarios.selectedOptions[0].textContent;
      const found = { ...(await this.api.size(settings, this.objective.value, this.scenarios.value, this.abort.signal)), where };
      if (take && found.values) {
        this.take(found);
        held = this.settings();
      }
      this.tell(found, take, held);
    } catch (error) {
      const cancelled = error.name === "AbortError" || error.kind === "ended";
      const text = cancelled ? "Cancelled." : error instanceof Gone ? "The server does not answer." : `${error.message}.`;
      this.result.replaceChildren(element("p", { className: cancelled ? "quiet" : "wrong" }, text));
    } finally {
      this.busy(false);
    }
  }

  /** Move the sliders to an optimum, and to the scenario that it is hardest in. */
  take(found) {
    const values = Object.fromEntries(
      Object.entries(found.values).filter(([key]) => this.state.fields.has(key)),
    );
    const worst = found.worst_scenario;
    if (worst) {
      values["mission.latitude_deg"] = worst.latitude_deg;
      values["mission.day_of_year"] = worst.day_of_year;
    }
    this.state.set(values, "jump");
  }

  tell(found, taken, held) {
    const head = `${outcome(found.headline)}, for ${found.where}.`;
    const parts = [element("p", { className: found.feasible ? "good" : "wrong" }, head)];
    if (found.feasible) {
      parts.push(...list("Limited by", found.limits));
      if (taken) {
        parts.push(element("p", { className: "quiet" }, "The sliders are at this optimum. The browser's back button undoes that."));
      } else {
        const go = this.mover(found, "Move the sliders there", () => this.tell(found, true, this.settings()));
        parts.push(element("p", {}, "A feasible design exists. ", go), ...this.gap());
      }
      parts.push(...this.margin(found.with_margin));
    } else {
      parts.push(...list("Missed", found.missed));
      const easier = found.relaxations.map((one) => this.relaxation(one));
      parts.push(...list("Feasible with one of these, all else unchanged", easier));
      parts.push(...list("Limited by", found.limits));
      if (!easier.length) parts.push(element("p", {}, "No single parameter that was tried would make it feasible."));
    }
    parts.push(
      element("details", {}, element("summary", {}, "As the command line prints it"), element("pre", {}, found.text)),
    );
    this.result.replaceChildren(...parts);
    this.held = held;
    this.fade();
    const { record, ...shown } = found;
    const kept = { found: shown, taken, held, page: location.origin, version: this.version };
    sessionStorage.setItem(KEPT, JSON.stringify({ ...kept, objective: this.objective.value, scenarios: this.scenarios.value }));
  }

  /** Button that moves the sliders to a design. */
  mover(found, words, after = () => {}) {
    const button = element("button", { type: "button" }, words);
    button.addEventListener("click", () => {
      this.take(found);
      after();
    });
    return button;
  }

  /** Optimum that flies with one RMS error less solar power as well. */
  margin(guarded) {
    if (!guarded) return [];
    const title = element("h3", {}, `With ${guarded.error} less solar power as well`);
    if (!guarded.values) return [title, element("p", {}, `${outcome(guarded.headline)}.`)];
    const fields = MAIN.map((key) => this.state.fields.get(key)).filter((field) => field && field.key in guarded.values);
    const design = fields.map((field) => `${field.label} ${spoken(field, guarded.values[field.key])}`).join(", ");
    const text = `${outcome(guarded.headline)}; ${design}. `;
    return [title, element("p", {}, text, this.mover(guarded, "Move the sliders to this one"))];
  }

  /** What alone would make the design that is shown fly perpetually. */
  gap() {
    const flight = this.flight;
    if (!flight || !["limited", "never_lit"].includes(flight.status)) return this.cannot ? [element("p", {}, "The design shown flies perpetually.")] : [];
    const ways = flight.relaxations.map((one) => this.relaxation(one));
    if (!ways.length) return [element("p", {}, "No single change of battery, modules or load makes the design shown fly perpetually.")];
    return list("The design shown would fly perpetually with one of these", ways);
  }

  /** A relaxation in words; one of a slider's can be taken at once. */
  relaxation(one) {
    const field = this.state.fields.get(one.parameter);
    const unit = one.unit === "1" ? "" : ` ${one.unit.replace("m2", "m\u00b2").replace("deg", "°")}`;
    const shown = (v) => (field ? spoken(field, v) : `${Number(v.toPrecision(4))}${unit}`);
    const name = one.label ?? field?.label ?? "load";
    const item = element("span", {}, `${name} ${one.direction} ${shown(one.value)} (now ${shown(one.present)}) `);
    if (field && !field.fixed) {
      const button = element("button", { type: "button", className: "quiet" }, "Apply");
      button.setAttribute("aria-label", `Apply: ${item.textContent.trim()}`);
      button.addEventListener("click", () => this.state.set({ [field.key]: one.value }));
      item.append(button);
    }
    return item;
  }
}
