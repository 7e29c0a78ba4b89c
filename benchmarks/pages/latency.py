"""How long after a slider's event the explorer has drawn the curve, and the map with it.

The page's own clock counts: from the ``input`` event to the frame in which uPlot has drawn the new
curve, and to the frame in which the map of 37 x 46 cells is painted as well. Frames come 60 times a
second, so half a frame, 8 ms, is waiting for the next one.
"""

from __future__ import annotations

import json
from statistics import median, quantiles
from typing import Any

import click

from benchmarks.pages.headless import chromium, explorer

SLIDERS = ("battery.mass_kg", "airframe.wingspan_m", "mission.latitude_deg")
STEPS = 40
SIZE = (1400, 900)
# uPlot with a hook that tells when it has drawn.
_HOOK = """
let kept;
Object.defineProperty(window, "uPlot", {
  configurable: true,
  get: () => kept,
  set: (plain) => {
    kept = new Proxy(plain, {
      construct(target, [options, ...rest]) {
        const tell = () => { window.curveDrawn = performance.now(); };
        const draw = [...(options.hooks?.draw ?? []), tell];
        return new target({ ...options, hooks: { ...options.hooks, draw } }, ...rest);
      },
    });
  },
});
"""
# One step of a slider: milliseconds until the frame with the curve, and until that with the map.
_STEP = """async ([key, factor]) => {
  const late = performance.now() + 10000;
  const frame = () => new Promise((done, fail) => performance.now() > late
    ? fail(new Error(`nothing drawn for ${key} times ${factor}`)) : requestAnimationFrame(done));
  const slider = document.querySelector(`[data-key="${key}"] input[type=range]`);
  window.begunAt ??= {};
  window.begunAt[key] ??= Number(slider.value);
  while (document.documentElement.dataset.rest !== "true") await frame();
  await frame();
  let map = false;
  const look = (event) => { map ||= event.detail.season !== "none"; };
  document.addEventListener("explorer:drawn", look);
  const begun = performance.now();
  slider.value = factor * window.begunAt[key];
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  while (!(window.curveDrawn > begun)) await frame();
  const curve = performance.now() - begun;
  while (!map) await frame();
  document.removeEventListener("explorer:drawn", look);
  await frame();
  return { curve, map: performance.now() - begun };
}"""


def measured(address: str, steps: int = STEPS) -> dict[str, list[dict[str, float]]]:
    """Times of steps of each slider [ms].

    Parameters
    ----------
    address : str
        Of the page.
    steps : int
        Steps of each slider, up to a tenth from its start.

    Returns
    -------
    dict
        By the slider's key, a record with ``curve`` and ``map`` for each step.
    """
    times: dict[str, list[dict[str, float]]] = {}
    with chromium() as browser:
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        page.add_init_script(_HOOK)
        page.goto(address)
        page.locator("#numbers dd").first.wait_for()
        for key in SLIDERS:
            page.evaluate(_STEP, [key, 1.0])  # the first one warms up
            factors = [0.9 + 0.2 * ((7 * i) % steps) / steps for i in range(steps)]
            times[key] = [page.evaluate(_STEP, [key, factor]) for factor in factors]
    return times


def summary(times: dict[str, list[dict[str, float]]]) -> list[dict[str, Any]]:
    """Median and 90 % quantile of each slider [ms]."""
    return [
        {
            "slider": key,
            "steps": len(steps),
            **{
                f"{what}_{name}_ms": round(value, 1)
                for what in ("curve", "map")
                for name, value in (
                    ("median", median(step[what] for step in steps)),
                    ("90", quantiles((step[what] for step in steps), n=10)[-1]),
                )
            },
        }
        for key, steps in times.items()
    ]


@click.command()
@click.argument("aircraft", default="atlantiksolar-design")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def main(aircraft: str, as_json: bool) -> None:
    """Measure the explorer of AIRCRAFT, and print a table in Markdown, or JSON."""
    with explorer(aircraft) as address:
        rows = summary(measured(address))
    if as_json:
        click.echo(json.dumps(rows, indent=2))
        return
    click.echo("| slider | curve, median | curve, 90 % | map too, median | map too, 90 % |")
    click.echo("| --- | --- | --- | --- | --- |")
    for row in rows:
        cells = [f"{row[f'{w}_{n}_ms']:.0f} ms" for w in ("curve", "map") for n in ("median", "90")]
        click.echo(f"| `{row['slider']}` | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
