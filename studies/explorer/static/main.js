// The explorer: settings change, the server is asked, the page is drawn.

import { Gone, live as api } from "./api.js";
import { Controls } from "./controls.js";
import { Day } from "./day.js";
import { element } from "./format.js";
import { Masses } from "./masses.js";
import { Numbers } from "./numbers.js";
import { Season } from "./season.js";
import { Sizing } from "./sizing.js";
import { State } from "./state.js";

const REST_MS = 160; // without a change, before the map is computed exactly
const RETRY_MS = 2000;
const LOOK_MS = 5000;
const $ = (id) => document.getElementById(id);
const root = document.documentElement;

// The token has become a cookie; it need not stay in the address and the history.
if (new URLSearchParams(location.search).has("token")) {
  history.replaceState(null, "", location.pathname + location.hash);
}

/** Whether the server is there, and what to do about it. */
class Connection {
  constructor(pill, back) {
    Object.assign(this, { pill, back, there: true });
    setInterval(() => {
      if (this.there && document.visibilityState === "visible") this.look();
    }, LOOK_MS);
    document.addEventListener("visibilitychange", () => this.look());
  }

  async look() {
    try {
      await api.alive();
      this.found();
    } catch (error) {
      this.lost(error);
    }
  }

  found() {
    if (this.there) return;
    this.there = true;
    this.pill.textContent = "";
    $("notice").hidden = true;
    root.classList.remove("gone");
    this.back();
  }

  lost(error) {
    const gone = error instanceof Gone;
    if (!gone && error.status !== 403) return;
    this.there = false;
    root.classList.add("gone");
    this.pill.textContent = "not connected";
    $("notice").textContent = gone
      ? "The explorer has ended or cannot be reached. The page keeps its settings and goes on by itself as soon as the server is back."
      : "Another explorer answers here, with another token. Open the address that it printed; this page then goes on by itself.";
    $("notice").hidden = false;
    clearTimeout(this.retry);
    this.retry = setTimeout(() => this.look(), RETRY_MS);
  }
}

/**
 * Asks for views, one at a time: the curve of the latest settings, then the coarse map of the same,
 * and the exact map once all rests. Answers to older jumps are dropped.
 */
class Live {
  constructor(state, draw, refuse, connection) {
    Object.assign(this, { state, draw, refuse, connection, sequence: 0, generation: 0 });
    state.addEventListener("change", (event) => {
      const { how } = event.detail;
      const key = JSON.stringify(state.changes());
      // A slider that comes to rest has been asked for where it is.
      if (how === "commit" && key === this.key) return;
      this.key = key;
      if (how === "jump" || how === "restore") {
        this.generation += 1;
        this.mapless = undefined;
      }
      this.want();
    });
    state.addEventListener("refused", ({ detail }) => {
      // What is shown belongs to other values: no answer on its way may say otherwise.
      this.generation += 1;
      this.key = this.mapless = undefined;
      this.stale = this.rested = false;
      clearTimeout(this.rest);
      refuse({ kind: "refused", message: detail.message, problems: [detail] });
      root.dataset.rest = "true";
    });
  }

  want() {
    this.stale = true;
    this.rested = false;
    root.dataset.rest = "false";
    clearTimeout(this.rest);
    this.next();
  }

  /** What is asked for next: `season` as in the request, and the settings. */
  task() {
    // A slider on its way must not leave the map behind: each curve is followed by its map.
    const behind = this.mapless;
    this.mapless = undefined;
    if (behind) return { season: "coarse", settings: behind };
    if (!this.stale && !this.rested) return undefined;
    const season = this.stale ? "none" : "exact";
    this.stale = this.rested = false;
    return { season, settings: this.state.changes() };
  }

  async next() {
    if (this.asking || !this.connection.there) return;
    const task = this.task();
    if (!task) return;
    const { season, settings } = task;
    const { generation } = this;
    this.asking = true;
    this.sequence += 1;
    let drawn;
    try {
      const view = await api.view(settings, season, this.sequence);
      if (generation === this.generation) {
        this.draw(view, season);
        drawn = view;
      }
    } catch (error) {
      if (error instanceof Gone || error.status === 403) this.connection.lost(error);
      else if (error.kind !== "superseded" && generation === this.generation) {
        this.refuse(error);
        if (!this.stale) root.dataset.rest = "true";
      }
    }
    this.asking = false;
    if (drawn && season === "none") this.mapless = settings;
    else if (drawn && !this.stale) {
      if (season === "exact" && drawn.season.complete) root.dataset.rest = "true";
      else this.look(season === "coarse" ? REST_MS : 0);
    }
    this.next();
  }

  /** Ask for the exact map after a while without a change. */
  look(after) {
    this.rest = setTimeout(() => {
      this.rested = true;
      this.next();
    }, after);
  }
}

async function begin() {
  const session = await api.session();
  const state = new State(session);
  const first = await api.view({}, "none", 0);
  $("aircraft-name").textContent = session.aircraft.name;
  $("mission-name").textContent = session.mission.name;
  $("aircraft-name").title = session.aircraft.description;
  $("mission-name").title = session.mission.description;
  $("version").textContent = `solar-uav ${session.version}`;
  document.title = `${session.aircraft.name} on ${session.mission.name} \u2013 solar-uav explore`;

  const controls = new Controls($("controls"), state);
  const { climbs, wind } = session.mission;
  const numbers = new Numbers($("numbers"), $("verdict-title"), $("verdict-text"), { climbs, wind });
  const day = new Day($("day"), $("day-legend"), $("day-readout"), $("day-words"), climbs);
  const season = new Season($("season"), $("season-readout"), $("season-legend"), $("season-detail"), state, session.season_scale);
  const masses = new Masses($("masses"), $("masses-total"), session.aircraft.measured);
  const sizing = new Sizing($("sizing"), $("sizing-result"), session, state, api);

  const draw = (view, detail) => {
    let sentence;
    // A coarse map follows the curve of the same settings, which is drawn.
    if (detail !== "coarse") {
      controls.forgive();
      root.classList.remove("stale");
      sentence = numbers.show(view, first, state.values["mission.required_excess_time_h"]);
      mini(numbers.short);
      day.show(view, first, Object.keys(state.changes()).length > 0);
      masses.show(view, first);
      sizing.fly(view.numbers);
      $("notes").replaceChildren(...view.notes.map((note) => element("li", {}, note)));
      $("notes").hidden = !view.notes.length;
    }
    if (view.season) season.show(view.season);
    if (detail === "exact") {
      $("announce").textContent = sentence;
      day.say();
    }
    root.dataset.sequence = view.sequence;
    root.dataset.season = detail;
    document.dispatchEvent(new CustomEvent("explorer:drawn", { detail: { sequence: view.sequence, season: detail } }));
  };
  // On a phone the verdict stays in sight with the curve.
  const mini = (words) => {
    $("day-verdict").textContent = words;
    $("day-verdict").dataset.mood = $("verdict-title").dataset.mood;
  };
  const refuse = (error) => {
    controls.forgive();
    root.classList.add("stale");
    const inWords = (text) => text.replaceAll("m2", "m\u00b2");
    for (const { field, message, allowed } of error.problems) {
      controls.complain(field, inWords(allowed ? `${message}: ${allowed}` : message));
    }
    const heads = { impossible: "Cannot fly", contradiction: "Not possible", refused: "Not possible" };
    const [wrong] = error.problems;
    const label = state.fields.get(wrong?.field)?.label;
    const words = wrong ? `${label ? `${label} ` : ""}${wrong.message}` : error.message;
    const head = heads[error.kind] ?? "Not computed";
    numbers.refuse(head, `${inWords(words)}. Curves and numbers are those before.`);
    mini(head);
    $("announce").textContent = error.message;
  };
  const connection = new Connection($("connection"), async () => {
    // Another explorer may have taken the place of the one that this page belongs to.
    const now = await api.session().catch(() => session);
    if (JSON.stringify(now) === JSON.stringify(session)) asked.want();
    else location.reload();
  });
  const asked = new Live(state, draw, refuse, connection);

  const follow = () => {
    season.draw();
    $("reset").disabled = !Object.keys(state.changes()).length;
    command(session, state);
  };
  state.addEventListener("change", follow);
  follow();
  addEventListener("popstate", () => state.restore());
  addEventListener("hashchange", () => state.restore());
  $("reset").addEventListener("click", () => state.reset());
  $("save").addEventListener("click", () => save(state));
  $("report").addEventListener("click", () => report(state));
  $("copy").addEventListener("click", async () => {
    await navigator.clipboard.writeText($("command").textContent);
    $("copy").textContent = "Copied";
    setTimeout(() => ($("copy").textContent = "Copy"), 1500);
  });
  asked.want();
}

/** Command line of what is seen. */
function command(session, state) {
  const quote = (text) => (/^[\w./=-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
  const words = ["solar-uav", "analyse", ...session.command];
  const several = session.mission.scenarios.length > 1;
  for (const [key, option] of [["mission.latitude_deg", "--latitude"], ["mission.day_of_year", "--day-of-year"]]) {
    if (several || state.values[key] !== state.start[key]) words.push(option, String(state.values[key]));
  }
  for (const [key, value] of Object.entries(state.changes())) {
    if (state.fields.has(key) && !(key === "mission.latitude_deg" || key === "mission.day_of_year")) {
      words.push("--set", `${key}=${value}`);
    }
  }
  for (const key of state.choices.keys()) {
    const usual = { model: "CAM", correction: "none" }[key];
    if (state.values[key] !== usual || state.start[key] !== usual) words.push(`--${key}`, state.values[key]);
  }
  $("command").textContent = words.map(quote).join(" ");
}

/** Make a report, which takes some seconds, and offer it as a file. */
async function report(state) {
  const button = $("report");
  button.disabled = true;
  button.textContent = "Reporting \u2026";
  try {
    const { name, text } = await api.report(state.changes());
    const href = URL.createObjectURL(new Blob([text], { type: "text/html" }));
    element("a", { href, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(href), 60000);
    $("announce").textContent = `Saved ${name}.`;
  } catch (error) {
    tell(`The report cannot be made: ${error.message}.`);
  } finally {
    button.disabled = false;
    button.textContent = "Report";
  }
}

/** Show a message that is not about the connection, for a while. */
function tell(words) {
  if (root.classList.contains("gone")) return;
  $("notice").textContent = words;
  $("notice").hidden = false;
  setTimeout(() => {
    if ($("notice").textContent === words) $("notice").hidden = true;
  }, 8000);
}

async function save(state) {
  let saved;
  try {
    saved = await api.files(state.changes());
  } catch (error) {
    tell(`The files cannot be made: ${error.message}.`);
    return;
  }
  $("save-command").textContent = saved.command;
  const links = saved.files.map(({ name, text }) => {
    const href = URL.createObjectURL(new Blob([text], { type: "application/yaml" }));
    return element("a", { className: "button", href, download: name }, name);
  });
  $("save-files").replaceChildren(...links);
  $("save-dialog").showModal();
  $("save-dialog").addEventListener("close", () => links.forEach((link) => URL.revokeObjectURL(link.href)), { once: true });
}

begin().catch((error) => {
  $("notice").hidden = false;
  $("notice").textContent = error instanceof Gone ? "The explorer does not answer." : error.message;
});
