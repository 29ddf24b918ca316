"""The on-line side: a diagnosis that is trained once, and its pipeline, which sees sample after sample."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _fdiag
from ._logs import Log, native
from ._names import nearest
from .errors import InputError
from .simulators import Channel

__all__ = ["Pipeline", "Run", "Step", "Trained", "spec"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Step:
    """What a pipeline makes of one sample."""

    residual: Array
    """Primary residual, one number per residual channel, in the units of the model."""
    compensated: Array
    """The same less the simulated bias."""
    statistic: float
    """Test statistic; a pure number."""
    threshold: float
    """The largest value of it that is normal."""
    is_compensating: bool
    """Whether the bias was subtracted."""
    is_alarm: bool
    """Whether a fault is reported."""
    events: tuple[str, ...]
    """What happened at this sample."""


@dataclass(frozen=True)
class Run:
    """What a pipeline makes of many samples: one row each."""

    residual: Array
    """`[samples, residuals]`; NaN in rows that were refused."""
    compensated: Array
    """`[samples, residuals]`."""
    statistic: Array
    """`[samples]`."""
    threshold: Array
    """`[samples]`."""
    compensating: npt.NDArray[np.bool_]
    """Whether the bias was subtracted."""
    alarm: npt.NDArray[np.bool_]
    """Whether a fault is reported."""
    refused: npt.NDArray[np.bool_]
    """Samples that were missing for too long, and left out."""
    events: tuple[tuple[int, str], ...]
    """Row and what happened."""

    def first_alarm(self) -> int | None:
        """The first row with an alarm."""
        rows = np.flatnonzero(self.alarm)
        return int(rows[0]) if len(rows) else None


class Pipeline:
    """Samples in, alarms out. It remembers what it has seen; `reset` makes it forget."""

    def __init__(self, native_pipeline: _fdiag.Pipeline, trained: Trained):
        self._native = native_pipeline
        self._trained = trained

    def step(
        self, u: npt.ArrayLike | Mapping[str, float], y: npt.ArrayLike | Mapping[str, float]
    ) -> Step:
        """One sample: inputs and outputs in the units of the channels, as arrays or dicts.

        Raises `InputError` when a value is missing and the spec does not hold missing samples; the pipeline is then
        as it was.
        """
        now = _row("u", u, self._trained.inputs)
        out = _row("y", y, self._trained.outputs)
        residual, compensated, statistic, threshold, on, alarm, events = self._native.step(now, out)
        return Step(residual, compensated, statistic, threshold, on, alarm, tuple(events))

    def run(
        self,
        u: npt.ArrayLike | Mapping[str, npt.ArrayLike],
        y: npt.ArrayLike | Mapping[str, npt.ArrayLike],
    ) -> Run:
        """Many samples, `[samples, inputs]` and `[samples, outputs]` or dicts of signals, from where the pipeline
        stands, without a loop in Python."""
        now = _rows("u", u, self._trained.inputs)
        out = _rows("y", y, self._trained.outputs)
        run = self._native.run(now, out)
        return Run(**{**run, "events": tuple(run["events"])})

    def reset(self) -> None:
        """Forgets all samples; what was learned in training stays."""
        self._native.reset()

    def snapshot(self) -> str:
        """Its memory as text: a pipeline that is restored from it goes on to the bit."""
        return self._native.snapshot()

    def restore(self, snapshot: str) -> None:
        """Puts a memory back; one of another pipeline is refused."""
        self._native.restore(snapshot)


class Trained:
    """A diagnosis that has learned from healthy logs. Made by `spec(...)`."""

    def __init__(self, native_trained: _fdiag.Trained):
        self._native = native_trained
        self._described: dict[str, Any] = json.loads(native_trained.described())

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """Inputs of a sample."""
        return tuple(Channel(*pair) for pair in self._described["inputs"])

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """Outputs of a sample."""
        return tuple(Channel(*pair) for pair in self._described["outputs"])

    @property
    def sample_time(self) -> float:
        """Time between samples, in s."""
        return float(self._described["sample_time"])

    @property
    def theta(self) -> Array:
        """Parameters of the bias model, one list per residual channel after the other."""
        return np.array(self._described["theta"], dtype=np.float64).reshape(-1)

    @property
    def events(self) -> tuple[str, ...]:
        """What happened in training."""
        return tuple(self._described["events"])

    def pipeline(self, *, compensated: bool = True) -> Pipeline:
        """A new pipeline at its beginning; without compensation it is the one to compare with."""
        return Pipeline(self._native.pipeline(compensated), self)


def spec(
    model: str | os.PathLike[str],
    healthy: Log | Sequence[Log],
    description: str | os.PathLike[str] = "",
    *,
    learn_share: float = 0.7,
    columns: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    sample_time: float | None = None,
) -> Trained:
    """Trains what a spec describes: residual generator, bias model, compensator, detector and rule.

    Parameters
    ----------
    model
        A linear model file, or its text.
    healthy
        Logs of the healthy plant, as `gap` takes logs.
    description
        The spec: TOML text, or a path (docs/spec.md). Without it the defaults of `fdiag compensate`.
    learn_share
        Share of each log, from its start, that the bias is learned from; the threshold is taken from the rest.
    columns
        A column map: a TOML file, or a dict of the same keys.
    sample_time
        Time between the rows of arrays without a column of time, in s.
    """
    if not 0.0 < learn_share < 1.0:
        raise InputError(f"learn_share: expected a number between 0 and 1, found {learn_share}")
    is_text = isinstance(model, str) and "\n" in model
    text = model if is_text else _read(model)
    file = "model.toml" if is_text else os.fspath(model)
    is_spec = isinstance(description, str) and ("=" in description or not description)
    said = description if is_spec else _read(description)
    mapped = None
    if columns is not None:
        is_map = isinstance(columns, Mapping)
        mapped = json.dumps(columns) if is_map else _fdiag.column_map(os.fspath(columns))  # type: ignore[arg-type]
    logs = native(healthy, "healthy", sample_time)
    return Trained(_fdiag.Trained(str(text), file, str(said), logs, float(learn_share), mapped))


def _read(file: str | os.PathLike[str]) -> str:
    try:
        return Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{os.fspath(file)}: expected a file of text, found: {error}") from error


def _named(what: str, values: Mapping[str, Any], channels: Sequence[Channel]) -> list[Any]:
    names = [channel.name for channel in channels]
    for name in names:
        if name not in values:
            raise InputError(f"{what}: there is no `{name}`{nearest(name, values)}")
    return [values[name] for name in names]


def _row(what: str, values: Any, channels: Sequence[Channel]) -> Array:
    if isinstance(values, Mapping):
        values = _named(what, values, channels)
    return np.ascontiguousarray(np.atleast_1d(np.asarray(values, dtype=np.float64)))


def _rows(what: str, values: Any, channels: Sequence[Channel]) -> Array:
    if isinstance(values, Mapping):
        signals = [np.asarray(v, dtype=np.float64) for v in _named(what, values, channels)]
        if any(s.ndim != 1 for s in signals) or len({s.shape for s in signals}) > 1:
            shapes = ", ".join(str(list(s.shape)) for s in signals)
            raise InputError(f"{what}: expected signals of one length, found shapes {shapes}")
        values = np.stack(signals, axis=1)
    rows = np.asarray(values, dtype=np.float64)
    if rows.ndim == 1 and len(channels) == 1:
        rows = rows[:, None]
    if rows.ndim != 2 or rows.shape[1] != len(channels):
        names = ", ".join(f"`{channel.name}`" for channel in channels)
        raise InputError(
            f"{what}: expected an array of shape [samples, {len(channels)}] for {names}, found {list(rows.shape)}"
        )
    return np.ascontiguousarray(rows)
