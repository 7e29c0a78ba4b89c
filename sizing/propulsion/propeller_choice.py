"""The propeller of an aircraft's file: diameter and pitch, a table, or a product."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, PrivateAttr, Strict, model_validator
from pydantic_core import PydanticCustomError

from missions.files.errors import InputError
from missions.files.texts import read_text, texts_as_read
from sizing.catalogues.choice import OfCatalogue
from solar.schema import Flag, NonNegativeReal, PositiveReal, Text

if TYPE_CHECKING:
    from sizing.propulsion.propeller import Propeller


class PropellerChoice(OfCatalogue):
    """A propeller by its diameter and pitch, or by the files of its table.

    ``product`` names an entry of the catalogue, which gives what the file does not. ``table``: see
    :func:`sizing.read_propeller`, which also says what ``any_speed`` is; there ``diameter_m`` is
    needed only where the files do not tell it.
    """

    _entry = "product", "propellers"

    product: Text | None = None
    diameter_m: Annotated[PositiveReal, Field(le=100.0)] | None = None
    pitch_m: Annotated[PositiveReal, Field(le=100.0)] | None = None
    blades: Annotated[int, Strict(), Field(ge=2, le=12)] = 2
    chords: Literal["thin_electric", "slow_flyer"] = "thin_electric"
    table: Text | tuple[Text, ...] | None = None
    any_speed: Flag = False
    mass_kg: NonNegativeReal | None = None
    # Texts of the tables by path, as read when the record was made.
    _texts: dict[str, str] | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _check_choice(self) -> PropellerChoice:
        if self.table is None:
            for key in ("diameter_m", "pitch_m"):
                if getattr(self, key) is None:
                    message = "required key is missing (or product, or table with its files)"
                    raise PydanticCustomError("propeller", message, {"key": key})
            return self
        odd = self.model_fields_set & {"pitch_m", "blades", "chords"}
        if odd:
            message = "is of no use with a table, which has the coefficients"
            raise PydanticCustomError("propeller", message, {"key": min(odd)})
        context: dict[str, Any] = {"key": "table"}
        try:
            _ = self.propeller
        except InputError as error:
            context["why"] = str(error.problems[0])
            if (count := len(error.problems)) > 1:
                context |= {"why": f"has {count} mistakes", "problems": error.problems}
            raise PydanticCustomError("propeller", "{why}", context) from error
        except OSError as error:
            context["why"] = f"cannot read {error.filename!r}: {error.strerror}"
            raise PydanticCustomError("propeller", "{why}", context) from error
        return self

    @property
    def paths(self) -> tuple[str, ...]:
        """Files of the table; none without."""
        return (self.table,) if isinstance(self.table, str) else self.table or ()

    def texts_read(self) -> dict[str, str]:
        """Text of every file of the table by its path, read once."""
        if self._texts is None or tuple(self._texts) != self.paths:
            self._texts = {path: read_text(path) for path in self.paths}
        return self._texts

    def contents_read(self) -> str | None:
        """Texts of the table, which count for equality."""
        return "".join(self.texts_read().values()) or None

    @cached_property
    def propeller(self) -> Propeller:
        """The propeller itself."""
        from sizing.propulsion import blade_elements, propeller_files

        if self.table is None:
            assert self.diameter_m is not None
            assert self.pitch_m is not None
            size = (self.diameter_m, self.pitch_m)
            return blade_elements.BladeElementPropeller(*size, self.blades, self.chords)
        with texts_as_read(self.texts_read()):
            given = (self.paths, self.diameter_m)
            return propeller_files.read_propeller(*given, any_speed=self.any_speed)
