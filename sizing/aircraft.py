"""Description of a solar aircraft: measured, or parametric for sizing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    Strict,
    model_serializer,
    model_validator,
)

from missions.files.errors import shown
from missions.files.yaml import ENTRY_KEYS
from missions.uncertainty import Uncertainty
from sizing.aerodynamics.parabolic import UserDragPolar
from sizing.aerodynamics.wing_polar import Polar, WingPolar
from sizing.balance.checks import (
    cells_on_planform,
    check_balance,
    check_planforms,
    without_replaced_constants,
)
from sizing.balance.drag import DragComponents
from sizing.balance.masses import Balance
from sizing.balance.surfaces import Planform, Tail
from sizing.battery.battery import Battery
from sizing.catalogues.choice import (
    CatalogueRecord,
    CatalogueValue,
    Kind,
    catalogue_values,
    user_entries,
)
from sizing.catalogues.entries import PARTS_OF_PROPELLER
from sizing.design_space import PROPULSION_VARIABLES, DesignSpace
from sizing.layout.cells import CellLayout, PlacedCell, Wing, check_layout, with_layout_values
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
    kind_by_default,
    spell,
    wrong_value,
)
from solar.shading import LOSS_MODELS, Shading, TailGeometry, loss_model

_TOTAL_MASS = (
    "a known total mass is --mass of analyse; parts are battery.mass_kg, "
    "airframe.avionics_mass_kg, airframe.other_mass_kg and what the models compute"
)
_NO_TOTAL_MASS = dict.fromkeys(("mass_kg", "total_mass_kg", "mass"), _TOTAL_MASS)
# Keys in place of the aspect ratio, which is the wingspan to this power over their value.
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
    mppt_board=("mppt_efficiency", "mppt_mass_kg_per_w"),
    table=(),
    product=PARTS_OF_PROPELLER,
)
# Tolerance of a fully covered wing, above the optimiser's of about 1e-8.
_FULL_WING = 1e-6


class LevelFlight(Record):
    """Electric propulsion power of level flight, measured at a mass and an air density.

    The largest electric power of the propulsion and its efficiency to thrust power are used for
    climbs only.
    """

    _not_below: ClassVar[Mapping[str, str]] = {"maximum_electric_power_w": "electric_power_w"}

    electric_power_w: PositiveReal
    mass_kg: PositiveReal
    density_kg_per_m3: PositiveReal
    airspeed_m_per_s: PositiveReal | None = None
    maximum_electric_power_w: PositiveReal | None = None
    propulsion_efficiency: Fraction | None = None


class MeasuredAirframe(Record):
    """Built aircraft with known mass and measured power.

    Power at another mass or density scales with mass^1.5 and density^-0.5.
    """

    unaccounted_mass_key: ClassVar[str] = "mass_without_battery_kg"

    kind: Literal["measured"]
    wingspan_m: PositiveReal
    aspect_ratio: PositiveReal
    mass_without_battery_kg: PositiveReal
    level_flight: LevelFlight


Aerodynamics = Annotated[
    Polar,
    Field(discriminator="model"),
    kind_by_default("model", "parabolic"),
]


class ParametricAirframe(Record):
    """Airframe for sizing: masses and power follow from geometry and technology.

    ``mass_growth`` is the contingency on structure and ``other_mass_kg``, as a share of them.
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
        return without_replaced_constants(data)

    @model_validator(mode="after")
    def _check_balance(self) -> ParametricAirframe:
        check_balance(self)
        braced = getattr(self.structure, "bracing", None) is not None
        if braced and isinstance(self.aerodynamics, UserDragPolar):
            text = "its drag needs aerodynamics.model parabolic or wing_polar"
            raise wrong_value("structure.bracing", text, got="own")
        return self

    @model_validator(mode="before")
    @classmethod
    def _from_chord(cls, data: Any) -> Any:
        """Compute the aspect ratio from a mean chord or a wing area in the file."""
        if not isinstance(data, Mapping):
            return data
        keys = [key for key in ("aspect_ratio", *_CHORDWISE) if key in data]
        if keys in ([], ["aspect_ratio"]):
            return data
        value, span_m = data[keys[-1]], data.get("wingspan_m", 0.0)
        if len(keys) > 1:
            text = "give one of aspect_ratio, chord_m, wing_area_m2"
            raise wrong_value(keys[-1], text, got=" and ".join(keys))
        if not is_positive(value):
            raise wrong_value(keys[0], "must be a number greater than 0", got=shown(value))
        # An invalid wingspan is refused by its own check.
        ratio = span_m ** _CHORDWISE[keys[0]] / value if is_positive(span_m) else 1.0
        rest = {key: other for key, other in data.items() if key not in _CHORDWISE}
        return {**rest, "aspect_ratio": ratio}


Airframe = Annotated[MeasuredAirframe | ParametricAirframe, Field(discriminator="kind")]


class SolarModules(CatalogueRecord, SolarCell):
    """Solar modules: area, efficiencies, and the mass of modules and MPPT.

    ``geometry`` arranges the area, for models that depend on the attitude. Areas of its surfaces
    are relative: a sized aircraft keeps the arrangement at another area. ``cell`` and
    ``mppt_board`` name entries of the catalogues of solar cells and MPPTs, which give the keys that
    the file omits. ``layout`` has whole cells, which give the area and, with strings, the mass of
    the MPPTs.
    """

    _entries: ClassVar[Mapping[str, Kind]] = {"cell": "cells", "mppt_board": "mppts"}

    cell: Text | None = None
    mppt_board: Text | None = None
    layout: CellLayout | None = None
    area_m2: NonNegativeReal
    geometry: ModuleGeometry | None = None
    tail: TailGeometry | None = None
    shading_loss: Text = "none"
    mass_kg_per_m2: NonNegativeReal = 0.59
    # Of genasun-gvb-8-board in sizing/data/catalogues/mppts.yaml, the board that `init` writes.
    mppt_mass_kg_per_w: NonNegativeReal = 0.108 / 118.0

    @classmethod
    def completed(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return data with the values of the layout, then of the catalogue's cell and board."""
        return super().completed(data if data.get("layout") is None else with_layout_values(data))

    @model_validator(mode="wrap")
    @classmethod
    def _with_mppts(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        record, key = handler(data), "mppt_mass_kg_per_w"
        layout = None if record is data else record.layout
        if layout is None or layout.strings is None or layout.strings.mppt.mass_kg is None:
            return record
        if key in data:
            text = "leave it out: modules.layout.strings.mppt.mass_kg gives it"
            raise wrong_value(key, text)
        rated_w = STC_IRRADIANCE_W_PER_M2 * record.efficiency_stc * record.area_m2
        mass_kg = layout.strings.mppts(layout.count) * layout.strings.mppt.mass_kg
        record = handler({**data, key: mass_kg / rated_w})
        record.__pydantic_fields_set__.discard(key)
        return record

    @model_validator(mode="after")
    def _check_shading(self) -> SolarModules:
        if self.shading_loss not in LOSS_MODELS:
            allowed = f"must be one of {', '.join(LOSS_MODELS)}"
            raise wrong_value("shading_loss", allowed, got=self.shading_loss)
        if self.tail is not None and self.geometry is not None:
            bare = [s.name for s in self.geometry.surfaces if s.outline is None]
            if bare:
                text = f"with a tail every surface needs an outline; missing on {', '.join(bare)}"
                raise wrong_value("geometry.surfaces", text)
        return self

    @property
    def shading(self) -> Shading | None:
        """Shading by the tail; None without a tail."""
        return None if self.tail is None else Shading(self.tail, loss_model(self.shading_loss))


class Power(Record):
    """Electric consumers besides the propulsion."""

    avionics_w: NonNegativeReal
    supply_efficiency: Fraction = 1.0


class Provenance(Record):
    """Where a file's numbers come from, as other programs write it; nothing is computed from it."""

    model_config = ConfigDict(extra="allow")


class Aircraft(FileRecord):
    """Solar aircraft as described in its file."""

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
        """Return name, kind and size."""
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
        """Text of every file named by the aircraft, by path; see :func:`texts_as_read`."""
        texts = user_entries(self.modules, "cell") | user_entries(self.battery, "cell")
        texts |= user_entries(self.modules, "mppt_board")
        propulsion = self.propulsion
        if isinstance(propulsion.motor, str):
            texts |= user_entries(propulsion, "motor")
        if isinstance(propulsion, OperatingPointPropulsion):
            texts |= propulsion.propeller.texts_read()
            texts |= user_entries(propulsion.propeller, "product")
        polar = getattr(self.airframe, "aerodynamics", None)
        if isinstance(polar, WingPolar) and (text := polar.contents_read()) is not None:
            texts[polar.airfoil] = text
        return texts

    @model_serializer(mode="wrap")
    def _with_contents(
        self, handler: SerializerFunctionWrapHandler, info: SerializationInfo
    ) -> dict[str, Any]:
        """Return the data, with the texts of the files that it names in such a context."""
        data: dict[str, Any] = handler(self)
        contents = (info.context or {}).get("contents")
        return data | {"texts_read": self.texts_read} if contents else data

    @property
    def parametric(self) -> ParametricAirframe:
        """Parametric airframe; a measured aircraft raises TypeError."""
        if not isinstance(self.airframe, ParametricAirframe):
            raise TypeError(f"{self.name} is a measured aircraft: it has no mass budget to size")
        return self.airframe

    def with_airframe(self, **changes: Any) -> Aircraft:
        """Return the aircraft with changed values of its airframe, not validated."""
        airframe = self.airframe.model_copy(update=changes)
        return self.model_copy(update={"airframe": airframe})

    @property
    def propulsion(self) -> AnyPropulsion:
        """Propulsion of the file; constants that play no part for a measured aircraft."""
        return getattr(self.airframe, "propulsion", None) or Propulsion()

    @property
    def propulsion_by_parts(self) -> OperatingPointPropulsion | None:
        """Propulsion at its operating point; None for constants and measured aircraft."""
        propulsion = self.propulsion
        return propulsion if isinstance(propulsion, OperatingPointPropulsion) else None

    def reading_notes(self) -> list[str]:
        """Return notes on parts of named files that were left out, and on their format."""
        polar = getattr(self.airframe, "aerodynamics", None)
        parts = self.propulsion_by_parts
        read = {
            "polar": polar.polar if isinstance(polar, WingPolar) else None,
            "propeller": parts.propeller.propeller if parts is not None else None,
        }
        return [
            f"{name}: {note}" for name, data in read.items() for note in getattr(data, "notes", ())
        ]

    def from_catalogues(self) -> tuple[CatalogueValue, ...]:
        """Return the values from catalogues, with their sources."""
        return (
            *catalogue_values(self.modules, "modules."),
            *catalogue_values(self.battery, "battery."),
            *self.propulsion.catalogue_values(),
        )

    @model_validator(mode="before")
    @classmethod
    def _cells_on_planform(cls, data: Any) -> Any:
        return cells_on_planform(data)

    @model_validator(mode="after")
    def _check_lift(self) -> Aircraft:
        lift = self.design_space.lift_coefficient
        if lift is None or not isinstance(self.airframe, ParametricAirframe):
            return self
        # The same limits as in the airframe, into which a sized design is written.
        polar = self.airframe.aerodynamics
        if isinstance(polar, WingPolar):
            highest, allowed = polar.highest_lift_coefficient, "at most that of the stall margin"
            wrong = lift.maximum > highest
        else:
            highest, allowed = polar.maximum_lift_coefficient, "below the maximum lift coefficient"
            wrong = lift.maximum >= highest
        if wrong:
            key, text = "design_space.lift_coefficient.maximum", f"must be {allowed}"
            raise wrong_value(key, f"{text}, {spell(highest, 4)}", got=lift.maximum)
        return self

    @model_validator(mode="after")
    def _check_propulsion_by_parts(self) -> Aircraft:
        chain = self.propulsion_by_parts
        if chain is None or chain.propeller.table is not None:
            text = "goes with airframe.propulsion.kind: operating_point, without propeller.table"
            for key in PROPULSION_VARIABLES:
                if getattr(self.design_space, key) is not None:
                    raise wrong_value(f"design_space.{key}", text)
        if chain is not None and self.battery.voltage is None:
            raise wrong_value(
                "battery.voltage",
                "required key is missing: airframe.propulsion.kind is operating_point; with "
                "battery.cell of the catalogue {cells_in_series: ...} suffices",
            )
        return self

    @property
    def wing(self) -> Wing:
        """Wingspan and mean chord."""
        span_m = self.airframe.wingspan_m
        return Wing(span_m, span_m / self.airframe.aspect_ratio)

    def placed_cells(self) -> list[PlacedCell]:
        """Return the whole cells of wing and tail; none without a layout."""
        layout = self.modules.layout
        return [] if layout is None else layout.placed(self.wing, self.modules.tail)

    @model_validator(mode="after")
    def _check_room(self) -> Aircraft:
        modules = self.modules
        if modules.layout is not None:  # every cell has its place
            check_planforms(getattr(self.airframe, "planform", None), modules.layout)
            loss_per_k, ends_v = modules.temperature_coefficient_per_k, self.battery.ends_v
            check_layout(modules.layout, self.wing, modules.tail, loss_per_k, ends_v)
            return self
        wing_area_m2 = self.airframe.wingspan_m**2 / self.airframe.aspect_ratio
        if modules.area_m2 > wing_area_m2 * (1.0 + _FULL_WING):
            text = f"must not exceed the wing area of {spell(wing_area_m2, 3)} m², wingspan "
            text += "squared over aspect_ratio or wingspan times chord_m"
            raise wrong_value("modules.area_m2", text, got=modules.area_m2)
        return self
