"""Pictures of pages for README and documentation, made anew by one command.

``python -m benchmarks.pages.screenshots`` writes them to ``docs/images``, with at most 256 colours.
"""

from __future__ import annotations

import io
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from benchmarks.pages.headless import chromium, explorer

if TYPE_CHECKING:
    from playwright.sync_api import Browser

IMAGES = Path(__file__).parents[2] / "docs" / "images"
LARGEST_BYTES = 200_000
AIRCRAFT, MISSION = "atlantiksolar-design", "central-europe-summer"
# A smaller aircraft than the file's, so that the page shows both.
CHANGES = "#battery.mass_kg=2.4&airframe.wingspan_m=4.8&modules.area_m2=1.1"
DESKTOP, PHONE, SHEET = (1400, 860), (390, 844), (1000, 1250)
# The map is exact, and nothing is left to be drawn.
_AT_REST = "() => document.documentElement.dataset.rest === 'true'"


def small_png(png: bytes) -> bytes:
    """Picture of at most 256 colours, without smoothing between them.

    Raises
    ------
    ValueError
        If it is larger than what a page of documentation should load.
    """
    from PIL import Image

    reduced = Image.open(io.BytesIO(png)).convert("RGB").quantize(256, dither=Image.Dither.NONE)
    kept = io.BytesIO()
    reduced.save(kept, "PNG", optimize=True)
    if kept.tell() > LARGEST_BYTES:
        raise ValueError(f"picture of {kept.tell()} bytes; at most {LARGEST_BYTES} are wanted")
    return kept.getvalue()


def picture(
    browser: Browser, address: str, size: tuple[int, int], *, dark: bool = False, wait: bool = True
) -> bytes:
    """Picture of a window on a page.

    Parameters
    ----------
    browser : Browser
    address : str
        Of the page.
    size : (int, int)
        Width and height of the window [px].
    dark : bool
        Whether its reader prefers dark colours.
    wait : bool
        Whether it is an explorer, whose map takes a moment.

    Returns
    -------
    bytes
        PNG.
    """
    page = browser.new_page(
        viewport={"width": size[0], "height": size[1]},
        color_scheme="dark" if dark else "light",
        bypass_csp=True,  # for the function that waits
    )
    page.goto(address)
    if wait:
        page.wait_for_function(_AT_REST)
    png = small_png(page.screenshot())
    page.close()
    return png


def pictures(browser: Browser) -> dict[str, bytes]:
    """All pictures by the name of their file."""
    import missions
    import sizing
    from studies import make_report

    found = {}
    with explorer(AIRCRAFT, "-m", MISSION) as address:
        found["explorer.png"] = picture(browser, address + CHANGES, DESKTOP)
    # Each window of the explorer takes the token of its address, so each has its own server.
    with explorer(AIRCRAFT, "-m", MISSION) as address:
        found["explorer-dark.png"] = picture(browser, address, PHONE, dark=True)
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.html"
        aircraft = sizing.load_aircraft("atlantiksolar-as2")
        report.write_text(make_report(aircraft, missions.load_mission("rafz-july")), "utf-8")
        found["report.png"] = picture(browser, report.as_uri(), SHEET, wait=False)
    return found


@click.command()
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), default=IMAGES)
def main(out: Path) -> None:
    """Write the pictures to a folder, and print their sizes."""
    with chromium() as browser:
        made = pictures(browser)
    out.mkdir(parents=True, exist_ok=True)
    for name, png in made.items():
        (out / name).write_bytes(png)
        click.echo(f"{len(png):7} bytes  {out / name}")


if __name__ == "__main__":
    main()
