"""What tests read on the explorer's page."""

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
