"""Built aircraft whose size and masses are published: what the sizing and its models must meet."""

from __future__ import annotations

from dataclasses import dataclass

from missions.air import GRAVITY_M_PER_S2
from sizing.aircraft import ParametricAirframe
from sizing.library import load_aircraft
from sizing.smooth import Value
from sizing.structures.loads import StructureInputs
from sizing.structures.models import StructureModel
from sizing.structures.rib_wing import RibWingStructure


@dataclass(frozen=True)
class BuiltAircraft:
    """Published numbers of an aircraft.

    ``name``: name of the aircraft. ``wingspan_m``, ``aspect_ratio``: wing [m, -].
    ``module_area_m2``: area of the solar modules [m2]. ``span_load_kg``: what lies along the span:
    modules, and the battery if it is in the wing [kg]. ``lift_coefficient``, ``density_kg_per_m3``:
    level flight [-, kg/m3]. ``level_flight_w``: published electric power [W]: of propulsion
    (AtlantikSolar), of all consumers (Sky-Sailor). ``wing_battery_kg``: battery along the span; the
    rest of it is in the pod [kg]. ``structure_kg``: published mass of the structure [kg]; none of
    an aircraft that was not built.
    """

    name: str
    wingspan_m: Value
    aspect_ratio: float
    total_mass_kg: Value
    battery_mass_kg: Value
    module_area_m2: Value
    span_load_kg: Value
    lift_coefficient: float
    density_kg_per_m3: float
    level_flight_w: float
    wing_battery_kg: Value = 0.0
    structure_kg: float | None = None

    @property
    def size(self) -> tuple[Value, Value, Value, Value]:
        """Wingspan [m], battery mass [kg], module area [m2] and total mass [kg]."""
        return self.wingspan_m, self.battery_mass_kg, self.module_area_m2, self.total_mass_kg

    @property
    def built_kg(self) -> float:
        """Structural mass as built [kg]."""
        if self.structure_kg is None:
            raise ValueError(f"{self.name} is no built aircraft")
        return self.structure_kg

    def mass_kg(self, model: StructureModel) -> Value:
        """Structural mass [kg] by a model."""
        return model.mass_kg(self.inputs())

    def inputs(self) -> StructureInputs:
        """What the structure is sized from, in level flight at the lift coefficient."""
        area_m2 = self.wingspan_m**2 / self.aspect_ratio
        pressure = self.total_mass_kg * GRAVITY_M_PER_S2 / (area_m2 * self.lift_coefficient)
        return StructureInputs(
            wingspan_m=self.wingspan_m,
            aspect_ratio=self.aspect_ratio,
            total_mass_kg=self.total_mass_kg,
            span_load_kg=self.span_load_kg,
            airspeed_m_per_s=(2.0 * pressure / self.density_kg_per_m3) ** 0.5,
            density_kg_per_m3=self.density_kg_per_m3,
            wing_battery_kg=self.wing_battery_kg,
            pod_battery_kg=self.battery_mass_kg - self.wing_battery_kg,
        )


# Structure of AtlantikSolar published as 1.30 to 1.40 kg. Its battery lies along the span, that of
# Sky-Sailor does not; modules with their encapsulation weigh 0.59 and 0.58 kg/m2.
ATLANTIKSOLAR = BuiltAircraft(
    name="AtlantikSolar",
    wingspan_m=5.65,
    aspect_ratio=18.5,
    total_mass_kg=6.92,
    battery_mass_kg=2.918,
    module_area_m2=1.35,
    span_load_kg=2.918 + 0.59 * 1.35,
    lift_coefficient=1.0,
    density_kg_per_m3=1.10,
    level_flight_w=35.8,
    wing_battery_kg=2.918,
    structure_kg=1.35,
)
SKY_SAILOR = BuiltAircraft(
    name="Sky-Sailor",
    wingspan_m=3.2,
    aspect_ratio=13.2,
    total_mass_kg=2.44,
    battery_mass_kg=1.06,
    module_area_m2=0.51,
    span_load_kg=0.58 * 0.51,
    lift_coefficient=0.8,
    density_kg_per_m3=1.10,
    level_flight_w=16.0,
    structure_kg=0.725,
)


def calibrated_rib_wing() -> RibWingStructure:
    """The rib wing as ``atlantiksolar-design`` ships it."""
    airframe = load_aircraft("atlantiksolar-design").airframe
    assert isinstance(airframe, ParametricAirframe)
    assert isinstance(airframe.structure, RibWingStructure)
    return airframe.structure
