"""Systematic errors of the solar power models, measured against flight, and their correction.

Source: Oettershagen, "High-Fidelity Solar Power Income Modeling for Solar-Electric UAVs",
table 3: errors of the average power relative to flight, and RMS errors of the filtered power,
for one flight (47.6° N, 1 July 2015, sunrise to 9.72 h solar time, 2 m/s of easterly wind). Used
elsewhere they are an extrapolation: the sun is higher at noon and in the tropics, and what the
simple models leave out then matters less.
"""

from __future__ import annotations

from dataclasses import dataclass

from solar.names import CORRECTION_NAMES, MODEL_NAMES, MODELS, CorrectionName, ModelName


@dataclass(frozen=True)
class Correction:
    """Factor on the modelled power, ``1 / (1 + error)``, and the band of the truth.

    ``rms_relative``: the model's RMS error relative to the mean measured power, a one-sigma band
    around the modelled power, stated and never applied; without the average error where it is
    corrected.
    """

    name: CorrectionName
    factor: float
    rms_relative: float


def correction(model: ModelName, name: CorrectionName) -> Correction:
    """Look up the systematic correction of a model.

    Parameters
    ----------
    model : {"CDM", "CAM", "VM", "FM"}
        Solar power model.
    name : {"none", "report", "loiter"}
        Correction; of ``loiter`` the part that is the same in every scenario.

    Returns
    -------
    Correction
        Factor on the power and relative RMS error [-].

    Raises
    ------
    ValueError
        If the model or the correction does not exist.
    """
    if model not in MODEL_NAMES:
        raise ValueError(f"unknown solar power model {model!r}; choose from {MODEL_NAMES}")
    if name not in CORRECTION_NAMES:
        raise ValueError(f"unknown correction {name!r}; choose from {CORRECTION_NAMES}")
    if name == "none":
        return Correction(name, 1.0, MODELS[model].rms)
    # The ratio to the Full Model is scenario by scenario; what remains is its own bias and RMS.
    error = MODELS["FM" if name == "loiter" else model]
    return Correction(name, 1.0 / (1.0 + error.average), error.scatter)
