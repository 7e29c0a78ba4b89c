// Answers of an offline page to what its other parts ask for; online, a server gives the same.

import { chargeOfFlight, cycleOf, longestFlight } from "./cycle.js";
import { between, lightAt, placeIn, tableOf } from "./tables.js";

/** Source of answers over what Python wrote into the page. */
export function offlineSource(record) {
  const light = {...record.light, power: tableOf(record.light.power_w_per_m2)};
  const axes = record.designs.axes;
  const tables = {};
  for (const name of ["log_mass_kg", "log_power_w", "log_airspeed_m_per_s"]) {
    if (record.designs[name]) tables[name] = tableOf(record.designs[name]);
  }
  const shares = Object.entries(record.masses.shares).map(([name, table]) => [name, tableOf(table)]);
  const started = {};
  for (const field of record.session.fields) started[field.key] = field.value;
  for (const choice of record.session.choices) started[choice.key] = choice.value;
  const fine = evenAxis(record.step_h), coarse = evenAxis(record.coarse_step_h);
  const mapLight = new Map();

  function refusal(kind, problems) {
    const message = problems.map((p) => `${p.field}: ${p.message}`).join("; ");
    return {status: 422, body: {error: {kind, message, problems}}};
  }

  /** Fields of some settings that are not allowed. */
  function mistakes(settings) {
    const found = [];
    for (const [key, value] of Object.entries(settings)) {
      const field = record.session.fields.find((one) => one.key === key);
      let message = "";
      if (!field) {
        if (!(key in started)) message = "is not a field of this page";
        else if (value !== started[key]) message = "cannot be changed on an offline page";
      } else if (typeof value !== "number") message = "must be a number";
      else if (!(value >= field.minimum && value <= field.maximum)) message = "is out of range";
      else if (field.whole && value !== Math.round(value)) message = "must be a whole number";
      else if (field.fixed && value !== field.value) message = `cannot be changed: ${field.fixed}`;
      if (message) found.push({field: key, value, message, allowed: field ? field.allowed : ""});
    }
    return found;
  }

  /** What contradicts itself in some settings: the rules of the aircraft's file. */
  function contradictions(settings) {
    const span = settings["airframe.wingspan_m"], area = settings["modules.area_m2"];
    const wing = span * span / settings["airframe.aspect_ratio"];
    if (!(area > wing)) return [];
    const message = `must not exceed the wing area of ${+wing.toPrecision(3)} m² (got ${area})`;
    return [{field: "modules.area_m2", value: area, message, allowed: ""}];
  }

  /** Design of some settings: mass, load and battery; null where it cannot carry itself. */
  function designOf(settings) {
    const places = axes.map((axis) => placeIn(axis.values, settings[axis.key] ?? axis.values[0]));
    const power = Math.exp(between(tables.log_power_w, places));
    if (!Number.isFinite(power)) return null;
    const more = record.load.keys
      .reduce((sum, key) => sum + (key in started ? settings[key] - started[key] : 0), 0);
    const speed = tables.log_airspeed_m_per_s;
    return {
      total_mass_kg: Math.exp(between(tables.log_mass_kg, places)),
      propulsion_power_w: power,
      airspeed_m_per_s: speed ? Math.exp(between(speed, places)) : null,
      constant_power_w: record.load.constant_power_w + more / record.load.supply_efficiency,
      area_m2: settings["modules.area_m2"],
      battery: {
        ...record.battery,
        energy_wh: settings["battery.mass_kg"] * record.battery.capacity_fraction *
          settings["battery.specific_energy_wh_per_kg"],
      },
    };
  }

  /** Mass budget of a design; the tables know what battery and payload leave of it. */
  function massesOf(settings, design) {
    const battery = settings["battery.mass_kg"], payload = settings["mission.payload.mass_kg"];
    const places = record.masses.axes
      .map((axis) => placeIn(axis.values, settings[axis.key] ?? axis.values[0]));
    const rest = design.total_mass_kg - battery - payload;
    const known = {battery, payload};
    for (const [name, table] of shares) known[name] = rest * between(table, places);
    return Object.fromEntries(record.masses.parts.map((name) => [name, known[name]]));
  }

  function lightOf(settings) {
    return lightAt(light, settings["mission.latitude_deg"], settings["mission.day_of_year"], fine);
  }

  function loadOf(design, time, rise, set) {
    const {all_day: allDay, thermal} = record.load, half = (set - rise) / 2;
    return time.map((hour) => {
      const share = half > 0 ? Math.max(1 - Math.abs(hour - rise - half) / half, 0) : 0;
      return design.propulsion_power_w * (1 + allDay + thermal * share) + design.constant_power_w;
    });
  }

  /** Cycle of a design in some light, its solar power scaled by a factor. */
  function cycleIn(design, lit, time, factor = 1) {
    const solar = lit.power.map((power) => power * design.area_m2 * factor);
    const load = loadOf(design, time, lit.rise, lit.set);
    const nominal = design.propulsion_power_w * (1 + record.load.all_day) + design.constant_power_w;
    return {solar, load, nominal, ...cycleOf(time, solar, load, nominal, design.battery)};
  }

  function numbersOf(settings, design, lit, found) {
    const [low, high] = [1 - record.rms_relative, 1 + record.rms_relative]
      .map((factor) => orNull(cycleIn(design, lit, fine, factor).excess_time_h));
    const flight = found.excess_time_h > 0 ? {endurance_h: null, best_launch_h: null}
      : longestFlight(fine, found.solar, found.load, design.battery);
    const daylight = lit.set > lit.rise;
    const wh = (power) => power.reduce((sum, w, i) => i === 0 ? 0
      : sum + (w + power[i - 1]) / 2 * (fine[i] - fine[i - 1]), 0);
    return {
      aircraft: record.session.aircraft.name,
      mission: record.session.mission.name,
      model: started.model,
      correction: started.correction,
      latitude_deg: settings["mission.latitude_deg"],
      day_of_year: settings["mission.day_of_year"],
      date: dateCode(settings["mission.day_of_year"]),
      status: found.status,
      excess_time_h: orNull(found.excess_time_h),
      charge_margin_h: found.charge_margin_h,
      endurance_h: orNull(flight.endurance_h),
      best_launch_h: orNull(flight.best_launch_h),
      minimum_state_of_charge: found.minimum_state_of_charge,
      sunrise_h: daylight ? lit.rise : null,
      sunset_h: daylight ? lit.set : null,
      equal_power_morning_h: orNull(found.equal_power_morning_h),
      equal_power_evening_h: orNull(found.equal_power_evening_h),
      full_charge_h: orNull(found.full_charge_h),
      power_out_w: found.nominal,
      solar_energy_wh: wh(found.solar),
      load_energy_wh: wh(found.load),
      total_mass_kg: design.total_mass_kg,
      battery_energy_wh: design.battery.energy_wh,
      propulsion_power_w: design.propulsion_power_w,
      airspeed_m_per_s: design.airspeed_m_per_s,
      extrapolations: [],
      uncertainty: {
        solar_power_rms_relative: record.rms_relative,
        excess_time_low_h: low,
        excess_time_high_h: high,
      },
      version: record.session.version,
    };
  }

  function headlineOf(numbers) {
    const latitude = numbers.latitude_deg;
    const side = latitude === 0 ? "" : latitude < 0 ? " S" : " N";
    const hours = numbers.excess_time_h;
    const excess = hours === null ? "unlimited" : `${hours.toFixed(2)} h`;
    const where = `${+Math.abs(latitude).toFixed(2)}°${side}, ${dateLabel(numbers.day_of_year)}`;
    return `${numbers.aircraft} on ${numbers.mission} at ${where}: ` +
      `excess time ${excess}, ${numbers.status.replace("_", " ")}`;
  }

  function seasonOf(design, time, step, detail) {
    const [latitudes, days] = record.season[detail];
    if (!mapLight.has(step)) {
      mapLight.set(step, latitudes.map(
        (latitude) => days.map((day) => lightAt(light, latitude, day, time))));
    }
    const rows = mapLight.get(step).map((cells) => cells.map((lit) => {
      const hours = cycleIn(design, lit, time).excess_time_h;
      return Number.isFinite(hours) ? Math.round(hours * 1000) / 1000 : null;
    }));
    return {latitudes_deg: latitudes, days, step_h: step, excess_time_h: rows, complete: true};
  }

  function view(body) {
    const wrong = mistakes(body.settings ?? {});
    if (wrong.length) return refusal("refused", wrong);
    const settings = {...started, ...body.settings};
    const opposed = contradictions(settings);
    if (opposed.length) return refusal("contradiction", opposed);
    const design = designOf(settings);
    if (design === null) {
      return refusal("impossible", [{
        field: "design", value: null, allowed: "",
        message: `${record.session.aircraft.name} cannot carry its own mass, or nearly so: ` +
          "structure and propulsion grow faster than the lift they add",
      }]);
    }
    const lit = lightOf(settings), found = cycleIn(design, lit, fine);
    const numbers = numbersOf(settings, design, lit, found);
    const answer = {
      curve: {
        time_h: Array.from(fine),
        solar_power_w: Array.from(found.solar),
        load_w: Array.from(found.load),
        state_of_charge: Array.from(found.state_of_charge),
        flight_charge: found.excess_time_h > 0 ? Array.from(fine, () => null)
          : chargeOfFlight(fine, found.solar, found.load, design.battery, numbers.best_launch_h),
      },
      numbers,
      masses_kg: massesOf(settings, design),
      headline: headlineOf(numbers),
      notes: [],
      sequence: body.sequence ?? null,
    };
    const wanted = body.season ?? "none";
    if (wanted === "coarse") answer.season = seasonOf(design, coarse, record.coarse_step_h, wanted);
    if (wanted === "exact") answer.season = seasonOf(design, fine, record.step_h, wanted);
    return {status: 200, body: answer};
  }

  /** How far this page is from the analysis at the points that were computed with it. */
  function errors() {
    const hours = [];
    let others = 0;
    for (const point of record.checks) {
      const settings = {...started, ...point.settings}, design = designOf(settings);
      const lit = lightOf(settings);
      const found = design ? cycleIn(design, lit, fine) : {status: "impossible"};
      const here = orNull(found.excess_time_h ?? null), there = point.excess_time_h;
      if (found.status !== point.status) others += 1;
      else if (here !== null && there !== null) hours.push(Math.abs(here - there));
    }
    hours.sort((a, b) => a - b);
    return {
      points: record.checks.length,
      excess_time_90_h: hours[Math.ceil(0.9 * hours.length) - 1],
      excess_time_largest_h: hours[hours.length - 1],
      other_status: others,
    };
  }

  return {session: () => record.session, view, errors};
}

function orNull(value) {
  return value === null || !Number.isFinite(value) ? null : value;
}

function evenAxis(step) {
  const count = Math.ceil(24 / step - 1e-9);
  return Float64Array.from({length: count + 1}, (_, i) => 24 * i / count);
}

function dateOf(day) {
  return new Date(Date.UTC(2001, 0, day));
}

function dateCode(day) {
  return dateOf(day).toISOString().slice(5, 10);
}

function dateLabel(day) {
  const months = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
  return `${dateOf(day).getUTCDate()} ${months[dateOf(day).getUTCMonth()]}`;
}
