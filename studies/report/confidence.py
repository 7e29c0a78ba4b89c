"""Sections on how far the results may be trusted, and on what went into them.

Margins: how much worse each assumption may become before perpetual flight ends, or how much better.
One quantity at a time is moved until the weakest scenario just has the required excess time; all
else stays as it is. The sun is not computed anew: none of the quantities changes it but by a
factor.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from math import isnan
from typing import NamedTuple

import numpy as np

from missions.files.writing import to_yaml
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.metrics import Cycle
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.parameters import with_parameter
from sizing.performance import performance
from sizing.results.result import relative_change
from sizing.roots import bracketed_root
from solar.names import MODELS
from solar.types import FloatArray
from studies.quantities import TABLE
from studies.render.tables import Column, Line, Table, facts
from studies.render.words import percent, required
from studies.report.blocks import Block, Listing, Section
from studies.report.subject import Subject


def margins_section(subject: Subject) -> Section:
    """Return how much worse each assumption may become."""
    text = (
        "Each quantity changes alone until the weakest scenario just meets the requirement; all "
        "else stays as it is, the mass with the battery's specific energy as well."
    )
    table = margin_table(subject)
    if table is None:
        text = (
            "None: the weakest scenario has just what is required. A little less of any quantity, "
            "of the sun or the battery, ends it."
        )
        return Section("margins", "Margins", [Line(text, "warning")])
    return Section("margins", "Margins", [table, Line(text, "faint")])


def belief_section(subject: Subject) -> Section:
    """Return what is extrapolated, the solar models' errors, and what is left out."""
    blocks: list[Block] = []
    if subject.verification is None:
        within = Line("Nothing lies outside the range of a model.", "good")
        blocks = [
            *subject.sections["warnings"],
            *(subject.sections["extrapolations"] or [within]),
            *subject.sections["error"],
        ]
    columns = (
        Column("model"),
        Column("average", "mean error", form="+.2%"),
        Column("rms", "RMS error", form=".2%"),
        Column("scatter", "RMS without the mean", form=".2%"),
    )
    rows = tuple((model, of.average, of.rms, of.scatter) for model, of in MODELS.items())
    note = (
        "of the mean measured power; one flight of AtlantikSolar AS-2, 47.6° N, 1 July 2015, "
        "sunrise to 9.72 h (Oettershagen, High-Fidelity Solar Power Income Modeling, table 3)"
    )
    blocks.append(Table("published errors of the solar power models", columns, rows, (note,)))
    left_out = [f"- {text}" for text in _left_out(subject)]
    return Section("belief", "Confidence", [*blocks, *left_out])


def _left_out(subject: Subject) -> Iterator[str]:
    """Yield what the numbers of the report leave out."""
    mission, clearness = subject.mission, subject.mission.pessimistic_clearness
    sky = f"The light is {percent(clearness, '.0f')} of a clear sky's"
    sky = "The sky is clear" if clearness == 1.0 else sky
    yield f"{sky} all day; a weather record (--weather) adds clouds."
    if subject.verification is None:
        yield (
            "The day repeats itself: the date does not advance, and the battery's state at dawn is "
            "that of the settled cycle."
        )
        if subject.aircraft.battery.ageing is None:
            yield "The battery is new: the aircraft file has no ageing."
        if mission.holds_station:
            yield "The wind is steady: faster flight against it takes as much all day."
        elif mission.turbulence.all_day == 0.0 and mission.turbulence.thermal == 0.0:
            yield "The air is calm: level flight takes no more power than in still air."
        asked = subject.with_uncertainty is not None or not subject.has_uncertain_inputs
        if not asked and not subject.uncertainty_is_quick:
            count = len(mission.scenarios())
            yield f"Uncertain inputs: left out, {count} scenarios take long (--uncertainty)."
    if mission.uncertainty_margins.is_set:
        yield "The mission's uncertainty margins are taken off every number here."


def glossary_section(_: Subject) -> Section:
    """Return the words of the report: quantities, and solar power models."""
    models = "; ".join(f"{name}: {model.label}" for name, model in MODELS.items())
    rows = [
        ("perpetual flight", "After each day the battery is as full as a day before."),
        *(
            (quantity.label, quantity.definition)
            for quantity in TABLE.values()
            if quantity.definition
        ),
        (
            "scenario",
            "A latitude and a date of the mission; the weakest has the least excess time.",
        ),
        ("solar power models", f"{models}."),
        ("correction", "Factor that removes a model's systematic error."),
    ]
    columns = (Column("word"), Column("meaning"))
    return Section("glossary", "Glossary", [Table("Words", columns, tuple(rows))])


def inputs_section(subject: Subject) -> Section:
    """Return aircraft and mission as they were used."""
    blocks: list[Block] = []
    if subject.overrides:
        blocks.append("Values given in place of the files' own:")
        blocks += [f"- {override}" for override in subject.overrides]
    if subject.mission_is_default:
        blocks.append(Line("The mission is the default one: --mission names another.", "warning"))
    taken = subject.aircraft.from_catalogues()
    if taken:
        columns = (Column("key"), Column("value"), Column("label", "product"), Column("source"))
        rows = [(entry.key, entry.text, entry.label, entry.source) for entry in taken]
        blocks.append(Table("values from catalogues", columns, tuple(rows)))
    for title, data in (
        (f"aircraft {subject.aircraft.name}", subject.inputs.aircraft),
        (f"mission {subject.mission.name}", subject.inputs.mission),
    ):
        blocks.append(Listing(title, to_yaml(data, compact=True)))
    return Section("inputs", "Inputs", blocks)


def provenance_section(subject: Subject) -> Section:
    """Return the command line, software and files of the report."""
    run = subject.run
    made = [
        ("date (UTC)", run["date_utc"].replace("T", " ").removesuffix("+00:00")),
        ("solar-uav", run["version"]),
        ("Python", run["python"]),
    ]
    if subject.verification is None:
        made.insert(0, ("solar power model", subject.solar.label))
    columns = (Column("what"), Column("source", "file"), Column("sha256", "SHA-256"))
    files = [
        (kind, file["source"], file["sha256"] or "not read again (a pipe)")
        for kind, file in run["inputs"].items()
    ]
    return Section(
        "provenance",
        "How this report was made",
        [
            Listing("command line", run["command"]),
            (facts("software", made), facts("libraries", list(run["libraries"].items()))),
            Table("files", columns, tuple(files)),
        ],
    )


# The weakest scenarios, of which one remains the weakest.
_SCENARIOS = 6
_NO_MARGIN = 1e-3  # of a value, or in its unit: what a design on the edge has
_TOLERANCE = 1e-4  # of a limit
_NOT_FLYING_H = -24.0  # what lacks where no design closes


class _Quantity(NamedTuple):
    """A quantity that is moved: words, unit, value of the files, and ends of its range.

    ``worse`` is the end at which nothing flies, ``better`` the other one. ``key``: of the parameter
    that is moved, by ``scale``; none of the sun.
    """

    label: str
    unit: str
    value: float
    worse: float
    better: float
    key: str = ""
    scale: float = 1.0


def margin_table(subject: Subject) -> Table | None:
    """Return the margin of every quantity to the end of perpetual flight, or its gap.

    Without those that have next to none; None where that is true of all.
    """
    nominal = subject.analysis.performance
    weakest = np.argsort(nominal.cycle.excess_time_h, kind="stable")[:_SCENARIOS]
    day = nominal.day.at(weakest)
    required_h = max(subject.mission.required_excess_time_h, 0.0)
    now_h = _spare_h(nominal.cycle, required_h)
    holds = now_h >= 0.0
    quantities = _quantities(subject.aircraft, subject.mission)

    @cache
    def spare_h(number: int, value: float) -> float:
        """Return the excess time beyond what is required with one quantity at a value."""
        if value == quantities[number].value:
            return now_h
        moved, (aircraft, mission) = quantities[number], (subject.aircraft, subject.mission)
        if moved.key:
            aircraft, mission = with_parameter(aircraft, mission, moved.key, moved.scale * value)
        try:
            if mission.ceiling_m > mission.altitude_m:
                design_of(aircraft, mission.at_altitude(mission.ceiling_m))
            light = day if moved.key else day.scaled(moved.scale * value)
            cycle = performance(aircraft, mission, day=light, keep_trajectory=False).cycle
        except ImpossibleDesignError:
            return _NOT_FLYING_H
        return _spare_h(cycle, required_h)

    def of_all(values: FloatArray) -> FloatArray:
        each = enumerate(values.tolist())
        return np.array([np.nan if isnan(value) else spare_h(i, value) for i, value in each])

    ends = [quantity.worse if holds else quantity.better for quantity in quantities]
    now = np.array([quantity.value for quantity in quantities])
    limits = bracketed_root(of_all, now, np.array(ends), _TOLERANCE)
    rows = []
    for quantity, found in zip(quantities, limits.tolist(), strict=True):
        limit = None if isnan(found) else found
        change = None if limit is None else limit - quantity.value
        scale = max(abs(quantity.value), 100.0 if quantity.unit == "%" else 1.0)
        if change is not None and abs(change) <= _NO_MARGIN * scale:
            continue
        relative = None if limit is None else relative_change(quantity.value, limit)
        percent = None if relative is None else 100.0 * relative
        rows.append((quantity.label, quantity.unit, quantity.value, limit, change, percent))
    if not rows:
        return None
    what = "may become" if holds else "would have to become"
    than = required(required_h)
    columns = (
        Column("quantity"),
        Column("unit"),
        Column("value", "now", form=".4g"),
        Column("limit", what, form=".4g", missing="no limit" if holds else "not enough alone"),
        Column("change", form="+.3g"),
        Column("relative", "change", "%", "+z.0f"),
    )
    title = f"{'margins to the end of' if holds else 'what is missing for'} {than}, one at a time"
    return Table(title, columns, tuple(rows))


def _quantities(aircraft: Aircraft, mission: Mission) -> list[_Quantity]:
    """Return the quantities that are moved: sun, battery, propulsion, loads, payload."""
    battery, avionics = aircraft.battery.specific_energy_wh_per_kg, aircraft.power.avionics_w
    extra, payload, percent = 100.0 * mission.turbulence.all_day, mission.payload.mass_kg, 0.01
    return [
        _Quantity("solar power, relative to the model", "%", 100.0, 0.0, 400.0, "", percent),
        _Quantity("specific energy of the battery", "Wh/kg", battery, 0.01 * battery, 4.0 * battery,
                  "battery.specific_energy_wh_per_kg"),
        _Quantity("propulsion power, beyond level flight", "%", extra, 400.0, -90.0,
                  "mission.turbulence.all_day", percent),
        _Quantity("avionics power", "W", avionics, 1e3 + 10.0 * avionics, 0.0, "power.avionics_w"),
        _Quantity("payload mass", "kg", payload, payload + 50.0, 0.0, "mission.payload.mass_kg"),
    ]  # fmt: skip


def _spare_h(cycle: Cycle, required: float) -> float:
    """Return the least excess time beyond what is required [h]; negative where one falls short."""
    spare_h = np.clip(cycle.excess_time_h - required, _NOT_FLYING_H, -_NOT_FLYING_H)
    # At the end of perpetual flight it may be just zero.
    return float(np.min(np.where(cycle.sufficient, spare_h, np.minimum(spare_h, -_NO_MARGIN))))
