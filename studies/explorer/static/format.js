// Numbers in words: the same digits as the command line prints.

export const MINUS = "\u2212";

/** Text of a number with a true minus sign. */
export function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) < 0 ? MINUS + text.slice(1) : text.replace("-", "");
}

/** Hours with two decimals; `none` stands for what does not exist. */
export const hours = (value, none = "\u2013") => (value === null ? none : `${fixed(value, 2)} h`);

/** Hours of the day as a clock reading. */
export function clock(value) {
  if (value === null) return "\u2013";
  const minutes = Math.round(value * 60);
  const pad = (n) => String(n).padStart(2, "0");
  return minutes === 1440 ? "24:00" : `${pad(Math.floor(minutes / 60) % 24)}:${pad(minutes % 60)}`;
}

/** Latitude as `47.6° N`. */
export function latitude(value) {
  const side = value === 0 ? "" : value < 0 ? " S" : " N";
  return `${Number(Math.abs(value).toFixed(2))}°${side}`;
}

const LENGTHS = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
export const MONTHS = [
  "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec",
];

/** First day of each month, 1 to 365. */
export const MONTH_STARTS = LENGTHS.map((_, i) => 1 + LENGTHS.slice(0, i).reduce((a, b) => a + b, 0));

/** Day of year as `15 Jul`. */
export function date(day) {
  let month = 11;
  while (month > 0 && MONTH_STARTS[month] > day) month -= 1;
  return `${day - MONTH_STARTS[month] + 1} ${MONTHS[month]}`;
}

/** Shortest text of a number that shows it to a step. */
export function stepped(value, step) {
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  return String(Number(value.toFixed(digits)));
}

/** Value of a field with its unit, for people and screen readers. */
export function spoken(field, value) {
  if (field.key === "mission.latitude_deg") return latitude(value);
  if (field.key === "mission.day_of_year") return `${date(value)} (day ${value})`;
  return `${stepped(value, field.step)}${field.unit ? ` ${field.unit}` : ""}`;
}

/** Element with properties, classes and children. */
export function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in made && !name.startsWith("aria")) made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}
