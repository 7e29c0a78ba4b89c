// All that leaves the page: requests to the server that it came from.

/** What the server refused, and why. */
export class Refused extends Error {
  constructor(status, error) {
    super(error.message);
    Object.assign(this, { status, kind: error.kind, problems: error.problems ?? [] });
  }
}

/** The server does not answer. */
export class Gone extends Error {}

async function answered(path, options) {
  let response;
  try {
    response = await fetch(path, { credentials: "same-origin", cache: "no-store", ...options });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Gone("the server does not answer");
  }
  let record;
  try {
    record = await response.json();
  } catch {
    throw new Gone("the server broke off");
  }
  if (!response.ok) {
    throw new Refused(response.status, record.error ?? { kind: "http", message: `status ${response.status}` });
  }
  return record;
}

const post = (path, body, signal) =>
  answered(path, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
    signal,
  });

const client = Array.from(crypto.getRandomValues(new Uint32Array(2)), (n) => n.toString(36)).join("");

export const live = {
  /** Names, fields and choices. */
  session: () => answered("api/session"),
  /** Whether the server is there. */
  alive: () => answered("api/alive"),
  /** Day curve, numbers and map: `season` is "none", "coarse" or "exact". */
  view: (settings, season, sequence) => post("api/view", { settings, season, sequence, client }),
  /** Best design. */
  size: (settings, objective, scenarios, signal) =>
    post("api/size", { settings, objective, scenarios }, signal),
  /** Report on the point: name of the file and its text. */
  report: (settings, signal) => post("api/report", { settings }, signal),
  /** Aircraft and mission as YAML, and the command that analyses them. */
  files: (settings) => post("api/files", { settings }),
};
