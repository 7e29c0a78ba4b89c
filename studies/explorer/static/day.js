// Day curve: solar power, load and state of charge over solar time, and the altitude of flights with
// climbs; the starting design dashed.

import { clock, element, fixed } from "./format.js";

const SERIES = [
  ["solar_power_w", "solar power", "--solar", "W"],
  ["load_w", "load", "--load", "W"],
  ["state_of_charge", "state of charge", "--charge", "%"],
];
const ALTITUDE = ["altitude", "--altitude"];
const FLIGHT = "longest flight, launched full";
const NICE = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];

function ceiling(value) {
  const scale = 10 ** Math.floor(Math.log10(Math.max(value, 1)));
  return scale * NICE.find((n) => n * scale >= value * 1.02);
}

/** Width of an axis that its longest label needs. */
function wide(chart, labels) {
  const longest = Math.max(...(labels ?? []).map((label) => chart.ctx.measureText(label).width));
  return Math.max(34, Math.ceil(longest / devicePixelRatio) + 14);
}

/** Chart in an element; `readout` shows the values under the pointer. */
export class Day {
  constructor(holder, legend, readout, words, climbs = false) {
    Object.assign(this, { holder, readout, words, legend, climbs });
    for (const [, label, colour] of climbs ? [...SERIES, [null, ...ALTITUDE]] : SERIES) {
      const key = element("i", { className: "key", "aria-hidden": "true" });
      key.dataset.colour = colour.slice(2);
      legend.append(element("span", {}, key, label));
    }
    this.ghostKey = element(
      "span",
      { hidden: true },
      element("i", { className: "key dashed", "aria-hidden": "true" }),
      "start",
    );
    this.flightKey = element(
      "span",
      { hidden: true },
      element("i", { className: "key dotted", "aria-hidden": "true" }),
      FLIGHT,
    );
    const night = element("span", { className: "extra" }, element("i", { className: "key night", "aria-hidden": "true" }), "night");
    const equal = element("span", { className: "extra" }, element("i", { className: "key ring", "aria-hidden": "true" }), "equal power");
    legend.append(night, equal, this.ghostKey, this.flightKey);
    new ResizeObserver(() => this.fit()).observe(holder);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.restyle());
  }

  /** Draw a view, and that of the start where it differs. */
  show(view, first, ghost) {
    this.view = view;
    this.ghostKey.hidden = !ghost;
    const percent = (values) => values.map((v) => 100 * v);
    const kilometres = (c) => (this.climbs ? [c.altitude_m.map((v) => v / 1000)] : []);
    const columns = (c) => [c.solar_power_w, c.load_w, percent(c.state_of_charge), ...kilometres(c)];
    const none = view.curve.time_h.map(() => null);
    const behind = ghost ? columns(first.curve) : columns(view.curve).map(() => none);
    const flight = view.curve.flight_charge.map((v) => (v === null ? null : 100 * v));
    this.flightKey.hidden = flight.every((v) => v === null);
    this.data = [view.curve.time_h, ...behind, ...columns(view.curve), flight];
    this.own = 1 + behind.length; // row of the first curve of the view itself
    if (this.climbs) this.height = ceiling(Math.max(...this.data[this.own + 3], ...(ghost ? this.data[4] : [])));
    const highest = (curve) => Math.max(...curve.solar_power_w, ...curve.load_w);
    this.top = ceiling(Math.max(highest(view.curve), ghost ? highest(first.curve) : 0));
    if (this.chart) this.chart.setData(this.data);
    else this.restyle();
  }

  restyle() {
    if (!this.data) return;
    this.chart?.destroy();
    this.chart = new uPlot(this.options(), this.data, this.holder);
  }

  size() {
    return { width: Math.max(this.holder.clientWidth, 200), height: Math.max(this.holder.clientHeight, 120) };
  }

  fit() {
    if (!this.chart) return;
    const { width, height } = this.size();
    if (width !== this.chart.width || height !== this.chart.height) this.chart.setSize({ width, height });
  }

  options() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const font = `11px ${style.getPropertyValue("--sans")}`;
    const line = (name, scale, more) => ({ scale, stroke: colour(name), width: 2, points: { show: false }, ...more });
    const ghost = (name, scale) =>
      line(`${name}-ghost`, scale, { width: 1.25, dash: [5, 4] });
    const axis = (more) => ({
      font,
      labelFont: font,
      stroke: colour("--muted"),
      grid: { stroke: colour("--grid"), width: 1 },
      ticks: { stroke: colour("--grid"), width: 1, size: 4 },
      ...more,
    });
    return {
      ...this.size(),
      padding: [8, 0, 0, 0],
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, points: { size: 7 } },
      scales: {
        x: { time: false, range: [0, 24] },
        W: { range: () => [0, this.top] },
        "%": { range: [0, 100] },
        ...(this.climbs && { km: { range: () => [0, this.height] } }),
      },
      series: [
        {},
        ghost("--solar", "W"),
        ghost("--load", "W"),
        ghost("--charge", "%"),
        ...(this.climbs ? [ghost("--altitude", "km")] : []),
        line("--solar", "W", { fill: colour("--solar-fill") }),
        line("--load", "W"),
        line("--charge", "%"),
        ...(this.climbs ? [line("--altitude", "km")] : []),
        line("--charge", "%", { dash: [2, 3], spanGaps: false }),
      ],
      axes: [
        axis({ splits: (chart) => Array.from({ length: chart.width < 480 ? 5 : 9 }, (_, i) => (chart.width < 480 ? 6 : 3) * i), values: (_, at) => at.map(clock), size: 26, gap: 4 }),
        axis({ scale: "W", size: wide, gap: 4, values: (_, at) => at.map((v, i) => (i === at.length - 1 ? `${v} W` : v)) }),
        axis({ scale: "%", side: 1, size: wide, gap: 4, grid: { show: false }, splits: () => [0, 25, 50, 75, 100], values: (_, at) => at.map((v) => `${v} %`) }),
        ...(this.climbs ? [axis({ scale: "km", side: 1, size: wide, gap: 4, grid: { show: false }, values: (_, at) => at.map((v) => `${v} km`) })] : []),
      ],
      hooks: {
        drawClear: [(chart) => this.night(chart, colour("--night"))],
        draw: [(chart) => this.instants(chart, colour("--muted"))],
        setCursor: [(chart) => this.read(chart)],
      },
    };
  }

  /** Night behind the curves. */
  night(chart, colour) {
    const { sunrise_h: rise, sunset_h: set, solar_energy_wh: energy } = this.view.numbers;
    const { ctx, bbox } = chart;
    const dark = rise === null || (energy === 0 && rise === set) ? [[0, energy > 0 ? 0 : 24]] : [[0, rise], [set, 24]];
    ctx.save();
    ctx.fillStyle = colour;
    for (const [from, to] of dark) {
      const left = chart.valToPos(from, "x", true);
      ctx.fillRect(left, bbox.top, chart.valToPos(to, "x", true) - left, bbox.height);
    }
    ctx.restore();
  }

  /** Instants of equal power, as dots on the load. */
  instants(chart, colour) {
    const n = this.view.numbers;
    const { ctx } = chart;
    ctx.save();
    ctx.strokeStyle = colour;
    ctx.lineWidth = 1.5 * devicePixelRatio;
    for (const at of [n.equal_power_morning_h, n.equal_power_evening_h]) {
      if (at === null) continue;
      ctx.beginPath();
      ctx.arc(chart.valToPos(at, "x", true), chart.valToPos(n.power_out_w, "W", true), 4 * devicePixelRatio, 0, 7);
      ctx.stroke();
    }
    ctx.restore();
  }

  read(chart) {
    const i = chart.cursor.idx;
    if (i === null || i === undefined || chart.cursor.left < 0) {
      this.readout.textContent = "";
      return;
    }
    const at = (row) => this.data[row][i];
    const watts = (v) => `${fixed(v, v < 100 ? 1 : 0)} W`;
    const own = this.own;
    const last = at(this.data.length - 1);
    const height = this.climbs ? ` \u00b7 altitude ${fixed(1000 * at(own + 3), 0)} m` : "";
    const flight = last === null ? "" : ` \u00b7 longest flight ${fixed(last, 1)} %`;
    this.readout.textContent = `${clock(at(0))}  solar ${watts(at(own))} \u00b7 load ${watts(at(own + 1))} \u00b7 charge ${fixed(at(own + 2), 1)} %${height}${flight}`;
  }

  /** Say the curve in words, once it rests. */
  say() {
    const n = this.view.numbers;
    const peak = Math.max(...this.view.curve.solar_power_w);
    this.words.textContent =
      `Solar power peaks at ${fixed(peak, 0)} W, the load is ${fixed(n.power_out_w, 1)} W. ` +
      `Equal power at ${clock(n.equal_power_morning_h)} and ${clock(n.equal_power_evening_h)} solar time; ` +
      `battery full at ${clock(n.full_charge_h)}, least charge ${fixed(100 * n.minimum_state_of_charge, 1)} %.` +
      (this.climbs ? ` The aircraft climbs to ${fixed(n.climb.maximum_altitude_m, 0)} m and glides ${fixed(n.climb.gliding_h, 1)} h.` : "") +
      (n.endurance_h === null || n.best_launch_h === null ? "" : ` The longest flight is launched full at ${clock(n.best_launch_h)} and lasts ${fixed(n.endurance_h, 1)} h.`);
  }
}
