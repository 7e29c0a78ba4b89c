"""Offline page: the explorer's own parts, tables in place of its server, in one file."""

from __future__ import annotations

import base64
import hashlib
import html
import re
from importlib import resources
from typing import Any

import numpy as np

from missions.files.writing import to_json
from sizing.energy.battery import ChargeClock
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.performance import performance
from sizing.results.quantities import EXCESS_TIME
from sizing.results.records import finite
from sizing.sunlight import DEFAULT_STEP_H
from solar._version import __version__
from studies.explorer.fields import DAY, LATITUDE, Field
from studies.explorer.offline.tables import AXES, Axis, design_table, light_table, mass_table
from studies.explorer.season import (
    COARSE_DAYS,
    COARSE_LATITUDES_DEG,
    COARSE_STEP_H,
    DAYS,
    LATITUDES_DEG,
)
from studies.explorer.session import Inputs, Session
from studies.explorer.settings import RefusedError

# The foot says once why most settings are fixed.
_STYLE = "#offline { margin: 0 14px 10px; } .field.fixed .message { display: none; }"
_IMPORT = re.compile(r'^import \{([^}]*)\} from "\./([\w.]+)";\n', re.M)
_EXPORT = re.compile(r"^export (?=(?:class|const|let|(?:async )?function) (\w+))", re.M)
_FOOT = """\
<section class="panel" id="offline" aria-labelledby="offline-title">
<h2 id="offline-title">A page without a server</h2>
<p>Written by solar-uav {version} for {aircraft} on {mission}. The page interpolates in tables of
light and of designs, and computes the battery's day itself. <span id="offline-errors"></span>
Endurance is that of launches five minutes apart. Settings in grey are fixed here. This page does
not check whether a design is within the ranges of the models; an analysis of it does.</p>
</section>
"""


def offline_page(session: Session) -> str:
    """HTML of a page that needs no server, no other file and no network.

    Returns HTML. Its content security policy allows its own scripts alone and no connection.
    """
    record = offline_record(session)
    parts = _parts()
    page = parts["index.html"]
    foot = _FOOT.format(
        version=__version__,
        aircraft=html.escape(session.aircraft.name),
        mission=html.escape(session.mission.name),
    )
    # JSON in a script element: no text of a file may end it.
    tables = to_json(record, separators=(",", ":")).replace("<", "\\u003c")
    scripts = [parts["vendor/uPlot.iife.min.js"], bundled(parts, "main.js")]
    styles = [parts["vendor/uPlot.min.css"], parts["explorer.css"], _STYLE]
    icon = base64.b64encode(parts["icon.svg"].encode()).decode("ascii")
    head = [
        f'<meta http-equiv="Content-Security-Policy" content="{_policy(scripts, styles)}">',
        *(f"<style>{style}</style>" for style in styles),
    ]
    page = re.sub(r'<link rel="stylesheet"[^>]*>\n|<script [^>]*src=[^>]*></script>\n', "", page)
    page = page.replace('"icon.svg"', f'"data:image/svg+xml;base64,{icon}"')
    page = page.replace('id="save">', 'id="save" hidden>')
    page = page.replace("</head>", "\n".join([*head, "</head>"]))
    page = page.replace("<footer>", f"{foot}<footer>")
    last = [
        f'<script type="application/json" id="offline-tables">{tables}</script>',
        f"<script>{scripts[0]}</script>",
        f'<script type="module">{scripts[1]}</script>',
    ]
    return page.replace("</body>", "\n".join([*last, "</body>"]))


def bundled(parts: dict[str, str], entry: str) -> str:
    """Modules as a single one: browsers load no module from another file without a server.

    ``parts``: text of the modules by name; they import by lines ``import { a, b as c } from
    "./x.js";`` and export what they declare. Returns one module, each part a function of its own.
    """
    done: dict[str, str] = {}

    def add(name: str) -> None:
        text = parts[name]
        if re.search(r"^(import|export) ", _EXPORT.sub("", _IMPORT.sub("", text)), re.M):
            raise ValueError(f"{name}: a form of import or export that is not bundled")
        for _, needed in _IMPORT.findall(text):
            if needed not in done:
                add(needed)
        names = ", ".join(_EXPORT.findall(text))
        body = _EXPORT.sub("", _IMPORT.sub(_taken, text))
        done[name] = f"const {_variable(name)} = (() => {{\n{body}\nreturn {{ {names} }};\n}})();\n"

    add(entry)
    return "".join(done.values())


def _taken(match: re.Match[str]) -> str:
    names = re.sub(r"(\w+) as (\w+)", r"\1: \2", match[1])
    return f"const {{{names}}} = {_variable(match[2])};\n"


def _variable(name: str) -> str:
    return "module_" + name.removesuffix(".js").replace(".", "_")


def _parts() -> dict[str, str]:
    """Files of the explorer's page, and the offline page's own in place of those of their names."""
    parts = {}
    static = resources.files("studies.explorer") / "static"
    own = resources.files("studies.explorer.offline")
    for folder, prefix in ((static, ""), (static / "vendor", "vendor/"), (own, "")):
        for file in folder.iterdir():
            if file.name.endswith((".js", ".css", ".html", ".svg")):
                parts[prefix + file.name] = file.read_text(encoding="utf-8")
    return parts


def _policy(scripts: list[str], styles: list[str]) -> str:
    def hashes(texts: list[str]) -> str:
        digests = (hashlib.sha256(text.encode()).digest() for text in texts)
        return " ".join(f"'sha256-{base64.b64encode(d).decode('ascii')}'" for d in digests)

    return (
        f"default-src 'none'; script-src {hashes(scripts)}; style-src {hashes(styles)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )


CHECKS = 120
_CONSTANT_LOADS = ("mission.payload.power_w", "power.avionics_w")
# Changed by the page without a table: place, and what enters the balance linearly.
_FREE = (
    LATITUDE,
    DAY,
    *_CONSTANT_LOADS,
    "battery.specific_energy_wh_per_kg",
    "mission.required_excess_time_h",
)
_FIXED = "fixed on an offline page"
_CLOCK_POINTS = 401


def offline_record(session: Session, *, checks: int = CHECKS) -> dict[str, Any]:
    """All that an offline page knows, JSON-ready.

    ``checks``: points at which the page compares itself with the analysis. Returns ``session`` as
    :meth:`~studies.explorer.session.Session.describe` gives it, with what is fixed here; ``light``
    ``designs`` and ``masses`` as :mod:`studies.explorer.offline.tables` makes them; ``battery`` and
    ``load``;
    axes of ``season``; ``checks``.
    """
    aircraft, mission = session.aircraft, session.mission
    fields = [_offline_field(one) for one in session.fields.values() if isinstance(one, Field)]
    axes = [
        Axis.between(one["key"], one["minimum"], one["maximum"], one["value"])
        for one in fields
        if one["key"] in AXES and not one["fixed"]
    ]
    design = design_of(aircraft, mission)
    supply = aircraft.power.supply_efficiency
    full = aircraft.battery.battery_energy_wh
    return {
        "session": _described(session, fields),
        "light": light_table(aircraft, mission, session.solar),
        "designs": design_table(aircraft, mission, axes),
        "masses": mass_table(aircraft, mission, axes),
        "battery": {
            "capacity_fraction": float(design.battery_energy_wh) / full,
            "charge_efficiency": float(aircraft.battery.mean_charge_efficiency),
            "discharge_efficiency": float(aircraft.battery.mean_discharge_efficiency),
            "clock": _clock(ChargeClock.of(aircraft.battery.charge_limit)),
        },
        "load": {
            "all_day": mission.turbulence.all_day,
            "thermal": mission.turbulence.thermal,
            "constant_power_w": float(design.constant_power_w),
            "supply_efficiency": supply,
            "keys": list(_CONSTANT_LOADS),
        },
        "rms_relative": session.solar.rms_relative,
        "season": {
            "coarse": [COARSE_LATITUDES_DEG.tolist(), COARSE_DAYS.tolist()],
            "exact": [LATITUDES_DEG.tolist(), DAYS.tolist()],
        },
        "step_h": DEFAULT_STEP_H,
        "coarse_step_h": COARSE_STEP_H,
        "checks": _checks(session, fields, checks),
    }


def _offline_field(field: Field) -> dict[str, Any]:
    """Field as the page gets it: within its slider, or fixed."""
    record = field.to_dict()
    if field.fixed:
        return record
    if field.key in AXES:
        low, high = field.slider
        unit = f" {field.unit}" if field.unit else ""
        words = f"a number from {low:g} to {high:g}{unit}, the range of this page's table"
        return record | {"minimum": low, "maximum": high, "allowed": words}
    return record if field.key in _FREE else record | {"fixed": _FIXED}


def _described(session: Session, fields: list[dict[str, Any]]) -> dict[str, Any]:
    """Session as the page gets it, with one solar power model and no sizing."""
    record = session.describe()
    for choice in record["choices"]:
        for option in choice["options"]:
            if option["name"] != choice["value"]:
                option["reason"] = option["reason"] or _FIXED
    return record | {
        "fields": fields,
        "offline": True,
        "cannot_size": "this page has no server, which a sizing needs",
    }


def _clock(clock: ChargeClock | None) -> dict[str, Any] | None:
    """Charge limit as the page follows it."""
    if clock is None:
        return None
    states = np.linspace(0.0, 1.0, _CLOCK_POINTS)
    hours = np.interp(states, clock.state_of_charge, clock.hours)
    return {
        "state_of_charge": states.tolist(),
        "hours": [float(f"{hour:.8g}") for hour in hours],
        "constant_up_to": clock.constant_up_to,
        "constant_rate_per_h": clock.constant_rate_per_h,
    }


def _checks(session: Session, fields: list[dict[str, Any]], count: int) -> list[dict[str, Any]]:
    """Analyses at points chosen at random, the same every time."""
    chance = np.random.default_rng(1)
    moved = [one for one in fields if not one["fixed"] and one["key"] in (*AXES, *_FREE)]
    checks: list[dict[str, Any]] = []
    while len(checks) < count:
        settings = {}
        for one in moved:
            value = chance.uniform(*one["slider"])
            settings[one["key"]] = round(value) if one["whole"] else float(f"{value:.4g}")
        try:
            made = session.inputs(session.settings(settings))
        except RefusedError:  # settings that contradict each other
            continue
        checks.append({"settings": settings} | _status_and_excess(made))
    return checks


def _status_and_excess(made: Inputs) -> dict[str, Any]:
    """Status and excess time [h] of a point, null where it is unlimited or there is no aircraft."""
    try:
        cycle = performance(made.aircraft, made.mission, made.solar, keep_trajectory=False).cycle
    except ImpossibleDesignError:
        return {"status": "impossible", EXCESS_TIME.name: None}
    hours = float(cycle.excess_time_h[0])
    status = "always_lit" if np.isinf(hours) else "perpetual" if hours > 0.0 else "limited"
    return {"status": status, EXCESS_TIME.name: finite(hours)}
