// Mass budget as bars; the starting design is a mark on each.

import { element, fixed } from "./format.js";

const NAMES = { mppt: "MPPT", other: "other" };

/** Bars in a list; a measured airframe is one mass but for battery, modules and payload. */
export class Masses {
  constructor(list, total, measured) {
    Object.assign(this, { list, total, measured, rows: new Map() });
  }

  /** Show the masses of a view beside those of the start. */
  show(view, first) {
    const all = { ...first.masses_kg, ...view.masses_kg };
    // A measured airframe is not divided; the payload's row stays, so that nothing jumps.
    const present = Object.keys(all).filter((n) => !this.measured || n === "payload" || all[n] > 0);
    if (present.join() !== [...this.rows.keys()].join()) this.build(present);
    const longest = Math.max(...present.flatMap((n) => [view.masses_kg[n], first.masses_kg[n]]));
    const share = (mass) => `${((100 * mass) / longest).toFixed(2)}%`;
    for (const [name, { bar, value }] of this.rows) {
      const mass = view.masses_kg[name];
      bar.style.setProperty("--share", share(mass));
      bar.style.setProperty("--start", share(first.masses_kg[name]));
      bar.classList.toggle("changed", mass !== first.masses_kg[name]);
      const whole = view.numbers.total_mass_kg;
      value.textContent = `${fixed(mass, 2)} kg`;
      value.title = `${fixed((100 * mass) / whole, 0)} % of the total mass`;
    }
    this.total.textContent = `${fixed(view.numbers.total_mass_kg, 2)} kg`;
  }

  build(names) {
    this.rows.clear();
    this.list.replaceChildren(
      ...names.map((name) => {
        const bar = element("i", { "aria-hidden": "true" });
        const value = element("b");
        const label = name === "other" && this.measured ? "airframe" : (NAMES[name] ?? name);
        this.rows.set(name, { bar, value });
        return element("li", {}, element("span", {}, label), bar, value);
      }),
    );
  }
}
