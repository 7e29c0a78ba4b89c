"""Published masses of aircraft of 3 to 75 m beside the rib wing's: data in ``structures.yaml``."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import yaml

from benchmarks.validation.built_aircraft import calibrated_rib_wing
from missions.air import GRAVITY_M_PER_S2, gust_speed_fraction, standard_air
from sizing.structures.build import build_qualities
from sizing.structures.loads import StructureInputs
from sizing.structures.models import SPAR_CALIBRATION, SparStructure, StructureModel
from sizing.structures.rib_wing import RibWingStructure
from solar.types import FloatArray
from studies.render.tables import Column, Table

_CARRIED = ("battery", "modules", "propulsion", "systems")
# The mass of an aircraft that cannot carry itself grows beyond this multiple of the published one.
_DIVERGED = 20.0
_ITERATIONS = 200


@dataclass(frozen=True)
class Interval:
    """Numbers from ``low`` to ``high``."""

    low: float
    high: float

    @classmethod
    def around(cls, values: FloatArray) -> Interval:
        """Smallest interval with all the values."""
        return cls(float(np.min(values)), float(np.max(values)))

    @property
    def middle(self) -> float:
        """Centre."""
        return (self.low + self.high) / 2.0

    @property
    def geometric_middle(self) -> float:
        """Centre of the logarithms."""
        return float(np.sqrt(self.low * self.high))

    def gap(self, other: Interval) -> float:
        """How far this interval lies above another [-], relative to its middle; 0 if they meet.

        Negative where it lies below.
        """
        above, below = self.low - other.high, other.low - self.high
        return max(above, 0.0) / other.middle - max(below, 0.0) / other.middle

    def text(self, digits: int = 3) -> str:
        """Interval in a table."""
        low, high = (_rounded(end, digits) for end in (self.low, self.high))
        return low if low == high else f"{low} to {high}"


def _rounded(value: float, digits: int) -> str:
    if not np.isfinite(value):
        return "infinite"
    shown = f"{value:.{digits}g}"
    return f"{float(shown):g}" if "e" in shown else shown


@dataclass(frozen=True)
class PublishedStructure:
    """An aircraft with published masses, and the keys of its rib wing."""

    name: str
    numbers: Mapping[str, Interval]
    along_the_span: Mapping[str, float]
    models: tuple[RibWingStructure, ...]
    calibrates: bool = False

    @property
    def total_kg(self) -> Interval:
        """Published total mass."""
        return self.numbers["total_mass_kg"]

    @property
    def structure_kg(self) -> Interval:
        """Published total mass less all that is carried."""
        carried = [self.numbers[f"{name}_kg"] for name in _CARRIED]
        total = self.total_kg
        return Interval(
            total.low - sum(one.high for one in carried),
            total.high - sum(one.low for one in carried),
        )

    def corners(self) -> dict[str, FloatArray]:
        """All combinations of the ends of the numbers."""
        ends = [dict.fromkeys((one.low, one.high)) for one in self.numbers.values()]
        table = np.array(list(itertools.product(*ends))).T
        return dict(zip(self.numbers, table, strict=True))

    def inputs(self, corners: Mapping[str, FloatArray], total_kg: FloatArray) -> StructureInputs:
        """What a structure is sized from, with a total mass."""
        span_m, area_m2 = corners["wingspan_m"], corners["wing_area_m2"]
        density = np.asarray(standard_air(corners["altitude_m"]).density_kg_per_m3)
        loading = total_kg * GRAVITY_M_PER_S2 / area_m2
        along = {name: share * corners[f"{name}_kg"] for name, share in self.along_the_span.items()}
        battery_kg = along.get("battery", 0.0 * span_m)
        return StructureInputs(
            wingspan_m=span_m,
            aspect_ratio=span_m**2 / area_m2,
            total_mass_kg=total_kg,
            span_load_kg=sum(along.values(), 0.0 * span_m),
            airspeed_m_per_s=(2.0 * loading / (density * corners["lift_coefficient"])) ** 0.5,
            density_kg_per_m3=density,
            wing_battery_kg=battery_kg,
            pod_battery_kg=corners["battery_kg"] - battery_kg,
            gust_fraction=gust_speed_fraction(corners["altitude_m"]),
        )

    def computed_structure_kg(self, models: Sequence[StructureModel]) -> Interval:
        """Structure at the published total mass."""
        corners = self.corners()
        inputs = self.inputs(corners, corners["total_mass_kg"])
        return Interval.around(np.array([model.mass_kg(inputs) for model in models]))

    def computed_total_kg(self, models: Sequence[StructureModel]) -> Interval:
        """Total mass that closes the budget with what the aircraft carries."""
        corners = self.corners()
        carried = np.sum([corners[f"{name}_kg"] for name in _CARRIED], axis=0)
        return Interval.around(
            np.array([self._closed_kg(model, corners, carried) for model in models])
        )

    def _closed_kg(
        self, model: StructureModel, corners: Mapping[str, FloatArray], carried: FloatArray
    ) -> FloatArray:
        most, total = _DIVERGED * self.total_kg.high, carried
        for _ in range(_ITERATIONS):
            before = total
            total = carried + np.asarray(model.mass_kg(self.inputs(corners, before)))
            total = np.minimum(total, most)
            if np.allclose(total, before, rtol=1e-7, atol=0.0):
                break
        return np.where(total < most, total, np.inf)


@cache
def published_structures(group: str = "aircraft") -> Mapping[str, PublishedStructure]:
    """Aircraft of a group of ``structures.yaml`` by their keys: ``aircraft``, ``hand_built``."""
    text = resources.files(__package__).joinpath("structures.yaml").read_text(encoding="utf-8")
    return {key: _from_record(record) for key, record in yaml.safe_load(text)[group].items()}


def _from_record(record: Mapping[str, Any]) -> PublishedStructure:
    base = {
        "model": "rib_wing",
        "calibration": calibrated_rib_wing().calibration,
        **record["construction"],
    }
    return PublishedStructure(
        name=record["name"],
        numbers={key: Interval(*_ends(one)) for key, one in record["numbers"].items()},
        along_the_span=record["along_the_span"],
        models=tuple(
            RibWingStructure.model_validate(base | keys)
            for keys in _combinations(record.get("structure", {}))
        ),
        calibrates=record.get("calibrates", False),
    )


def _ends(number: Mapping[str, Any]) -> tuple[Any, Any]:
    return (number["value"],) * 2 if "value" in number else (number["low"], number["high"])


def _combinations(keys: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Keys with all combinations of the ends of their intervals, records within included."""
    choices: list[list[Any]] = []
    for one in keys.values():
        if "source" in one:
            choices.append(list(dict.fromkeys(_ends(one))))
        else:
            choices.append(list(_combinations(one)))
    for chosen in itertools.product(*choices):
        yield dict(zip(keys, chosen, strict=True))


def spar_models() -> tuple[StructureModel, ...]:
    """The simpler model, calibrated by the same aircraft."""
    return (SparStructure(calibration=SPAR_CALIBRATION),)


def build_ratio(one: PublishedStructure) -> float:
    """Published structure over the rib wing's, of the geometric middles of their intervals [-]."""
    computed = one.computed_structure_kg(one.models)
    return one.structure_kg.geometric_middle / computed.geometric_middle


def qualities_table() -> Table:
    """Factor of each class, with the aircraft that :func:`structures_table` does not have."""
    by_name = {one.name: one for one in published_structures("hand_built").values()}
    rows: list[tuple[str, ...]] = []
    for name, quality in build_qualities().items():
        for one in (by_name[key] for key in quality.aircraft if key in by_name):
            masses = one.structure_kg, one.computed_structure_kg(one.models)
            span = one.numbers["wingspan_m"].text()
            ratio = f"{build_ratio(one):.2f}"
            rows.append((f"`{name}`", one.name, span, *(m.text() for m in masses), ratio))
        count, scatter = len(quality.aircraft), 100.0 * quality.log_sigma
        told = f"**{quality.factor:.2f}**, next one +-{scatter:.0f} %"
        rows.append((f"`{name}`", f"**all {count}**", "", "", "", told))
    columns = (
        *(Column("build"), Column("aircraft"), Column("span", "wingspan [m]")),
        Column("built", "structure as built [kg]"),
        Column("computed", "`rib_wing`, `record` [kg]"),
        Column("ratio", "built over computed"),
    )
    return Table("", columns, tuple(rows))


def structures_table() -> Table:
    """Computed beside published masses."""
    columns = (
        Column("aircraft"),
        Column("span", "wingspan [m]"),
        Column("published", "total, published [kg]"),
        Column("computed", "total, computed [kg]"),
        Column("left", "structure, published [kg]"),
        Column("rib_wing", "structure, `rib_wing` [kg]"),
        Column("spar", "structure, `spar` [kg]"),
        Column("ratio", "built over `rib_wing`"),
    )
    rows = []
    for one in published_structures().values():
        rows.append(
            (
                one.name,
                one.numbers["wingspan_m"].text(),
                one.total_kg.text(),
                one.computed_total_kg(one.models).text(),
                one.structure_kg.text(),
                one.computed_structure_kg(one.models).text(),
                one.computed_structure_kg(spar_models()).text(),
                f"{build_ratio(one):.2f}",
            )
        )
    return Table("", columns, tuple(rows))
