"""All uncertain parameters of a simulator from logs: values, errors, and what the logs cannot tell."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _fdiag, _settings
from ._frames import frame
from ._logs import Log, native
from .simulators import as_simulator

__all__ = ["Calibrated", "Calibration", "Combination", "FittedOutput", "calibrate"]


@dataclass(frozen=True)
class Calibrated:
    """A parameter after the fit."""

    name: str
    """Name in the simulator."""
    unit: str
    """Unit."""
    nominal: float
    """What the simulator says."""
    value: float
    """What fits best."""
    tolerances: float
    """How far that is from what the simulator says, in tolerances."""
    standard_error: float
    """Standard error, in the unit, with everything else unknown as well."""
    of_prior: float
    """That in parts of what was known before."""
    standing: str
    """`found`, `in-combination` (fixed only together with others), `unmoved` or `at-edge` (of its tolerance or bounds)."""


@dataclass(frozen=True)
class Combination:
    """Parameters that the logs fix only together, or not at all."""

    parts: tuple[tuple[str, float], ...]
    """The parameters with their parts of the direction, the largest first."""
    of_prior: float
    """Standard deviation along it, in parts of what it was before."""


@dataclass(frozen=True)
class FittedOutput:
    """An output before and after, root mean squares in its unit."""

    name: str
    """Name."""
    unit: str
    """Unit."""
    noise: float
    """Noise: stated, else as the logs show it."""
    before: float
    """Residual with the values of the simulator."""
    after: float
    """With the calibrated ones."""


@dataclass(frozen=True)
class Calibration:
    """What a calibration has found. In a notebook it shows itself."""

    headline: str
    """The answer in one or two sentences, with what is left."""
    parameters: tuple[Calibrated, ...]
    """The uncertain parameters, in the order of the simulator."""
    correlations: npt.NDArray[np.float64]
    """Correlations of their errors."""
    open: tuple[Combination, ...]
    """Combinations that the logs have not fixed."""
    outputs: tuple[FittedOutput, ...]
    """The outputs."""
    measured: int
    """Measured values that were compared."""
    text: str
    """The file of the simulator with the values in it."""

    @property
    def values(self) -> dict[str, float]:
        """Calibrated values by name."""
        return {p.name: p.value for p in self.parameters}

    def to_frame(self, library: str | None = None) -> Any:
        """The table of the parameters as a data frame of pandas, polars, or the library that is named."""
        names = [field.name for field in fields(Calibrated)]
        return frame({name: [getattr(p, name) for p in self.parameters] for name in names}, library)

    def __str__(self) -> str:
        rows = [
            f"{p.name:16} {p.value:.6g} ± {p.standard_error:.2g} {p.unit} (stated {p.nominal:.6g}): {p.standing}"
            for p in self.parameters
        ]
        return "\n".join([self.headline, *rows])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in ("parameter", "unit", "stated", "calibrated", "error", "finding"))
        cells = (
            (p.name, p.unit, f"{p.nominal:.6g}", f"{p.value:.6g}", f"{p.standard_error:.2g}", p.standing)
            for p in self.parameters
        )
        rows = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in cells)
        return f"<p>{html.escape(self.headline)}</p><table><tr>{head}</tr>{rows}</table>"


def calibrate(
    simulator: Any,
    log: Log | list[Log],
    *,
    columns: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    tolerance: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    sample_time: float | None = None,
) -> Calibration:
    """Fits all uncertain parameters of a simulator to logs, and says what the logs cannot tell.

    Parameters
    ----------
    simulator
        As `gap` takes it.
    log
        A log or a list of logs, as `gap` takes them; all are fitted together.
    columns
        A column map: a TOML file, or a dict of the same keys.
    tolerance
        How well parameters are known, relative to their values, instead of what the simulator says; 0 for exactly.
    noise
        Standard deviations of the noise of outputs, in their units, instead of what the simulator says.
    sample_time
        Time between the rows of arrays without a column of time, in s.

    Examples
    --------
    >>> found = calibrate(CART, MONDAY)
    >>> list(found.values), found.correlations.shape
    (['m', 'd'], (2, 2))
    """
    model = as_simulator(simulator)
    mapped = _settings.columns(columns)
    logs = native(log, "log", sample_time, lambda: _settings.needed(model, mapped))
    pairs = {"tolerances": tolerance, "noise": noise}
    named = {key: [(name, float(value)) for name, value in (said or {}).items()] for key, said in pairs.items()}
    settings = {"columns": mapped, **named}
    answer, text = _fdiag.calibrate(model._native, logs, json.dumps(settings))
    found = json.loads(answer)
    return Calibration(
        headline=found["headline"],
        parameters=tuple(Calibrated(**p) for p in found["parameters"]),
        correlations=np.array(found["correlations"], dtype=np.float64),
        open=tuple(Combination(tuple((n, v) for n, v in c["parts"]), c["of_prior"]) for c in found["open"]),
        outputs=tuple(FittedOutput(**o) for o in found["outputs"]),
        measured=found["measured"],
        text=text,
    )
