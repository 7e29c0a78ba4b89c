// Tables of an offline page, and interpolation in them.

/** Table of integers as Python wrote it, with a function that gives its numbers. */
export function tableOf(record) {
  const bytes = Uint8Array.from(atob(record.base64), (letter) => letter.charCodeAt(0));
  const integers = new DataView(bytes.buffer);
  const values = new Float64Array(bytes.length / 2);
  for (let i = 0; i < values.length; i++) {
    const integer = integers.getInt16(2 * i, true);
    values[i] = integer === record.impossible ? NaN : record.offset + record.scale * integer;
  }
  return {shape: record.shape, values};
}

/** Interval of rising nodes that a value lies in, and how far; the ends hold beyond them. */
export function placeIn(nodes, x) {
  if (nodes.length === 1) return {low: 0, share: 0};
  let low = 0;
  while (low < nodes.length - 2 && nodes[low + 1] <= x) low++;
  const share = (x - nodes[low]) / (nodes[low + 1] - nodes[low]);
  return {low, share: Math.min(Math.max(share, 0), 1)};
}

/** Value of a table between the nodes of all its axes, linear along each; NaN next to a gap. */
export function between(table, places) {
  let sum = 0;
  for (let corner = 0; corner < 1 << places.length; corner++) {
    let weight = 1, index = 0;
    for (let axis = 0; axis < places.length; axis++) {
      const upper = (corner >> axis) & 1, {low, share} = places[axis];
      weight *= upper ? share : 1 - share;
      index = index * table.shape[axis] + low + upper;
      if (weight === 0) break;
    }
    if (weight !== 0) sum += weight * table.values[index];
  }
  return sum;
}

/** Rows of a table's last axis between the nodes of the other two, linear along each. */
function rowBetween(table, first, second) {
  const [, width, length] = table.shape, row = new Float64Array(length);
  for (const [i, u] of [[first.low, 1 - first.share], [first.low + 1, first.share]]) {
    for (const [j, v] of [[second.low, 1 - second.share], [second.low + 1, second.share]]) {
      if (u * v === 0) continue;
      const start = (i * width + j) * length;
      for (let k = 0; k < length; k++) row[k] += u * v * table.values[start + k];
    }
  }
  return row;
}

/** Sunrise and sunset of the geometric sun in solar time [h]; Duffie & Beckman, eq. 1.6.10. */
function sunTimes(latitudeDeg, declination) {
  const latitude = latitudeDeg * Math.PI / 180;
  const mean = Math.sin(latitude) * Math.sin(declination);
  const amplitude = Math.cos(latitude) * Math.cos(declination);
  if (mean >= Math.abs(amplitude)) return {rise: 0, set: 24};
  if (mean <= -Math.abs(amplitude)) return {rise: 12, set: 12};
  const half = Math.acos(Math.min(Math.max(-mean / amplitude, -1), 1)) * 12 / Math.PI;
  return {rise: 12 - half, set: 12 + half};
}

/** Solar power per module area at the nodes of a time axis [W/m2], with sunrise and sunset. */
export function lightAt(light, latitudeDeg, day, time) {
  const {rise, set} = sunTimes(latitudeDeg, light.declinations_rad[Math.round(day) - 1]);
  const power = new Float64Array(time.length);
  if (set > rise) {
    const row = rowBetween(
      light.power, placeIn(light.latitudes_deg, latitudeDeg), placeIn(light.days, day));
    const last = row.length - 1, length = light.mirrored ? 2 * last : last;
    for (let i = 0; i < time.length; i++) {
      if (time[i] <= rise && rise > 0 || time[i] >= set && set < 24) continue;
      let along = (time[i] - rise) / (set - rise) * length;
      if (along > last) along = length - along;
      const low = Math.min(Math.floor(along), last - 1);
      power[i] = row[low] + (row[low + 1] - row[low]) * (along - low);
    }
  }
  return {power, rise, set};
}
