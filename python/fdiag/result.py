"""What a diagnosis says."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _fdiag
from ._frames import frame
from .calibration import Calibrated
from .errors import Error
from .simulators import Simulator

if TYPE_CHECKING:
    from ._mjcf import WrittenScene
    from matplotlib.figure import Figure

__all__ = ["Cause", "Closed", "Finding", "HeldOut", "Parameter", "Result", "Signals", "Trace", "Work"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Parameter:
    """A parameter of a cause, as it was fitted."""

    name: str
    """Its name in the patched model."""
    value: float
    """Its value, in the unit."""
    standard_error: float
    """Its standard error, in the unit."""
    unit: str
    """Its unit."""
    is_strength: bool
    """Whether 0 means that the effect is absent."""


@dataclass(frozen=True)
class Cause:
    """An effect at a place that may be what the simulator lacks."""

    label: str
    """The effect, such as `coulomb-friction`."""
    place: str | None
    """Name of the input, site, state, parameter or output; `None` for the model as a whole."""
    side: str
    """`input`, `dynamics` or `output`."""
    family: str
    """The mechanism."""
    law: str
    """The law with the most evidence."""
    probability: float
    """Probability, 0 to 1, all laws of the effect together."""
    is_tied: bool
    """Whether this log cannot tell it from the first cause."""
    parameters: tuple[Parameter, ...]
    """The fitted parameters."""
    gap: float
    """Root mean square of what it leaves of the fitted logs, in standard deviations of the noise."""

    @property
    def name(self) -> str:
        """Label and place, as `exclude` and `only` take them."""
        return self.label if self.place is None else f"{self.label}@{self.place}"


@dataclass(frozen=True)
class Closed:
    """How much of a gap is closed, above the noise."""

    fraction: float
    """Share, 1 for all of it; negative is harm."""
    interval: tuple[float, float]
    """Its 95 % interval."""


@dataclass(frozen=True)
class HeldOut:
    """Errors of forecasts on data that no fit has seen: root mean squares per output, in its unit."""

    horizon: str
    """`free-run` or `windows`."""
    seconds: float
    """Length of a forecast, in s."""
    nominal: tuple[float, ...]
    """Of the model as it came."""
    refit: tuple[float, ...]
    """With its parameters refitted."""
    after: tuple[float, ...]
    """With the best explanation."""
    floor: tuple[float, ...]
    """The noise floor."""
    closed: Closed | None
    """Share of the gap of the refitted model that the explanation closes; `None` where refitting leaves none."""


@dataclass(frozen=True)
class Finding:
    """Something about a log that its owner should know."""

    file: str
    """The log."""
    channel: str
    """The channel."""
    severity: str
    """`note`, `warning` or `serious`."""
    defect: dict[str, Any]
    """What it is, as in the report."""


@dataclass(frozen=True)
class Signals:
    """An output over time, in its unit; NaN where there is no value."""

    name: str
    unit: str
    measured: Array
    """As logged."""
    before: Array
    """Simulated with the model as it came."""
    after: Array
    """Simulated with the best explanation."""


@dataclass(frozen=True)
class Trace:
    """Measured and simulated outputs of one log."""

    role: str
    """`heldout` for data that no fit has seen, `fit` for others."""
    time: Array
    """Times, in s from the start of the log."""
    outputs: tuple[Signals, ...]


@dataclass(frozen=True)
class Work:
    """What was asked of a simulator outside of Rust."""

    asked: int
    """Runs asked for."""
    made: int
    """Runs made; the others were remembered."""
    repeated: int
    """Runs made again up to some sample."""
    steps: int
    """Steps."""
    deaths: int
    """How often a simulator ended."""
    lost: int
    """Runs that nothing came of."""
    seconds: float
    """Time inside of the simulator, in s, all workers together."""
    trouble: str | None
    """What went wrong last."""


def _numbers(values: Any) -> tuple[float, ...]:
    return tuple(float("nan") if value is None else float(value) for value in values)


def _number(value: Any) -> float:
    return float("nan") if value is None else float(value)


class Result:
    """The answer of a diagnosis. In a notebook it shows itself.

    `to_dict()` is all of it, as `report.json` of the command line; docs/gap-report.md names every key.
    """

    def __init__(
        self,
        study: _fdiag.Study,
        inputs: tuple[tuple[str, str], ...] = (),
        simulator: Simulator | None = None,
    ):
        self._study = study
        self._simulator = simulator
        self._inputs = inputs
        self._json = study.json()
        self._report: dict[str, Any] = json.loads(self._json)

    @property
    def headline(self) -> str:
        """What came out, in one sentence."""
        return str(self._report["headline"])

    @property
    def verdict(self) -> str:
        """`no-gap`, `cause`, `tied`, `pair`, `none-of-these` or `unclear`."""
        return str(self._report["diagnosis"]["verdict"])

    @property
    def no_gap(self) -> float:
        """Probability that the model with refitted parameters explains the logs."""
        return _number(self._report["diagnosis"]["no_gap"])

    @property
    def none_of_these(self) -> float:
        """Probability that nothing that was tried is right."""
        return _number(self._report["diagnosis"]["none_of_these"])

    @property
    def causes(self) -> tuple[Cause, ...]:
        """Effects at places, the most probable first."""
        diagnosis = self._report["diagnosis"]
        tied = set(diagnosis["tied"]) if len(diagnosis["tied"]) > 1 else set()
        return tuple(_cause(c, i in tied) for i, c in enumerate(diagnosis["causes"]))

    @property
    def pairs(self) -> tuple[tuple[Cause, Cause], ...]:
        """Two causes that act together, the best first, with the parameters of the joint fit."""
        pairs = self._report["diagnosis"]["pairs"]
        return tuple((_cause(p["causes"][0], False), _cause(p["causes"][1], False)) for p in pairs)

    @property
    def road(self) -> tuple[Cause, ...]:
        """Several causes, in the order in which they were accepted, where one does not explain the logs."""
        road = self._report["road"]
        return tuple(_cause(m["cause"], False) for m in road["causes"]) if road else ()

    @property
    def parameters(self) -> tuple[Calibrated, ...]:
        """The uncertain parameters of the simulator with the best explanation, and what the logs say of each."""
        return tuple(Calibrated(**p) for p in self._report["diagnosis"]["parameters"])

    @property
    def held_out(self) -> tuple[HeldOut, ...]:
        """How far the gap shrinks on held-out data, one entry per horizon, that of the fit first."""
        return tuple(_held_out(entry) for entry in self._report["diagnosis"]["held_out"])

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong with the logs, the worst first."""
        keys = ("file", "channel", "severity")
        return tuple(
            Finding(
                f["file"],
                f["channel"],
                f["severity"],
                {key: value for key, value in f.items() if key not in keys},
            )
            for f in self._report["findings"]
        )

    @property
    def next(self) -> tuple[str, ...]:
        """What to do next, the most useful first."""
        return tuple(self._report["next"])

    @property
    def seconds(self) -> float:
        """How long it took, in s."""
        return float(self._report["timing"]["seconds"])

    @property
    def work(self) -> Work | None:
        """What was asked of a simulator outside of Rust; `None` for models of equations."""
        work = self._study.work()
        return None if work is None else Work(*work[0], seconds=work[1], trouble=work[2])

    @property
    def foretold(self) -> float | None:
        """Share of a disturbance that a simulator outside of Rust foretells when it is linearised along the logs, so
        that causes could be proposed with few runs; `None` where everything was tried on the simulator itself."""
        sparing = self._report["sparing"]
        return None if sparing is None else _number(sparing["foretold"])

    @property
    def trace(self) -> Trace | None:
        """Measured and simulated outputs of the first held-out log, as forecast for the headline, or of the first log."""
        trace = self._study.trace()
        if trace is None:
            return None
        role, time, outputs = trace
        return Trace(role, time, tuple(Signals(**signals) for signals in outputs))

    def to_dict(self) -> dict[str, Any]:
        """All of it: the object that `report.json` holds."""
        report: dict[str, Any] = json.loads(self._json)
        return report

    def to_json(self) -> str:
        """The text of `report.json`."""
        return self._json

    def to_frame(self, library: str | None = None) -> Any:
        """Causes as a data frame, one row per parameter: of pandas if it is there, else of polars, or of the
        `library` that is named."""
        rows: dict[str, list[Any]] = {
            key: []
            for key in (
                "cause",
                "probability",
                "is_tied",
                "law",
                "side",
                "parameter",
                "value",
                "standard_error",
                "unit",
            )
        }
        for cause in self.causes:
            for parameter in cause.parameters:
                row = (
                    cause.name,
                    cause.probability,
                    cause.is_tied,
                    cause.law,
                    cause.side,
                    parameter.name,
                    parameter.value,
                    parameter.standard_error,
                    parameter.unit,
                )
                for column, value in zip(rows.values(), row):
                    column.append(value)
        return frame(rows, library)

    def save(self, directory: str | os.PathLike[str] = "fdiag-report") -> Path:
        """Writes the report of the command line: `report.html`, `report.json` and the patched models. Returns the
        page."""
        path = Path(directory)
        path.mkdir(parents=True, exist_ok=True)
        for name, text in self._study.models():
            _write(path / name, text)
        _write(path / "report.json", self._json)
        _write(path / "report.html", self._study.html())
        return path / "report.html"

    def patched(self, which: int = 0) -> Simulator:
        """The simulator with the best explanation in it, or with another one that is tied with it."""
        models = self._study.models()
        if not -len(models) <= which < len(models):
            raise Error(f"patched: expected one of {len(models)} models, found {which}")
        return Simulator(self._study.patched(*models[which]))

    def write_mjcf(self, path: str | os.PathLike[str], which: int = 0) -> WrittenScene:
        """Writes the MuJoCo scene with the best explanation in it, or with another one that is tied with it: the
        parameters that were refitted, and the causes that MJCF can hold. Says which these are, and which remain in the
        shell around the scene, where `patched()` has them all.

        The scene must have been given as a file or a text. Meshes and textures are looked for from the new file on.
        """
        from .mujoco import MuJoCo

        scene = getattr(self._simulator, "here", self._simulator)
        if not isinstance(scene, MuJoCo):
            raise Error("write_mjcf: expected the result of a scene, a `MuJoCo`, found one of another simulator")
        values, _ = self.patched(which)._native.handed_on()
        return scene._written(values, self._named(which), path)

    def _named(self, which: int) -> tuple[Cause, ...]:
        """The causes that are in a patched model."""
        if which:
            return (tuple(cause for cause in self.causes if cause.is_tied)[which],)
        if self.road:
            return self.road
        if self.verdict == "no-gap":
            return ()
        return self.pairs[0] if self.verdict == "pair" and self.pairs else self.causes[:1]

    def plot(self, output: str | int | None = None) -> Figure:
        """Measured and simulated outputs, before and after, with matplotlib."""
        from . import _plot

        return _plot.plot(self, output)

    def __repr__(self) -> str:
        return f"<fdiag.Result {self.verdict}: {self.headline}>"

    def _repr_html_(self) -> str:
        parts = [f"<p><b>{html.escape(self.headline)}</b></p>"]
        tables = [table for table in self._study.tables() if table[0] in ("Cause", "Several causes")]
        for title, header, rows in tables[:1]:
            head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
            body = "".join(
                "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
                for row in rows
            )
            parts.append(f"<table><caption>{html.escape(title)}</caption><tr>{head}</tr>{body}</table>")
        picture = self._study.picture(720, 300)
        return "".join(parts) + (picture or "")


def _cause(cause: dict[str, Any], is_tied: bool) -> Cause:
    parameters = tuple(
        Parameter(
            p["name"], _number(p["value"]), _number(p["standard_error"]), p["unit"], p["is_strength"]
        )
        for p in cause["parameters"]
    )
    return Cause(
        label=cause["label"],
        place=cause["site"].get("name"),
        side=cause["side"],
        family=cause["family"],
        law=cause["law"],
        probability=_number(cause["probability"]),
        is_tied=is_tied,
        parameters=parameters,
        gap=_number(cause["gap"]),
    )


def _held_out(entry: dict[str, Any]) -> HeldOut:
    closed = entry["closed_of_refit"]
    return HeldOut(
        horizon=entry["horizon"]["kind"],
        seconds=_number(entry["seconds"]),
        nominal=_numbers(entry["nominal"]),
        refit=_numbers(entry["refit"]),
        after=_numbers(entry["after"]),
        floor=_numbers(entry["floor"]),
        closed=closed
        and Closed(
            _number(closed["fraction"]),
            (_number(closed["interval"][0]), _number(closed["interval"][1])),
        ),
    )


def _write(path: Path, text: str) -> None:
    """As a whole: it appears complete or not at all."""
    part = path.with_name(f".{path.name}.part")
    with open(part, "w", encoding="utf-8", newline="") as file:
        file.write(text)
    os.replace(part, path)
