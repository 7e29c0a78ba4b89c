// What the explorer's page asks for, computed by the page itself: takes the place of the api.js
// that asks a server.

import { offlineSource } from "./source.js";

const $ = (id) => document.getElementById(id);

/** What is refused, and why. */
export class Refused extends Error {
  constructor(status, error) {
    super(error.message);
    Object.assign(this, { status, kind: error.kind, problems: error.problems ?? [] });
  }
}

/** No answer: never so offline. */
export class Gone extends Error {}

const source = offlineSource(JSON.parse($("offline-tables").textContent));

/** Answer after events that wait, such as those of a slider on its way. */
async function answered(compute) {
  await new Promise((done) => setTimeout(done, 0));
  const { status, body } = compute();
  if (status !== 200) throw new Refused(status, body.error);
  return body;
}

export const live = {
  session: async () => source.session(),
  alive: async () => ({ alive: true }),
  view: (settings, season, sequence) => answered(() => source.view({ settings, season, sequence })),
  size: async () => {
    throw new Refused(422, { kind: "refused", message: source.session().cannot_size });
  },
  files: async () => ({ command: $("command").textContent, files: [] }),
};

/** Say how exact the page is, measured here and now. */
function tell() {
  const found = source.errors();
  const hours = (value) => `${value.toFixed(2)} h`;
  const others = found.other_status;
  $("offline-errors").textContent =
    `At ${found.points} points chosen at random over all sliders, the excess time of this page ` +
    `is within ${hours(found.excess_time_90_h)} of the analysis at nine of ten, and within ` +
    `${hours(found.excess_time_largest_h)} at all` +
    (others ? ` but ${others}, where a small error changes the verdict.` : ".");
  document.documentElement.dataset.errors = JSON.stringify(found);
}
// After the first curve: nobody waits for it.
document.addEventListener("explorer:drawn", () => setTimeout(tell, 300), { once: true });
