// The battery over a day that repeats itself, and what is read off it. The same equations as in
// sizing/energy (power_balance, march, cycle, endurance), for one aircraft at one place; tests
// compare both. Powers are linear between the nodes of the time axis and integrated exactly.

/** Net power of the day: surplus and deficit of every interval [Wh]. */
function balanceOf(time, solar, load) {
  const count = time.length - 1;
  const net = new Float64Array(count + 1), surplus = new Float64Array(count);
  const deficit = new Float64Array(count);
  for (let i = 0; i <= count; i++) net[i] = solar[i] - load[i];
  for (let i = 0; i < count; i++) {
    const hours = time[i + 1] - time[i], left = net[i], right = net[i + 1];
    const total = Math.max(2 * (Math.abs(left) + Math.abs(right)), 1e-300);
    const above = Math.max(left, 0) + Math.max(right, 0);
    const below = Math.max(-left, 0) + Math.max(-right, 0);
    surplus[i] = above * above / total * hours;
    deficit[i] = below * below / total * hours;
  }
  return {time, net, surplus, deficit};
}

/** Where a function that is linear over an interval is zero, as a fraction of the interval. */
function crossing(left, right) {
  return left === right ? 0 : Math.min(Math.max(left / (left - right), 0), 1);
}

/** Where the integral of a linear power that is not negative reaches a share of the whole. */
function rampFraction(left, right, share) {
  const goal = Math.min(Math.max(share, 0), 1) * (left + right) / 2;
  const root = Math.sqrt(Math.max(left * left + 2 * (right - left) * goal, 0));
  return Math.min(2 * goal / Math.max(left + root, 1e-300), 1);
}

/** Value of a table over rising nodes, constant beyond its ends. */
function interpolated(x, nodes, values) {
  let low = 0, high = nodes.length - 1;
  if (x <= nodes[0]) return values[0];
  if (x >= nodes[high]) return values[high];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (nodes[middle] <= x) low = middle; else high = middle;
  }
  return values[low] + (values[high] - values[low]) * (x - nodes[low]) / (nodes[high] - nodes[low]);
}

/** Stored energy after a surplus [Wh]; the charge limit is followed by its clock. */
function charged(battery, energy, surplus, hours) {
  const full = battery.energy_wh, clock = battery.clock;
  const target = Math.min(energy + battery.charge_efficiency * surplus, full);
  if (!clock) return target;
  const after = Math.min(target, energy + full * clock.constant_rate_per_h * hours);
  if (after <= Math.max(energy, full * clock.constant_up_to)) return after;
  const start = interpolated(Math.min(energy / full, 1), clock.state_of_charge, clock.hours);
  const limited = interpolated(start + hours, clock.hours, clock.state_of_charge) * full;
  return Math.max(Math.min(target, limited), energy);
}

/** March one interval: energies before and after charging and at its end, and what is lacking. */
function advance(battery, balance, i, energy) {
  const falling = balance.net[i] < 0, lost = balance.deficit[i] / battery.discharge_efficiency;
  const drained = energy - (falling ? lost : 0);
  const before = Math.max(drained, 0);
  const hours = balance.time[i + 1] - balance.time[i];
  const after = balance.surplus[i] > 0 ? charged(battery, before, balance.surplus[i], hours) : before;
  const left = after - (falling ? 0 : lost);
  return {before, after, end: Math.max(left, 0), lacking: before - drained + Math.max(-left, 0)};
}

function dayEnd(battery, balance, energy) {
  for (let i = 0; i < balance.surplus.length; i++) energy = advance(battery, balance, i, energy).end;
  return energy;
}

/** Energy at midnight that returns after a day: the largest one [Wh]. */
function repeatedStart(battery, balance) {
  const sum = (values) => values.reduce((a, b) => a + b, 0);
  const storable = battery.charge_efficiency * battery.discharge_efficiency * sum(balance.surplus);
  let energy = storable < sum(balance.deficit) ? 0 : battery.energy_wh;
  for (let day = 0; day < 500; day++) {
    const next = dayEnd(battery, balance, energy);
    if (Math.abs(next - energy) <= 1e-9 * battery.energy_wh) return next;
    energy = next;
  }
  return energy;
}

/** Hours of an interval in which the load exceeds the sun, and when they begin. */
function deficitPhase(balance, i) {
  const left = balance.net[i], right = balance.net[i + 1];
  const hours = balance.time[i + 1] - balance.time[i], cross = hours * crossing(left, right);
  if (left < 0 && right < 0) return {begin: 0, hours};
  if (left < 0) return {begin: 0, hours: cross};
  return right < 0 ? {begin: cross, hours: hours - cross} : {begin: hours, hours: 0};
}

/** Hours of an interval's deficit that pass before the battery, lacking some energy, is empty. */
function servedHours(battery, balance, i, lacking) {
  const share = 1 - lacking * battery.discharge_efficiency / Math.max(balance.deficit[i], 1e-300);
  const fraction = rampFraction(
    Math.max(-balance.net[i], 0), Math.max(-balance.net[i + 1], 0), share);
  return deficitPhase(balance, i).hours * fraction;
}

/** First rise and last fall of the solar power through the nominal load [h], NaN without one. */
function equalPower(time, solar, nominal) {
  let morning = -1, evening = -1;
  for (let i = 0; i + 1 < time.length; i++) {
    const left = solar[i] < nominal, right = solar[i + 1] < nominal;
    if (left && !right && morning < 0) morning = i;
    if (!left && right) evening = i;
  }
  const at = (i) => i < 0 ? 0 : crossing(solar[i] - nominal, solar[i + 1] - nominal);
  const hour = (i) => i < 0 ? NaN : time[i] + at(i) * (time[i + 1] - time[i]);
  const always = !(solar[0] < nominal) && morning < 0 && evening < 0;
  return {morning, fraction: at(morning), morning_h: hour(morning), evening_h: hour(evening), always};
}

/** Instant within an interval at which its surplus has filled the battery [h]. */
function fullAt(battery, balance, i, before) {
  const left = balance.net[i], right = balance.net[i + 1], start = balance.time[i];
  const hours = balance.time[i + 1] - start, cross = hours * crossing(left, right);
  const begin = left < 0 ? cross : 0, end = right < 0 ? cross : hours;
  const wanted = Math.max(battery.energy_wh - before, 0);
  const share = wanted / Math.max(battery.charge_efficiency * balance.surplus[i], 1e-300);
  let lasting = (end - begin) * rampFraction(Math.max(left, 0), Math.max(right, 0), share);
  const clock = battery.clock;
  if (clock) {
    const soc = Math.min(before / battery.energy_wh, 1);
    const rest = clock.hours[clock.hours.length - 1] -
      interpolated(soc, clock.state_of_charge, clock.hours);
    lasting = Math.max(lasting, rest);
  }
  return {first: start + Math.min(begin + lasting, end), last: start + end};
}

/**
 * Cycle of a day that repeats itself.
 * @param {ArrayLike<number>} time nodes from 0 to 24 [h]
 * @param {ArrayLike<number>} solar solar power at the nodes [W]
 * @param {ArrayLike<number>} load power that the aircraft draws [W]
 * @param {number} nominal load that defines equal power and excess time [W]
 * @param {object} battery energy_wh, charge_efficiency, discharge_efficiency, clock or null
 */
export function cycleOf(time, solar, load, nominal, battery) {
  const balance = balanceOf(time, solar, load), full = battery.energy_wh;
  const soc = new Float64Array(time.length), equal = equalPower(time, solar, nominal);
  let energy = repeatedStart(battery, balance), lowest = energy, missing = 0, lacking = 0;
  let first = NaN, last = NaN, dawn = energy, wasFull = false;
  for (let i = 0; i < balance.surplus.length; i++) {
    soc[i] = energy / full;
    if (i === equal.morning) {
      const left = balance.net[i], middle = left + (balance.net[i + 1] - left) * equal.fraction;
      const drained = Math.max(-(left + middle) / 2, 0) * equal.fraction * (time[i + 1] - time[i]);
      dawn = Math.max(energy - drained / battery.discharge_efficiency, 0);
    }
    const step = advance(battery, balance, i, energy);
    if (step.lacking > 0) {
      missing += deficitPhase(balance, i).hours - servedHours(battery, balance, i, step.lacking);
      lacking += step.lacking;
    }
    const isFull = step.after >= (1 - 1e-9) * full && balance.surplus[i] > 0;
    if (isFull) {
      const at = fullAt(battery, balance, i, step.before);
      if (!wasFull && Number.isNaN(first)) first = at.first;
      last = at.last;
    }
    wasFull = isFull;
    lowest = Math.min(lowest, step.before, step.end);
    energy = step.end;
  }
  soc[time.length - 1] = energy / full;
  const empty = lacking * battery.discharge_efficiency > 1e-9 * full;
  let excess = dawn * battery.discharge_efficiency / nominal;
  if (empty || (equal.morning < 0 && !equal.always)) excess = -missing;
  const unlimited = equal.always && !empty;
  let status = excess > 0 ? "perpetual" : "limited";
  if (unlimited) status = "always_lit";
  return {
    state_of_charge: soc,
    status,
    excess_time_h: unlimited ? Infinity : excess,
    minimum_state_of_charge: unlimited || excess > 0 ? lowest / full : 0,
    charge_margin_h: Number.isNaN(first) ? 0 : last - first,
    full_charge_h: first,
    equal_power_morning_h: equal.morning_h,
    equal_power_evening_h: equal.evening_h,
  };
}

/** Longest flight from a full battery, launched at a node of the time axis: hours and launch. */
export function longestFlight(time, solar, load, battery) {
  const balance = balanceOf(time, solar, load), count = balance.surplus.length;
  const best = {endurance_h: 0, best_launch_h: NaN};
  for (let launch = 0; launch < count; launch++) {
    if (balance.net[launch] >= 0 && balance.net[launch + 1] >= 0) continue;
    // A launch by surplus is no better than one where the surplus ends.
    const begin = deficitPhase(balance, launch).begin;
    let energy = battery.energy_wh, hours = -begin;
    for (let i = launch; hours < 366 * 24; i = (i + 1) % count) {
      const step = advance(battery, balance, i, energy);
      if (step.lacking > 0) {
        hours += deficitPhase(balance, i).begin + servedHours(battery, balance, i, step.lacking);
        break;
      }
      hours += time[i + 1] - time[i];
      energy = step.end;
    }
    if (hours > best.endurance_h) {
      best.endurance_h = hours >= 366 * 24 ? Infinity : hours;
      best.best_launch_h = time[launch] + begin;
    }
  }
  return best;
}

/** State of charge at the nodes in the first day of a flight launched full; null without it. */
export function chargeOfFlight(time, solar, load, battery, launchHour) {
  const balance = balanceOf(time, solar, load), count = balance.surplus.length;
  const charge = Array.from(time, () => null);
  const launch = launchHour === null ? count : time.findIndex((hour) => hour >= launchHour);
  let energy = battery.energy_wh, flies = true;
  for (let k = 0; k < count && flies && launch < count; k++) {
    const i = (launch + k) % count, step = advance(battery, balance, i, energy);
    charge[i] = energy / battery.energy_wh;
    energy = step.end;
    flies = !(step.lacking > 0);
    if (i === count - 1) charge[count] = energy / battery.energy_wh;
  }
  return charge;
}
