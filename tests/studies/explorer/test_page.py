"""The explorer's page in a browser: what people do with it, and what it says."""

import http.server
import json
import shlex
import threading
from functools import partial

import pytest
from browser_pages import DESKTOP, PHONE, accessibility_problems, headless, spilled, too_wide

pytestmark = [pytest.mark.browser, pytest.mark.slow]

DESIGN, MISSION = "atlantiksolar-design", "central-europe-summer"
REFUSED = "status of 422"  # the console names every answer that is none


LATITUDE, DAY = "mission.latitude_deg", "mission.day_of_year"


def at_rest(page):
    """The page, once its map is exact; it must have been opened with ``waiting``."""
    page.wait_for_function("document.documentElement.dataset.rest === 'true'")
    return page


def shown(page, label):
    """Number beside a label, with its unit."""
    found = page.locator("#numbers div", has=page.get_by_text(label, exact=True))
    return found.locator("dd").first.inner_text()


def number(page, label):
    """The same without its unit."""
    return float(shown(page, label).split()[0].replace("\u2212", "-"))


def slider(page, key):
    """Slider of a field."""
    return page.locator(f'[data-key="{key}"] input[type=range]')


def typed(page, key, text):
    """Type a number beside a slider, as people do, and wait for what it makes."""
    box = page.locator(f'[data-key="{key}"] input[type=number]')
    box.fill(text)
    box.press("Tab")
    at_rest(page)


@pytest.fixture(scope="module")
def address():
    with headless.explorer(DESIGN, "-m", MISSION) as address:
        yield address


@pytest.fixture(scope="module")
def measured_address():
    """Of an explorer that outlives the page, which looks for its server every few seconds."""
    with headless.explorer("atlantiksolar-as2", "-m", "rafz-july") as address:
        yield address


@pytest.fixture
def page(open_page, address):
    return at_rest(open_page(address, waiting=True))


def curve(page):
    return str(page.locator("#day canvas").evaluate("canvas => canvas.toDataURL()"))


def season(page):
    return str(page.locator("#season canvas").evaluate("canvas => canvas.toDataURL()"))


def excess_of_command(page, run):
    """What the command at the foot of the page prints."""
    words = shlex.split(page.locator("#command").inner_text())
    assert words[0] == "solar-uav"
    return dict(run(*words[1:], "--json").json())


def test_sliders_change_numbers_curve_and_map(page):
    before = number(page, "total mass"), curve(page), season(page)
    mass = slider(page, "battery.mass_kg")
    mass.focus()
    mass.press("PageUp")
    at_rest(page)
    page.wait_for_function("document.querySelector('#numbers .was').textContent !== ''")
    assert number(page, "total mass") > before[0]
    assert curve(page) != before[1]
    assert season(page) != before[2]
    # The start stays beside the changed number.
    was = page.locator("#numbers div", has=page.get_by_text("total mass", exact=True))
    assert was.locator(".was").inner_text() == f"start {before[0]:.2f} kg"


def test_dragging_with_the_pointer(page):
    mass = slider(page, "battery.mass_kg")
    box = mass.bounding_box()
    middle = box["y"] + box["height"] / 2
    before = number(page, "battery")
    page.mouse.move(box["x"] + 0.3 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.9 * box["width"], middle, steps=8)
    page.mouse.up()
    at_rest(page)
    assert number(page, "battery") > 1.5 * before
    assert "battery.mass_kg" in page.url


CHANGES = [
    {"battery.mass_kg": "3.7", "airframe.wingspan_m": "6.2"},
    {LATITUDE: "60", DAY: "300", "mission.payload.power_w": "4"},
]


@pytest.mark.parametrize("changes", CHANGES, ids=lambda c: " ".join(c.values()))
def test_numbers_are_those_of_the_command_below(page, run, changes):
    for key, text in changes.items():
        typed(page, key, text)
    told = excess_of_command(page, run)
    assert number(page, "excess time") == pytest.approx(told["excess_time_h"], abs=0.0051)
    assert number(page, "charge margin") == pytest.approx(told["charge_margin_h"], abs=0.0051)
    assert number(page, "total mass") == pytest.approx(told["total_mass_kg"], abs=0.0051)
    assert number(page, "load") == pytest.approx(told["power_out_w"], abs=0.051)
    charge = 100 * told["minimum_state_of_charge"]
    assert number(page, "min. charge") == pytest.approx(charge, abs=0.051)
    if told["endurance_h"] is None:
        assert shown(page, "endurance") == "unlimited"
    else:
        assert number(page, "endurance") == pytest.approx(told["endurance_h"], abs=0.0051)


def test_saved_files_give_the_same_numbers(page, run, tmp_path):
    typed(page, "battery.mass_kg", "3.3")
    typed(page, LATITUDE, "51")
    page.get_by_role("button", name="Save as YAML").click()
    links = page.locator("#save-files a")
    links.first.wait_for()
    for link in links.all():
        with page.expect_download() as download:
            link.click()
        download.value.save_as(tmp_path / download.value.suggested_filename)
    words = shlex.split(page.locator("#save-command").inner_text())
    told = run(*words[1:], "--json").json()
    assert number(page, "excess time") == pytest.approx(told["excess_time_h"], abs=0.0051)
    assert told["latitude_deg"] == 51.0
    page.keyboard.press("Escape")
    assert not page.locator("#save-dialog").is_visible()


def test_address_restores_the_view(open_page, page, address):
    typed(page, "modules.area_m2", "1.2")
    typed(page, DAY, "200")
    numbers = page.locator("#numbers").inner_text()
    place = page.url.partition("#")[2]
    assert "token" not in page.url
    page.reload()
    at_rest(page)
    assert page.locator("#numbers").inner_text() == numbers
    other = at_rest(open_page(f"{address}#{place}", waiting=True))
    assert other.locator("#numbers").inner_text() == numbers
    page.go_back()
    page.wait_for_function("!location.hash.includes('day_of_year')")
    at_rest(page)
    assert page.locator("#numbers").inner_text() != numbers
    page.get_by_role("button", name="Reset").click()
    page.wait_for_function("location.hash === ''")


@pytest.mark.parametrize(
    ("key", "text", "words"),
    [
        ("battery.mass_kg", "", "must be a number from"),
        (LATITUDE, "91", "must be a number from -90 to 90"),
        (DAY, "12.5", "must be a whole number from 1 to 365"),
        ("modules.area_m2", "3", "must not exceed the wing area of"),
    ],
)
def test_what_is_not_allowed_is_said_beside_the_field(open_page, address, key, text, words):
    page = at_rest(open_page(address, waiting=True, expected=REFUSED))
    box = page.locator(f'[data-key="{key}"] input[type=number]')
    box.fill(text)
    box.press("Tab")
    message = page.locator(f'[data-key="{key}"] .message')
    message.filter(has_text=words).wait_for()
    assert box.get_attribute("aria-invalid") == "true"
    # The verdict is no longer that of what is shown.
    assert page.locator("#verdict-title").inner_text() == "Not possible"
    # And all is well again with the next good number.
    value = page.locator(f'[data-key="{key}"] input[type=range]').get_attribute("aria-valuetext")
    typed(page, key, {LATITUDE: "45", DAY: "100"}.get(key, "1.1"))
    assert box.get_attribute("aria-invalid") is None, value
    assert message.inner_text() == ""


def test_a_page_of_another_address_learns_and_changes_nothing(open_page, address, tmp_path):
    """The same machine, another port: its requests carry the cookie, which must not suffice."""
    page = at_rest(open_page(address, waiting=True, expected="."))  # all of this is an error
    home = address.partition("/?")[0]
    (tmp_path / "index.html").write_text("<!doctype html><title>Other</title>", encoding="utf-8")
    handler = partial(Quiet, directory=str(tmp_path))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page.goto(f"http://127.0.0.1:{server.server_port}/")  # with the cookie of the explorer
        ask = """async ([url, options]) => {
            try { const a = await fetch(url, options); return a.type + ' ' + a.status; }
            catch (error) { return 'failed'; }
        }"""
        body = json.dumps({"settings": {}})
        posted = {"credentials": "include", "method": "POST", "body": body}
        for url, options in (
            (f"{home}/api/session", {"credentials": "include"}),
            (f"{home}/api/session", {"credentials": "include", "mode": "no-cors"}),
            (f"{home}/api/view", {"headers": {"Content-Type": "application/json"}, **posted}),
            (f"{home}/api/view", {"mode": "no-cors", **posted}),
        ):
            assert page.evaluate(ask, [url, options]) == "failed", (url, options)
        server.shutdown()


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def test_end_of_the_server_is_told_and_its_return_noticed(open_page):
    with headless.explorer(DESIGN, "-m", MISSION) as address:
        page = at_rest(open_page(address, waiting=True, expected="ERR_CONNECTION|Failed to load"))
        typed(page, "battery.mass_kg", "3.4")
    slider(page, "battery.mass_kg").press("ArrowRight")
    notice = page.get_by_role("alert")
    notice.wait_for()
    assert "ended or cannot be reached" in notice.inner_text()
    assert page.locator("#connection").inner_text() == "not connected"
    assert number(page, "battery") > 0.0  # what was shown stays


def test_all_of_it_works_by_keyboard(page):
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to the controls"
    reached = set()
    for _ in range(90):
        page.keyboard.press("Tab")
        reached.add(
            page.evaluate(
                "(e => e.id || e.getAttribute('aria-label') || e.tagName)(document.activeElement)"
            )
        )
    assert {"save", "season", "objective", "copy", "field-battery-mass_kg"} <= reached
    page.locator("#season").focus()
    page.keyboard.press("Shift+ArrowUp")
    page.keyboard.press("ArrowRight")
    at_rest(page)
    assert LATITUDE in page.url
    assert DAY in page.url


def test_sizing_moves_the_sliders_and_says_what_limits(page):
    page.locator("#objective").select_option("min_wingspan")
    page.get_by_role("button", name="Size it").click()
    page.locator("#sizing-result .good").wait_for()
    assert "Limited by" in page.locator("#sizing-result").inner_text()
    at_rest(page)
    assert "airframe.wingspan_m" in page.url
    assert page.locator("#verdict-title").inner_text().startswith("Perpetual")
    assert accessibility_problems(page) == []
    # A result belongs to its settings: it is greyed while others are shown.
    result = page.locator("#sizing-result")
    assert "moved" not in (result.get_attribute("class") or "")
    battery = page.locator('[data-key="battery.mass_kg"] input[type=number]')
    before = battery.input_value()
    typed(page, "battery.mass_kg", "1.1")
    assert "moved" in (result.get_attribute("class") or "")
    page.go_back()
    at_rest(page)
    assert battery.input_value() == before
    assert "moved" not in (result.get_attribute("class") or "")
    # It is kept over a reload, and offers the design with a margin.
    text = result.inner_text()
    page.reload()
    at_rest(page)
    assert result.inner_text() == text
    assert "moved" not in (result.get_attribute("class") or "")
    page.get_by_role("button", name="Move the sliders to this one").click()
    at_rest(page)
    assert page.locator("#verdict-title").inner_text() == "Perpetual flight"


def test_limited_flight_shows_its_discharge_and_what_would_help(page):
    assert not page.get_by_text("longest flight, launched full").is_visible()
    typed(page, "battery.mass_kg", "1.2")
    assert page.locator("#verdict-title").inner_text() == "Limited flight"
    assert page.get_by_text("longest flight, launched full").is_visible()
    page.get_by_role("button", name="What would it take?").click()
    page.locator("#sizing-result .good").wait_for()
    ways = page.locator("#sizing-result li", has_text="battery mass at least")
    ways.get_by_role("button").click()
    at_rest(page)
    assert page.locator("#verdict-title").inner_text().startswith("Perpetual")


@pytest.mark.parametrize(
    ("size", "dark"),
    [(PHONE, True), (DESKTOP, False), ((768, 1024), True)],
    ids=["phone, dark", "desktop, light", "tablet, dark"],
)
def test_any_window_in_light_and_dark(open_page, address, size, dark):
    page = at_rest(open_page(address, size=size, dark=dark, waiting=True))
    assert too_wide(page) == []
    slider(page, "battery.mass_kg").press("PageUp")
    at_rest(page)
    assert too_wide(page) == []
    assert accessibility_problems(page) == []


def test_nothing_hangs_out_of_its_panel(page):
    for width, height in ((1280, 760), (1366, 768), (1400, 860), (1920, 1080), (1024, 768), PHONE):
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("() => new Promise(done => setTimeout(done, 60))")
        assert spilled(page, ".panel:not(.controls, .sizing), .verdict") == [], (width, height)
        assert too_wide(page) == [], (width, height)


def test_each_field_says_what_it_is(page):
    words = page.locator("#field-airframe-wingspan_m-about")
    assert not words.is_visible()
    button = page.get_by_role("button", name="About wingspan")
    button.click()
    assert "Tip to tip" in words.inner_text()
    assert button.get_attribute("aria-expanded") == "true"
    assert accessibility_problems(page) == []
    assert page.get_by_role("button", name="About ").count() == len(page.locator(".field").all())


def test_measured_aircraft_says_what_it_cannot(open_page, measured_address):
    page = at_rest(open_page(measured_address, waiting=True))
    assert slider(page, "airframe.wingspan_m").is_disabled()
    assert page.get_by_role("button", name="Size it").is_disabled()
    assert "measured airframe cannot be sized" in page.locator("#sizing-result").inner_text()
    assert accessibility_problems(page) == []
