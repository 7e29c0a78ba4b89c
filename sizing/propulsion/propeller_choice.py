"""Propeller of an aircraft's file: diameter and pitch, a table, or a product."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, ClassVar, Literal

from pydantic import Field, PrivateAttr, Strict, model_validator

from missions.files.errors import InputError
from missions.files.texts import read_text, texts_as_read
from missions.files.validation import wrong_file
from sizing.catalogues.choice import CatalogueRecord, Kind
from sizing.propulsion.blade_elements import BladeElementPropeller
from sizing.propulsion.propeller import Propeller
from sizing.propulsion.propeller_files import read_propeller
from solar.schema import Flag, NonNegativeReal, PositiveReal, Text, wrong_value


class PropellerChoice(CatalogueRecord):
    """Propeller by its diameter and pitch, or by the files of its table.

    ``product`` names a catalogue entry, which gives the keys that the file omits. ``table`` and
    ``any_speed``: see :func:`sizing.read_propeller`; with a table, ``diameter_m`` is needed only
    where its files omit it.
    """

    _entries: ClassVar[Mapping[str, Kind]] = {"product": "propellers"}

    product: Text | None = None
    diameter_m: Annotated[PositiveReal, Field(le=100.0)] | None = None
    pitch_m: Annotated[PositiveReal, Field(le=100.0)] | None = None
    blades: Annotated[int, Strict(), Field(ge=2, le=12)] = 2
    chords: Literal["thin_electric", "slow_flyer"] = "thin_electric"
    table: Text | tuple[Text, ...] | None = None
    any_speed: Flag = False
    mass_kg: NonNegativeReal | None = None
    # Texts of the tables by path, read when the record was made.
    _texts: dict[str, str] | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _check_choice(self) -> PropellerChoice:
        if self.table is None:
            for key in ("diameter_m", "pitch_m"):
                if getattr(self, key) is None:
                    text = "required key is missing (or product, or table with its files)"
                    raise wrong_value(key, text)
            return self
        odd = self.model_fields_set & {"pitch_m", "blades", "chords"}
        if odd:
            text = "is of no use with a table, which has the coefficients"
            raise wrong_value(min(odd), text)
        try:
            _ = self.propeller
        except (InputError, OSError) as error:
            raise wrong_file("table", error) from error
        return self

    @property
    def paths(self) -> tuple[str, ...]:
        """Files of the table; empty without a table."""
        return (self.table,) if isinstance(self.table, str) else self.table or ()

    def texts_read(self) -> dict[str, str]:
        """Return the text of every file of the table by its path, read once."""
        if self._texts is None or tuple(self._texts) != self.paths:
            self._texts = {path: read_text(path) for path in self.paths}
        return self._texts

    def contents_read(self) -> str | None:
        """Return the joined texts of the table, which count for equality."""
        return "".join(self.texts_read().values()) or None

    @cached_property
    def propeller(self) -> Propeller:
        """Propeller by its table or by blade elements."""
        if self.table is None:
            assert self.diameter_m is not None
            assert self.pitch_m is not None
            return BladeElementPropeller(self.diameter_m, self.pitch_m, self.blades, self.chords)
        with texts_as_read(self.texts_read()):
            return read_propeller(self.paths, self.diameter_m, any_speed=self.any_speed)
