// Sliders, numbers and choices.

import { date, element, spoken, stepped } from "./format.js";

const GROUPS = [
  ["place", "Where and when"],
  ["design", "Design"],
  ["payload", "Payload"],
  ["technology", "Technology"],
];
// The catalogue's labels, shortened to the width of the column; the whole one is the tooltip.
const SHORT = {
  "modules.efficiency_stc": "module efficiency",
  "battery.specific_energy_wh_per_kg": "specific energy",
  "airframe.aerodynamics.lift_coefficient": "lift coefficient",
  "mission.required_excess_time_h": "required excess",
  model: "model",
  correction: "correction",
};

/** Rows of all settings; they follow the state and change it. */
export class Controls {
  constructor(form, state) {
    this.state = state;
    this.rows = new Map();
    for (const [group, title] of GROUPS) {
      const fields = [...state.fields.values()].filter((field) => field.group === group);
      if (!fields.length) continue;
      form.append(
        element("fieldset", {}, element("legend", {}, title), ...fields.map((f) => this.row(f))),
      );
    }
    const choices = [...state.choices.values()].map((choice) => this.choice(choice));
    form.append(
      element("fieldset", {}, element("legend", {}, "Solar power model"), ...choices),
    );
    form.addEventListener("submit", (event) => event.preventDefault());
    state.addEventListener("change", () => this.show());
    this.show();
  }

  /** Slider and number of a field. */
  row(field) {
    const id = `field-${field.key.replaceAll(".", "-")}`;
    const label = element("label", { htmlFor: id, title: field.label }, SHORT[field.key] ?? field.label);
    const range = element("input", { type: "range", id, step: field.step, title: field.allowed });
    const number = element("input", {
      type: "number",
      step: "any",
      min: field.minimum,
      max: field.maximum,
      inputMode: "decimal",
      "aria-label": `${field.label}${field.unit ? ` in ${field.unit}` : ""}`,
      title: field.allowed,
    });
    const unit = element("span", { className: "unit" }, field.unit);
    const about = element("p", { className: "about", id: `${id}-about`, hidden: true }, `${field.about} Allowed: ${field.allowed}. Key: ${field.key}`);
    const message = element("p", { className: "message", id: `${id}-message` });
    const start = element("i", { className: "start", "aria-hidden": "true" });
    const track = element("span", { className: "track" }, start, range);
    const row = element("div", { className: "row field" }, this.named(label, about), track, number, unit, message, about);
    row.dataset.key = field.key;
    number.setAttribute("aria-describedby", message.id);
    range.setAttribute("aria-describedby", message.id);
    if (field.fixed) {
      range.disabled = number.disabled = true;
      row.classList.add("fixed");
      row.title = field.fixed;
      message.textContent = field.fixed;
    }
    range.addEventListener("input", () => this.state.set({ [field.key]: Number(range.value) }, "move"));
    range.addEventListener("change", () => this.state.set({ [field.key]: Number(range.value) }));
    number.addEventListener("change", () => this.typed(field, number));
    this.rows.set(field.key, { field, row, range, number, message, start });
    return row;
  }

  /** Label with a button that shows and hides what the field is. */
  named(label, about) {
    const button = element("button", { type: "button", className: "help", "aria-label": `About ${label.textContent}`, "aria-expanded": "false", "aria-controls": about.id }, "?");
    button.addEventListener("click", () => {
      about.hidden = !about.hidden;
      button.setAttribute("aria-expanded", String(!about.hidden));
    });
    return element("span", { className: "name" }, label, button);
  }

  /** Names to choose from. */
  choice(choice) {
    const id = `choice-${choice.key}`;
    const select = element("select", { id });
    for (const option of choice.options) {
      const text = option.reason ? `${option.label} (${option.reason})` : option.label;
      select.append(element("option", { value: option.name, disabled: Boolean(option.reason) }, text));
    }
    const message = element("p", { className: "message", id: `${id}-message` });
    select.setAttribute("aria-describedby", message.id);
    select.addEventListener("change", () => this.state.set({ [choice.key]: select.value }));
    const label = element("label", { htmlFor: id, title: choice.label }, SHORT[choice.key]);
    const row = element("div", { className: "row choice" }, label, select, message);
    this.rows.set(choice.key, { row, select, message });
    return row;
  }

  /** Number that was typed: taken if it is allowed. */
  typed(field, number) {
    const value = number.value.trim() === "" ? NaN : Number(number.value);
    const good = value >= field.minimum && value <= field.maximum;
    if (good && (!field.whole || Number.isInteger(value))) {
      this.state.set({ [field.key]: value });
    } else {
      this.state.refuse(field.key, `must be ${field.allowed}`);
    }
  }

  /** Show the state. */
  show() {
    for (const [key, { field, range, number, select, row, start }] of this.rows) {
      const value = this.state.values[key];
      row.classList.toggle("changed", value !== this.state.start[key]);
      if (select) {
        select.value = value;
        continue;
      }
      // An optimum may lie beyond the slider's usual ends.
      const low = Math.min(field.slider[0], value);
      const high = Math.max(field.slider[1], value);
      range.min = low;
      range.max = high;
      range.value = value;
      range.setAttribute("aria-valuetext", spoken(field, value));
      const share = (v) => (100 * (v - low)) / (high - low || 1);
      row.style.setProperty("--at", `${share(value)}%`);
      start.style.setProperty("--start", `${share(this.state.start[key])}`);
      if (document.activeElement !== number || number.value === "") number.value = stepped(value, field.step);
      else if (Number(number.value) !== value) number.value = stepped(value, field.step);
      if (key === "mission.day_of_year") row.querySelector(".unit").textContent = date(value);
    }
  }

  /** Mark a field with what is wrong with it. */
  complain(key, words) {
    const row = this.rows.get(key);
    if (!row) return false;
    row.message.textContent = words;
    row.row.classList.add("wrong");
    for (const input of [row.range, row.number, row.select]) input?.setAttribute("aria-invalid", "true");
    return true;
  }

  /** Take all complaints back. */
  forgive() {
    for (const { field, row, range, number, select, message } of this.rows.values()) {
      if (!row.classList.contains("wrong")) continue;
      row.classList.remove("wrong");
      message.textContent = field?.fixed ?? "";
      for (const input of [range, number, select]) input?.removeAttribute("aria-invalid");
    }
  }
}
