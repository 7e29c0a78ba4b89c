// Map of excess time over day of year and latitude; pointer and arrow keys move the point.

import { MINUS, MONTHS, MONTH_STARTS, date, element, hours, latitude } from "./format.js";

const LATITUDE = "mission.latitude_deg";
const DAY = "mission.day_of_year";
const MARGIN = { left: 40, right: 8, top: 6, bottom: 20 };

/** Map in an element with a canvas. */
export class Season {
  constructor(holder, readout, legend, detail, state, scale) {
    Object.assign(this, { holder, readout, detail, state, scale });
    this.beyond = 2 * scale.unlimited_h; // stands for unlimited between cells; never shown as a number
    this.packed = new Uint32Array(scale.colours.length);
    new Uint8Array(this.packed.buffer).set(scale.colours.flatMap((colour) => [...colour, 255]));
    this.canvas = holder.querySelector("canvas");
    this.image = document.createElement("canvas");
    this.legend(legend);
    new ResizeObserver(() => this.draw()).observe(holder);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    holder.addEventListener("pointerdown", (event) => this.press(event));
    holder.addEventListener("pointermove", (event) => this.hover(event));
    holder.addEventListener("pointerup", (event) => this.release(event));
    holder.addEventListener("pointercancel", () => {
      this.pressed = false;
      this.state.set({});
    });
    holder.addEventListener("pointerleave", () => this.read(null));
    holder.addEventListener("keydown", (event) => this.key(event));
  }

  legend(holder) {
    const level = (value) => (value < 0 ? MINUS : "") + Math.abs(value);
    const levels = this.scale.levels_h.map(level);
    const labels = ["lower", ...levels, "no night"];
    labels[labels.length - 2] += " h";
    this.scale.colours.forEach((colour, i) => {
      const swatch = element("i");
      swatch.style.background = `rgb(${colour})`;
      holder.append(element("span", {}, swatch, labels[i]));
    });
  }

  /** Pixel of a value; the last band is that of unlimited. */
  pixelOf(value) {
    const { levels_h: levels, unlimited_h: unlimited } = this.scale;
    if (value >= unlimited) return this.packed[levels.length + 1];
    let i = levels.length;
    while (i > 0 && value < levels[i - 1]) i -= 1;
    return this.packed[i];
  }

  /** Take a map; rows that are not known yet stay empty. */
  show(map) {
    this.map = map;
    this.paint();
    this.draw();
    const step = Math.round(60 * map.step_h);
    this.detail.textContent = map.complete
      ? step > 5 ? `coarse: time steps of ${step} min` : ""
      : `filling, ${Math.round((100 * map.excess_time_h.filter(Boolean).length) / map.excess_time_h.length)} %`;
  }

  /** Value between cells, linear; undefined where it is not known. */
  at(day, lat) {
    const { latitudes_deg: lats, days, excess_time_h: rows } = this.map;
    const place = (axis, v) => {
      const x = Math.min(Math.max((v - axis[0]) / (axis[1] - axis[0]), 0), axis.length - 1);
      const i = Math.min(Math.floor(x), axis.length - 2);
      return [i, x - i];
    };
    let [r, s] = place(lats, lat);
    const [c, t] = place(days, day);
    let [low, high] = [rows[r], rows[r + 1]];
    if (!low && !high) return undefined;
    low ??= high;
    high ??= low;
    const v = (row, k) => row[k] ?? this.beyond;
    return (1 - s) * ((1 - t) * v(low, c) + t * v(low, c + 1)) + s * ((1 - t) * v(high, c) + t * v(high, c + 1));
  }

  /** Bands of the map as an image of its own: two pixels for a day and for a degree. */
  paint() {
    const { latitudes_deg: lats, days, excess_time_h: rows } = this.map;
    const [width, height] = [729, 361];
    const known = rows.map((row) => row && Float32Array.from(row, (v) => v ?? this.beyond));
    const column = new Uint16Array(width);
    const share = new Float32Array(width);
    for (let x = 0; x < width; x += 1) {
      const at = Math.min((1 + x / 2 - days[0]) / (days[1] - days[0]), days.length - 1);
      column[x] = Math.min(Math.floor(at), days.length - 2);
      share[x] = at - column[x];
    }
    const image = new ImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const line = new Float32Array(days.length);
    for (let y = 0, k = 0; y < height; y += 1) {
      const at = (90 - y / 2 - lats[0]) / (lats[1] - lats[0]);
      const row = Math.min(Math.floor(at), lats.length - 2);
      const low = known[row] ?? known[row + 1];
      const high = known[row + 1] ?? known[row];
      if (!low) {
        k += width;
        continue;
      }
      for (let i = 0; i < line.length; i += 1) line[i] = low[i] + (at - row) * (high[i] - low[i]);
      for (let x = 0; x < width; x += 1, k += 1) {
        const i = column[x];
        pixels[k] = this.pixelOf(line[i] + share[x] * (line[i + 1] - line[i]));
      }
    }
    this.image.width = width;
    this.image.height = height;
    this.image.getContext("2d").putImageData(image, 0, 0);
  }

  frame() {
    const { clientWidth: w, clientHeight: h } = this.holder;
    return { x: MARGIN.left, y: MARGIN.top, w: w - MARGIN.left - MARGIN.right, h: h - MARGIN.top - MARGIN.bottom };
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || !height) return;
    const ratio = devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const c = this.canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const f = this.frame();
    c.fillStyle = colour("--grid");
    c.fillRect(f.x, f.y, f.w, f.h);
    if (this.map) c.drawImage(this.image, f.x, f.y, f.w, f.h);
    c.font = `11px ${colour("--sans")}`;
    c.fillStyle = colour("--muted");
    c.textAlign = "center";
    c.textBaseline = "top";
    const x = (day) => f.x + (f.w * (day - 1)) / 364;
    const y = (lat) => f.y + (f.h * (90 - lat)) / 180;
    const letters = f.w < 330;
    MONTHS.forEach((month, i) => {
      const middle = x(MONTH_STARTS[i] + 15);
      c.fillText(letters ? month[0] : month, middle, f.y + f.h + 6);
    });
    c.strokeStyle = "rgba(0, 0, 0, 0.18)";
    c.lineWidth = 1;
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const lat of [-60, -30, 0, 30, 60]) {
      const at = Math.round(y(lat)) + 0.5;
      c.beginPath();
      c.moveTo(f.x, at);
      c.lineTo(f.x + f.w, at);
      c.stroke();
      c.fillText(latitude(lat), f.x - 5, at);
    }
    const { start, values } = this.state;
    if (start[DAY] !== values[DAY] || start[LATITUDE] !== values[LATITUDE]) {
      this.mark(c, x(start[DAY]), y(start[LATITUDE]), 3.5, 1.5);
    }
    this.mark(c, x(values[DAY]), y(values[LATITUDE]), 6, 2.5);
  }

  /** Ring that is seen on any colour. */
  mark(c, x, y, radius, width) {
    for (const [stroke, extra] of [["#fff", 2.5], ["#111", 0]]) {
      c.beginPath();
      c.arc(x, y, radius, 0, 7);
      c.strokeStyle = stroke;
      c.lineWidth = width + extra;
      c.stroke();
    }
  }

  place(event) {
    const box = this.holder.getBoundingClientRect();
    const f = this.frame();
    const share = (v) => Math.min(Math.max(v, 0), 1);
    const day = Math.round(1 + 364 * share((event.clientX - box.left - f.x) / f.w));
    const lat = Math.round(10 * (90 - 180 * share((event.clientY - box.top - f.y) / f.h))) / 10;
    return { [DAY]: day, [LATITUDE]: lat };
  }

  press(event) {
    if (event.button !== 0) return;
    this.holder.setPointerCapture(event.pointerId);
    this.pressed = true;
    // A finger may be about to scroll the page.
    if (event.pointerType !== "touch") this.state.set(this.place(event), "move");
  }

  hover(event) {
    const at = this.place(event);
    if (this.pressed) this.state.set(at, "move");
    this.read(at);
  }

  release(event) {
    if (!this.pressed) return;
    this.pressed = false;
    this.state.set(this.place(event));
  }

  read(at) {
    if (!at || !this.map) {
      this.readout.textContent = "";
      return;
    }
    const value = this.at(at[DAY], at[LATITUDE]);
    const text = value === undefined ? "" : value >= this.scale.unlimited_h ? "unlimited" : hours(value);
    this.readout.textContent = `${date(at[DAY])}, ${latitude(at[LATITUDE])}  ${text}`;
  }

  key(event) {
    const by = event.shiftKey ? 10 : 1;
    const moves = { ArrowLeft: [-by, 0], ArrowRight: [by, 0], ArrowUp: [0, by], ArrowDown: [0, -by] };
    const move = moves[event.key];
    if (!move || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const { values } = this.state;
    const day = ((values[DAY] - 1 + move[0] + 365) % 365) + 1;
    const lat = Math.min(Math.max(Math.round(10 * (values[LATITUDE] + move[1])) / 10, -90), 90);
    this.state.set({ [DAY]: day, [LATITUDE]: lat });
    this.read({ [DAY]: day, [LATITUDE]: lat });
  }
}
