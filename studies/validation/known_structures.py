"""Built aircraft whose structural mass is published, as cases for the models of the structure."""

from __future__ import annotations

from typing import NamedTuple

from missions.air import GRAVITY_M_PER_S2
from sizing.aircraft import ParametricAirframe
from sizing.library import load_aircraft
from sizing.smooth import Value
from sizing.structures.loads import StructureInputs
from sizing.structures.models import StructureModel
from sizing.structures.rib_wing import RibWingStructure, StructureParts


class StructureCase(NamedTuple):
    """An aircraft of known structural mass, and what its structure is sized from."""

    name: str
    wingspan_m: Value
    aspect_ratio: float
    total_mass_kg: Value
    span_load_kg: Value
    lift_coefficient: float
    density_kg_per_m3: float
    published_kg: float | None = None

    @property
    def built_kg(self) -> float:
        """Structural mass as built [kg]."""
        if self.published_kg is None:
            raise ValueError(f"{self.name} is no built aircraft")
        return self.published_kg

    def mass_kg(self, model: StructureModel) -> Value:
        """Structural mass [kg] by a model."""
        return model.mass_kg(self.inputs())

    def parts(self, model: RibWingStructure) -> StructureParts:
        """Masses of the structure's parts [kg]."""
        return model.breakdown(self.inputs())

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
        )


# Published: span, aspect ratio, mass, battery and module area with their mass per area, structure
# (AtlantikSolar 1.30 to 1.40 kg). The battery of AtlantikSolar lies along the span, that of
# Sky-Sailor does not.
ATLANTIKSOLAR = StructureCase(
    "AtlantikSolar", 5.65, 18.5, 6.92, 2.918 + 0.59 * 1.35, 1.0, 1.10, published_kg=1.35
)
SKY_SAILOR = StructureCase(
    "Sky-Sailor", 3.2, 13.2, 2.44, 0.58 * 0.51, 0.8, 1.10, published_kg=0.725
)
KNOWN = (ATLANTIKSOLAR, SKY_SAILOR)


def calibrated_rib_wing() -> RibWingStructure:
    """The rib wing as ``atlantiksolar-design`` ships it."""
    airframe = load_aircraft("atlantiksolar-design").airframe
    assert isinstance(airframe, ParametricAirframe)
    assert isinstance(airframe.structure, RibWingStructure)
    return airframe.structure


def family(wingspan_m: Value) -> StructureCase:
    """AtlantikSolar at another span: same aspect ratio, wing loading and shares of mass."""
    mass_kg = ATLANTIKSOLAR.total_mass_kg * (wingspan_m / ATLANTIKSOLAR.wingspan_m) ** 2
    share = ATLANTIKSOLAR.span_load_kg / ATLANTIKSOLAR.total_mass_kg
    return ATLANTIKSOLAR._replace(
        wingspan_m=wingspan_m,
        total_mass_kg=mass_kg,
        span_load_kg=share * mass_kg,
        published_kg=None,
    )
