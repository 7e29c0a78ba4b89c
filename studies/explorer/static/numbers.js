// Verdict and numbers, each beside that of the starting design.

import { clock, date, element, fixed, hours, latitude } from "./format.js";

const UNLIMITED = "unlimited";
const energy = (wh) => (wh < 10000 ? `${fixed(wh, 0)} Wh` : `${fixed(wh / 1000, 1)} kWh`);
const flies = (n) => n.status === "perpetual" || n.status === "always_lit";

// Label, text of a record, whether more is better (null: neither).
const NUMBERS = [
  ["excess time", (n) => (n.status === "always_lit" ? UNLIMITED : hours(n.excess_time_h))],
  ["charge margin", (n) => hours(n.charge_margin_h)],
  ["min. charge", (n) => `${fixed(100 * n.minimum_state_of_charge, 1)} %`],
  ["endurance", (n) => (flies(n) ? UNLIMITED : hours(n.endurance_h, "over a year"))],
  ["total mass", (n) => `${fixed(n.total_mass_kg, 2)} kg`],
  ["load", (n) => `${fixed(n.power_out_w, n.power_out_w < 1000 ? 1 : 0)} W`],
  ["battery", (n) => energy(n.battery_energy_wh)],
  ["solar energy", (n) => energy(n.solar_energy_wh)],
  ["airspeed", (n) => (n.airspeed_m_per_s === null ? "\u2013" : `${fixed(n.airspeed_m_per_s, 1)} m/s`)],
  ["full at", (n) => clock(n.full_charge_h)],
];

const OF_WIND = [["wind", (n) => (n.wind ? `${fixed(n.wind.scenarios_m_per_s[0], 1)} m/s` : "\u2013")]];
const OF_CLIMBS = [
  ["highest", (n) => `${fixed(n.climb.maximum_altitude_m, 0)} m`],
  ["by climbing", (n) => hours(n.climb.gain_in_excess_time_h)],
];

/** Mood, state and sentence of a record, for a requirement [h]. */
export function verdict(n, required) {
  const where = `${latitude(n.latitude_deg)}, ${date(n.day_of_year)}`;
  const { excess_time_low_h: low, excess_time_high_h: high, solar_power_rms_relative: rms } = n.uncertainty;
  const error = `one RMS error of ${n.model} (${Math.round(100 * rms)} %)`;
  const ends = [hours(low, UNLIMITED), hours(high, UNLIMITED)];
  const spread =
    ends[0] === ends[1]
      ? `${ends[0][0].toUpperCase()}${ends[0].slice(1)} with ${error} as well`
      : `${ends[0]} to ${ends[1]} with ${error}`;
  if (n.status === "always_lit") return ["good", "Continuous solar power", `${where}. ${spread}.`];
  if (n.status === "never_lit") return ["bad", "No sun", `${where}. There is no solar power all day.`];
  if (!flies(n)) {
    return ["bad", "Limited flight", `${where}. ${hours(-n.excess_time_h)} of each day are not covered; ${spread}.`];
  }
  if (n.excess_time_h < required) {
    const lack = hours(required - n.excess_time_h);
    return ["edge", "Below requirement", `${where}. ${lack} of excess time missing; ${spread}.`];
  }
  const edge = low !== null && low <= 0;
  return [edge ? "edge" : "good", edge ? "Perpetual, on the edge" : "Perpetual flight", `${where}. ${spread}.`];
}

/** Verdict and numbers on the page. */
export class Numbers {
  constructor(list, title, text, { climbs = false, wind = false } = {}) {
    const numbers = [...NUMBERS, ...(wind ? OF_WIND : []), ...(climbs ? OF_CLIMBS : [])];
    Object.assign(this, { list, title, text, numbers, cells: [] });
    for (const [label] of numbers) {
      const value = element("dd", {}, "\u2013");
      const start = element("dd", { className: "was" });
      list.append(element("div", {}, element("dt", {}, label), value, start));
      this.cells.push([value, start]);
    }
  }

  /** Show a view beside that of the start; returns the sentence for screen readers. */
  show(view, first, required) {
    const [mood, state, sentence] = verdict(view.numbers, required);
    this.title.textContent = state;
    this.title.dataset.mood = mood;
    this.text.textContent = this.text.title = sentence;
    this.numbers.forEach(([label, text], i) => {
      const [value, start] = this.cells[i];
      const now = text(view.numbers);
      const was = text(first.numbers);
      value.textContent = now;
      start.textContent = now === was ? "" : `start ${was}`;
    });
    this.short = `${state} \u00b7 ${NUMBERS[0][1](view.numbers)}`;
    return `${state}. Excess time ${NUMBERS[0][1](view.numbers)}.`;
  }

  /** Tell why there are no numbers. */
  refuse(state, words) {
    this.title.textContent = state;
    this.title.dataset.mood = "bad";
    this.text.textContent = this.text.title = words;
  }
}
