"""Description of a solar aircraft: measured, or parametric and therefore open to sizing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, ModelWrapValidatorHandler, Strict, model_validator

from missions.files.errors import shown
from missions.files.yaml import ENTRY_KEYS
from missions.provenance import Provenance
from missions.uncertainty import Uncertainty
from sizing.aerodynamics.parabolic import DragPolar, OwnDragPolar
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.balance.checks import (
    cells_on_planform,
    check_balance,
    check_planforms,
    without_own_constants,
)
from sizing.balance.drag import DragComponents
from sizing.balance.masses import Balance
from sizing.balance.surfaces import Planform, Tail
from sizing.catalogues.choice import OfCatalogue, Taken, own_entries, taken
from sizing.catalogues.entries import PARTS_OF_PROPELLER
from sizing.energy.battery import Battery
from sizing.layout.cells import CellLayout, PlacedCell, Wing
from sizing.layout.filling import check_layout, laid_out, mppt_mass_kg
from sizing.propulsion.chain import AnyPropulsion, OperatingPointPropulsion, Propulsion
from sizing.structures.models import SparStructure, Structure
from solar.geometry import ModuleGeometry
from solar.modules import STC_IRRADIANCE_W_PER_M2, SolarCell
from solar.schema import (
    FileRecord,
    Fraction,
    Name,
    NonNegativeReal,
    PositiveReal,
    Record,
    Text,
    UnitInterval,
    is_positive,
    wrong_value,
)
from solar.shading import LOSS_MODELS, Shading, TailGeometry, loss_model

_TOTAL_MASS = (
    "a known total mass is --mass of analyse; parts are battery.mass_kg, "
    "airframe.avionics_mass_kg, airframe.other_mass_kg and what the models compute"
)
_NO_TOTAL_MASS = dict.fromkeys(("mass_kg", "total_mass_kg", "mass"), _TOTAL_MASS)
# What may stand in place of the aspect ratio, and the power of the wingspan over it.
_CHORDWISE = {"chord_m": 1, "wing_area_m2": 2}
ENTRY_KEYS.update(
    aspect_ratio=tuple(_CHORDWISE),
    chord_m=("aspect_ratio", "wing_area_m2"),
    wing_area_m2=("aspect_ratio", "chord_m"),
    airfoil=(),
    cell=(
        "efficiency_stc",
        "temperature_coefficient_per_k",
        "mass_kg_per_m2",
        "specific_energy_wh_per_kg",
        "charge_limit",
    ),
    motor=("motor_efficiency",),
    table=(),
    product=PARTS_OF_PROPELLER,
)
# A wing that is covered whole by an optimiser is so to its tolerance, about 1e-8.
_FULL_WING = 1e-6


class LevelFlight(Record):
    """Electric propulsion power of level flight, measured at one mass and air density.

    The largest electric power of the propulsion and its efficiency from there to thrust power are
    needed to climb, and for nothing else.
    """

    electric_power_w: PositiveReal
    mass_kg: PositiveReal
    density_kg_per_m3: PositiveReal
    airspeed_m_per_s: PositiveReal | None = None
    maximum_electric_power_w: PositiveReal | None = None
    propulsion_efficiency: Fraction | None = None

    @model_validator(mode="after")
    def _check_maximum(self) -> LevelFlight:
        maximum = self.maximum_electric_power_w
        if maximum is not None and maximum < self.electric_power_w:
            raise ValueError(
                "maximum_electric_power_w must be at least electric_power_w "
                f"(got {maximum:g} and {self.electric_power_w:g})"
            )
        return self


class MeasuredAirframe(Record):
    """A built aircraft, known by its mass and its measured power.

    Power at another mass or density is scaled with mass^1.5 and density^-0.5.
    """

    unaccounted_mass_key: ClassVar[str] = "mass_without_battery_kg"

    kind: Literal["measured"]
    wingspan_m: PositiveReal
    aspect_ratio: PositiveReal
    mass_without_battery_kg: PositiveReal
    level_flight: LevelFlight


def _parabolic_by_default(value: Any) -> Any:
    """Polars without a model are parabolic."""
    if isinstance(value, dict) and "model" not in value:
        return {"model": "parabolic", **value}
    return value


Aerodynamics = Annotated[
    DragPolar | WingPolar | OwnDragPolar,
    Field(discriminator="model"),
    BeforeValidator(_parabolic_by_default),
]


class ParametricAirframe(Record):
    """An aircraft to be sized: masses and power follow from geometry and technology.

    ``mass_growth``: contingency on what is built and not bought, structure and ``other_mass_kg``,
    as a share of them.
    """

    explained_keys: ClassVar[Mapping[str, str]] = _NO_TOTAL_MASS | {
        "mean_chord_m": "the mean chord is airframe.chord_m, in place of aspect_ratio"
    }

    unaccounted_mass_key: ClassVar[str] = "other_mass_kg"

    kind: Literal["parametric"]
    wingspan_m: PositiveReal
    aspect_ratio: PositiveReal
    structure: Structure = SparStructure()
    aerodynamics: Aerodynamics
    propulsion: AnyPropulsion = Propulsion()
    avionics_mass_kg: NonNegativeReal
    other_mass_kg: NonNegativeReal = 0.0
    mass_growth: Annotated[float, Strict(), Field(ge=0.0, le=2.0)] = 0.0
    distributed_battery_fraction: UnitInterval = 1.0
    distributed_propulsion_fraction: UnitInterval = 0.0
    distributed_systems_fraction: UnitInterval = 0.0
    maximum_module_coverage: Fraction = 0.85
    planform: Planform | None = None
    tail: Tail | None = None
    drag: DragComponents | None = None
    balance: Balance | None = None

    @model_validator(mode="before")
    @classmethod
    def _drag_by_parts(cls, data: Any) -> Any:
        return without_own_constants(data)

    @model_validator(mode="after")
    def _check_balance(self) -> ParametricAirframe:
        check_balance(self)
        braced = getattr(self.structure, "bracing", None) is not None
        if braced and isinstance(self.aerodynamics, OwnDragPolar):
            text = "its drag needs aerodynamics.model parabolic or wing_polar (got own)"
            raise wrong_value("structure.bracing", text)
        return self

    @model_validator(mode="before")
    @classmethod
    def _from_chord(cls, data: Any) -> Any:
        """Aspect ratio from a mean chord or a wing area, where the file gives that instead."""
        if not isinstance(data, Mapping):
            return data
        keys = [key for key in ("aspect_ratio", *_CHORDWISE) if key in data]
        if keys in ([], ["aspect_ratio"]):
            return data
        value, span_m = data[keys[-1]], data.get("wingspan_m", 0.0)
        if len(keys) > 1:
            text = f"give one of aspect_ratio, chord_m, wing_area_m2 (got {' and '.join(keys)})"
            raise wrong_value(keys[-1], text)
        if not is_positive(value):
            raise wrong_value(keys[0], f"must be a number greater than 0 (got {shown(value)})")
        # Of a wingspan that is none, its own error says so.
        ratio = span_m ** _CHORDWISE[keys[0]] / value if is_positive(span_m) else 1.0
        rest = {key: one for key, one in data.items() if key not in _CHORDWISE}
        return {**rest, "aspect_ratio": ratio}


Airframe = Annotated[MeasuredAirframe | ParametricAirframe, Field(discriminator="kind")]


class SolarModules(OfCatalogue, SolarCell):
    """Solar modules: area, efficiencies, and the mass of modules and MPPT.

    ``geometry`` tells how the area is arranged, for the models that know the attitude. Areas of its
    surfaces count relative to each other: a sized aircraft keeps the arrangement at another area.
    ``cell`` names an entry of the catalogue of solar cells, which gives what the file does not.
    ``layout`` lays whole cells, which give the area and, with strings, the mass of the MPPTs.
    """

    _entry = "cell", "cells"

    cell: Text | None = None
    layout: CellLayout | None = None
    area_m2: NonNegativeReal
    geometry: ModuleGeometry | None = None
    tail: TailGeometry | None = None
    shading_loss: Text = "none"
    mass_kg_per_m2: NonNegativeReal = 0.59
    mppt_mass_kg_per_w: NonNegativeReal = 1.0 / 2368.0

    @model_validator(mode="wrap")
    @classmethod
    def _with_layout(
        cls, data: Any, handler: ModelWrapValidatorHandler[SolarModules]
    ) -> SolarModules:
        data, new = laid_out(data)
        record = handler(data)
        mass_kg = mppt_mass_kg(record.layout)
        if mass_kg is not None:
            if "mppt_mass_kg_per_w" in data:
                text = "leave it out: modules.layout.strings.mppt.mass_kg gives it"
                raise wrong_value("mppt_mass_kg_per_w", text)
            rated_w = STC_IRRADIANCE_W_PER_M2 * record.efficiency_stc * record.area_m2
            new |= {"mppt_mass_kg_per_w"}
            data = {**data, "mppt_mass_kg_per_w": mass_kg / rated_w}
            record = handler(data)
        record.__pydantic_fields_set__.difference_update(new)
        return record

    @model_validator(mode="after")
    def _check_shading(self) -> SolarModules:
        if self.shading_loss not in LOSS_MODELS:
            allowed = ", ".join(LOSS_MODELS)
            raise wrong_value("shading_loss", f"must be one of {allowed} (got {self.shading_loss})")
        if self.tail is not None and self.geometry is not None:
            bare = [s.name for s in self.geometry.surfaces if s.outline is None]
            if bare:
                text = f"with a tail every surface needs an outline; missing on {', '.join(bare)}"
                raise wrong_value("geometry.surfaces", text)
        return self

    @property
    def shading(self) -> Shading | None:
        """Shading by the tail, none without a tail."""
        return None if self.tail is None else Shading(self.tail, loss_model(self.shading_loss))


class Power(Record):
    """Electric consumers besides the propulsion."""

    avionics_w: NonNegativeReal
    supply_efficiency: Fraction = 1.0


class Range(Record):
    """Bounds of a design variable."""

    minimum: PositiveReal
    maximum: PositiveReal

    @model_validator(mode="after")
    def _ends_in_order(self) -> Range:
        if self.minimum >= self.maximum:
            raise ValueError(
                f"minimum must be below maximum (got {self.minimum:g} and {self.maximum:g})"
            )
        return self


# Quantities of a design that a file may bound; their formulas are in sizing.limits.
LimitedQuantity = Literal[
    "total_mass_kg",
    "structure_mass_kg",
    "battery_energy_wh",
    "battery_fraction",
    "payload_fraction",
    "wing_area_m2",
    "chord_m",
    "module_coverage",
    "wing_loading_kg_per_m2",
    "airspeed_m_per_s",
    "stall_speed_m_per_s",
    "stall_margin",
    "lift_coefficient",
    "reynolds_number",
    "propulsion_power_w",
    "rated_power_w",
    "load_w",
    "climb_rate_m_per_s",
    "cruise_discharge_rate_per_h",
    "climb_discharge_rate_per_h",
]


LimitEnd = Literal["minimum", "maximum"]

# Limits that have a key of their own.
_NAMED_LIMITS: dict[str, tuple[LimitedQuantity, LimitEnd]] = {
    "maximum_wing_loading_kg_per_m2": ("wing_loading_kg_per_m2", "maximum"),
    "minimum_stall_margin": ("stall_margin", "minimum"),
    "minimum_climb_rate_m_per_s": ("climb_rate_m_per_s", "minimum"),
    "maximum_climb_discharge_rate_per_h": ("climb_discharge_rate_per_h", "maximum"),
}


class Limit(Record):
    """Least and largest value that a quantity of the design may have; one of them may be left."""

    minimum: PositiveReal | None = None
    maximum: PositiveReal | None = None

    @model_validator(mode="after")
    def _ends_in_order(self) -> Limit:
        if self.minimum is None and self.maximum is None:
            raise ValueError("give a minimum, a maximum or both")
        if self.minimum is not None and self.maximum is not None and self.minimum > self.maximum:
            raise ValueError(
                f"minimum must not exceed maximum (got {self.minimum:g} and {self.maximum:g})"
            )
        return self


PROPULSION_VARIABLES = (
    "propeller_diameter_m",
    "propeller_pitch_m",
    "gear_ratio",
    "motor_speed_constant_rpm_per_v",
)


class DesignSpace(Record):
    """Bounds within which the optimiser may choose.

    Aspect ratio, lift coefficient, propeller, gear and winding of the motor stay as they are on the
    airframe if they have no range here.
    ``limits`` bounds any other quantity of the design.
    """

    wingspan_m: Range = Range(minimum=1.0, maximum=15.0)
    battery_mass_kg: Range = Range(minimum=0.1, maximum=50.0)
    module_area_m2: Range = Range(minimum=0.05, maximum=25.0)
    aspect_ratio: Range | None = None
    lift_coefficient: Range | None = None
    propeller_diameter_m: Range | None = None
    propeller_pitch_m: Range | None = None
    gear_ratio: Range | None = None
    motor_speed_constant_rpm_per_v: Range | None = None
    maximum_total_mass_kg: PositiveReal | None = None
    maximum_wing_loading_kg_per_m2: PositiveReal | None = None
    minimum_stall_margin: Annotated[float, Strict(), Field(ge=1.0, le=5.0)] | None = None
    minimum_climb_rate_m_per_s: PositiveReal | None = None
    maximum_climb_discharge_rate_per_h: PositiveReal | None = None
    limits: dict[LimitedQuantity, Limit] = Field(default_factory=dict)

    def requested_ranges(self) -> dict[str, Range]:
        """Bounds of the variables that are chosen on request, by name; of those that are."""
        names = ("aspect_ratio", "lift_coefficient", *PROPULSION_VARIABLES)
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    def __hash__(self) -> int:
        # A mapping has no hash of its own; aircraft serve as keys of what is kept for them.
        others = (getattr(self, name) for name in type(self).model_fields if name != "limits")
        return hash((*others, frozenset(self.limits.items())))

    def all_limits(self) -> dict[LimitedQuantity, Limit]:
        """Every limit on a quantity of the design, whichever key it was given by."""
        named = {
            quantity: Limit(**{end: getattr(self, key)})
            for key, (quantity, end) in _NAMED_LIMITS.items()
            if getattr(self, key) is not None
        }
        return named | self.limits

    def own_requirements(self, it: Any) -> list[Any]:
        """Requirements of the user's own on a design in flight; a file has none."""
        return []

    def key_of_limit(self, quantity: LimitedQuantity, end: LimitEnd) -> str:
        """Key by which a limit was given.

        Parameters
        ----------
        quantity : str
            Quantity of the design that is limited.
        end : {"minimum", "maximum"}
            Which of its limits.

        Returns
        -------
        str
            Key of its own, such as ``minimum_stall_margin``, if that one is given; else
            ``limits.<quantity>.<end>``, whether or not it is given.
        """
        for key, place in _NAMED_LIMITS.items():
            if place == (quantity, end) and getattr(self, key) is not None:
                return key
        return f"limits.{quantity}.{end}"

    def with_limit(
        self, quantity: LimitedQuantity, end: LimitEnd, value: float | None
    ) -> DesignSpace:
        """Same space with a limit that it has at another value; not validated.

        Parameters
        ----------
        quantity, end
            As for :meth:`key_of_limit`.
        value : float or None
            New limit in the quantity's unit; None takes it away.

        Returns
        -------
        DesignSpace
            Copy; a limit with a key of its own keeps that key.
        """
        key = self.key_of_limit(quantity, end)
        if key in _NAMED_LIMITS:
            return self.model_copy(update={key: value})
        limit = self.limits[quantity].model_copy(update={end: value})
        return self.model_copy(update={"limits": self.limits | {quantity: limit}})

    @model_validator(mode="after")
    def _check_mass(self) -> DesignSpace:
        heaviest, battery = self.maximum_total_mass_kg, self.battery_mass_kg.minimum
        twice = [
            key
            for key, (quantity, _) in _NAMED_LIMITS.items()
            if getattr(self, key) is not None and quantity in self.limits
        ]
        if twice:
            raise ValueError(f"{twice[0]} and the same quantity in limits: give one of them")
        if heaviest is not None and heaviest <= battery:
            raise ValueError(
                "maximum_total_mass_kg must be above the least battery mass "
                f"(got {heaviest:g} and {battery:g})"
            )
        return self


class Aircraft(FileRecord):
    """A solar aircraft as its file describes it."""

    explained_keys: ClassVar[Mapping[str, str]] = _NO_TOTAL_MASS

    name: Name
    description: str = ""
    airframe: Airframe
    modules: SolarModules
    battery: Battery
    power: Power
    design_space: DesignSpace = DesignSpace()
    uncertainty: Uncertainty | None = None
    provenance: Provenance | None = None

    def facts(self) -> dict[str, Any]:
        """Name, kind and size."""
        return {
            "name": self.name,
            "airframe": self.airframe.kind,
            "wingspan [m]": self.airframe.wingspan_m,
            "aspect ratio": self.airframe.aspect_ratio,
            "battery [kg]": self.battery.mass_kg,
            "modules [m²]": self.modules.area_m2,
        }

    @property
    def texts_read(self) -> dict[str, str]:
        """Text of every file that it names, by path; see :func:`texts_as_read`."""
        texts = own_entries(self.modules, "cell") | own_entries(self.battery, "cell")
        propulsion = getattr(self.airframe, "propulsion", None)
        if propulsion is not None and isinstance(propulsion.motor, str):
            texts |= own_entries(propulsion, "motor")
        if isinstance(propulsion, OperatingPointPropulsion):
            texts |= propulsion.propeller.texts_read()
            texts |= own_entries(propulsion.propeller, "product")
        polar = getattr(self.airframe, "aerodynamics", None)
        if isinstance(polar, WingPolar) and (text := polar.contents_read()) is not None:
            texts[polar.airfoil] = text
        return texts

    @property
    def propulsion_by_parts(self) -> OperatingPointPropulsion | None:
        """Propulsion that has an operating point; None for constants and measured aircraft."""
        propulsion = getattr(self.airframe, "propulsion", None)
        return propulsion if isinstance(propulsion, OperatingPointPropulsion) else None

    def from_catalogues(self) -> list[Taken]:
        """Values that catalogues gave, with their sources."""
        entries = taken(self.modules, "modules.") + taken(self.battery, "battery.")
        propulsion = getattr(self.airframe, "propulsion", None)
        if isinstance(propulsion, Propulsion):
            entries += taken(propulsion, "airframe.propulsion.")
        elif isinstance(propulsion, OperatingPointPropulsion):
            entries += propulsion.taken()
        return entries

    @model_validator(mode="before")
    @classmethod
    def _cells_on_planform(cls, data: Any) -> Any:
        return cells_on_planform(data)

    @model_validator(mode="after")
    def _check_planforms(self) -> Aircraft:
        check_planforms(getattr(self.airframe, "planform", None), self.modules.layout)
        return self

    @model_validator(mode="after")
    def _check_lift(self) -> Aircraft:
        lift = self.design_space.lift_coefficient
        if lift is None or not isinstance(self.airframe, ParametricAirframe):
            return self
        # As on the airframe, which a sized design becomes.
        polar = self.airframe.aerodynamics
        if isinstance(polar, WingPolar):
            highest, allowed = polar.highest_lift_coefficient, "at most that of the stall margin"
            wrong = lift.maximum > highest
        else:
            highest, allowed = polar.maximum_lift_coefficient, "below the maximum lift coefficient"
            wrong = lift.maximum >= highest
        if wrong:
            raise wrong_value(
                "design_space.lift_coefficient.maximum",
                f"must be {allowed}, {highest:.4g} (got {lift.maximum:g})",
            )
        return self

    @model_validator(mode="after")
    def _check_propeller_space(self) -> Aircraft:
        chain = self.propulsion_by_parts
        if chain is not None and chain.propeller.table is None:
            return self
        for key in PROPULSION_VARIABLES:
            if getattr(self.design_space, key) is not None:
                raise wrong_value(
                    f"design_space.{key}",
                    "goes with airframe.propulsion.kind: operating_point, without propeller.table",
                )
        return self

    @model_validator(mode="after")
    def _check_bus(self) -> Aircraft:
        if self.propulsion_by_parts is not None and self.battery.voltage is None:
            raise wrong_value(
                "battery.voltage",
                "required key is missing: airframe.propulsion.kind is operating_point",
            )
        return self

    @property
    def wing(self) -> Wing:
        """Wingspan and mean chord."""
        span_m = self.airframe.wingspan_m
        return Wing(span_m, span_m / self.airframe.aspect_ratio)

    def placed_cells(self) -> list[PlacedCell]:
        """Whole cells of wing and tail; none without a layout."""
        layout = self.modules.layout
        return [] if layout is None else layout.placed(self.wing, self.modules.tail)

    @model_validator(mode="after")
    def _check_layout(self) -> Aircraft:
        modules = self.modules
        if modules.layout is not None:
            loss_per_k, ends_v = modules.temperature_coefficient_per_k, self.battery.ends_v
            check_layout(modules.layout, self.wing, modules.tail, loss_per_k, ends_v)
        return self

    @model_validator(mode="after")
    def _check_coverage(self) -> Aircraft:
        wing_area_m2 = self.airframe.wingspan_m**2 / self.airframe.aspect_ratio
        if self.modules.layout is not None:
            return self  # every cell has its place
        if self.modules.area_m2 > wing_area_m2 * (1.0 + _FULL_WING):
            raise wrong_value(
                "modules.area_m2",
                f"must not exceed the wing area of {wing_area_m2:.3g} m², wingspan "
                "squared over aspect_ratio or wingspan times chord_m (got "
                f"{self.modules.area_m2:g})",
            )
        return self
