"""Simulators: model files, and objects of Python that step."""

from __future__ import annotations

import functools
import inspect
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _fdiag, _stated
from ._names import nearest
from ._stated import Entries, Uncertain
from .errors import InputError

__all__ = ["Channel", "Model", "Simulator", "Steps"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Channel:
    """A signal with a unit."""

    name: str
    """Its name, as logs have it."""
    unit: str
    """Its unit."""


class Simulator:
    """What is diagnosed. Make one by `Model`, `Steps`, `rollout`, `Process`, `Fmu` or `MuJoCo`."""

    #: Whether the native half can have several that do not know of each other.
    _is_single = False

    def __init__(self, native: _fdiag.Simulator):
        self._native = native

    @functools.cached_property
    def _described(self) -> dict[str, Any]:
        described: dict[str, Any] = json.loads(self._native.described())
        return described

    @property
    def name(self) -> str:
        """What it is called."""
        return str(self._described["name"])

    @property
    def sample_time(self) -> float:
        """Time between samples, in s."""
        return float(self._described["sample_time"])

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """Inputs of a sample."""
        return tuple(Channel(*pair) for pair in self._described["inputs"])

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """Outputs of a sample."""
        return tuple(Channel(*pair) for pair in self._described["outputs"])

    @property
    def parameters(self) -> dict[str, Uncertain]:
        """Parameters with nominal values, tolerances and units; those of effects too."""
        return {
            name: Uncertain(value, tolerance, unit)
            for name, value, tolerance, unit in self._described["parameters"]
        }

    def text(self) -> str:
        """The text of its model file; of an object of Python, that of the equations around it."""
        return self._native.text()

    def simulate(
        self,
        u: npt.ArrayLike | Mapping[str, npt.ArrayLike],
        parameters: Mapping[str, float] | None = None,
        initial: Mapping[str, float] | None = None,
        *,
        sample_time: float | None = None,
    ) -> Array:
        """Outputs `[samples, outputs]` of a run through the inputs `u`, an array `[samples, inputs]` or a dict of
        signals, in the units of the channels and `sample_time` seconds apart. Parameters and initial states that
        are not named have their nominal values. From where the run diverges on all is NaN.

        >>> model = Model(text=LAG)
        >>> model.simulate({"u": [1.0, 1.0, 1.0]}).round(3).ravel().tolist()
        [0.0, 0.095, 0.181]
        """
        ts = self.sample_time if sample_time is None else float(sample_time)
        theta = _values("parameter", {n: p.value for n, p in self.parameters.items()}, parameters)
        nominal = {name: value for name, value, _ in self._described["states"]}
        x0 = _values("initial state", nominal, initial)
        return self._native.simulate(self._rows(u), theta, x0, ts)

    def _rows(self, u: npt.ArrayLike | Mapping[str, npt.ArrayLike]) -> Array:
        names = [channel.name for channel in self.inputs]
        if isinstance(u, Mapping):
            for name in names:
                if name not in u:
                    raise InputError(f"u: expected the input `{name}`, found {_listed(u)}")
            signals = [np.atleast_1d(np.asarray(u[name], dtype=np.float64)) for name in names]
            if len({signal.shape for signal in signals}) > 1 or any(s.ndim != 1 for s in signals):
                shapes = ", ".join(str(list(signal.shape)) for signal in signals)
                raise InputError(f"u: expected signals of one length, found shapes {shapes}")
            return np.ascontiguousarray(np.stack(signals, axis=1))
        rows = np.asarray(u, dtype=np.float64)
        if rows.ndim == 1 and len(names) == 1:
            rows = rows[:, None]
        if rows.ndim != 2 or rows.shape[1] != len(names):
            raise InputError(
                f"u: expected an array of shape [samples, {len(names)}] for {_listed(names)}, "
                f"found {list(rows.shape)}"
            )
        return np.ascontiguousarray(rows)

    def __repr__(self) -> str:
        return f"<fdiag.{type(self).__name__} {self.name}>"


def _listed(names: Any) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


def _values(
    what: str, nominal: Mapping[str, float], asked: Mapping[str, float] | None
) -> list[float]:
    for name in asked or ():
        if name not in nominal:
            raise InputError(f"there is no {what} `{name}`{nearest(name, nominal)}")
    return [float((asked or {}).get(name, value)) for name, value in nominal.items()]


class Model(Simulator):
    """A model file (equations, linear, `kind = "process"`, `"fmu"` or `"engine17"`), or its text.

    >>> Model(text=LAG).outputs
    (Channel(name='y', unit='m'),)
    """

    def __init__(
        self,
        file: str | os.PathLike[str] | None = None,
        *,
        text: str | None = None,
        directory: str | os.PathLike[str] = ".",
    ):
        if (file is None) == (text is None):
            raise InputError("Model: expected a file or a text, found " + ("both" if text else "none"))
        if text is None:
            path = Path(os.fspath(file or ""))
            try:
                text = path.read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as error:
                raise InputError(f"{path}: expected a model file, found: {error}") from error
        else:
            path = Path(directory) / "model.toml"
        super().__init__(_fdiag.Simulator.from_text(text, str(path)))


def rooms_of(
    inputs: Entries,
    outputs: Entries,
    parameters: Entries,
    states: Entries,
    ports: Entries,
    native_effects: Entries = None,
) -> dict[str, list[dict[str, Any]]]:
    said = {
        "inputs": inputs,
        "outputs": outputs,
        "parameters": parameters,
        "states": states,
        "ports": ports,
        "native_effects": native_effects,
    }
    return {room: _stated.entries(room, entries) for room, entries in said.items()}


def lent(
    opener: Any,
    powers: Mapping[str, int],
    *,
    name: str,
    sample_time: float,
    rooms: Mapping[str, list[dict[str, Any]]],
    takes_forces: bool,
    workers: int = 1,
    stacked: int | None = None,
) -> _fdiag.Simulator:
    """A native simulator of an object with `open()`; `stacked` is how many whole runs it takes at once."""
    stated = {
        "name": name,
        "sample_time": float(sample_time),
        **{room: _stated.with_units(entries) for room, entries in rooms.items()},
        "powers": dict(powers),
    }
    return _fdiag.Simulator.lent(json.dumps(stated), opener, takes_forces, int(workers), stacked)


class Opener:
    """Gives a simulator for each worker: what a factory makes, or the one object."""

    def __init__(self, factory: Callable[[], Any]):
        self.open = factory


class Steps(Simulator):
    """An object with `reset(parameters, x0)` and `step(u, f) -> y`, or what makes such objects.

    `parameters` and `x0` are dicts of numbers by name. `u` and `f` are arrays of the inputs and of the forces at
    the ports, held until the next sample; `step(u)` will do where there are no ports. `y` are the outputs of *this*
    sample; then the object moves on. An object may also have

    * `measure(u) -> y`: the outputs of this sample without moving on. Forces that depend on the motion need it, or
      they see the outputs of the sample before;
    * `state() -> x`: the states, in the order of `initial`.

    `native_effects` are effects that the object has in itself, at rest, each a `Native` by the name of its parameter,
    which `reset` gets with the others.

    With `resets=False` an object makes one run: `reset` is called once, and the function makes another object for
    the next run.

    The same run must give the same numbers. Outputs that are not finite, and an `ArithmeticError`, are a run that
    diverges. After a `ConnectionError` another object makes the run again, three times at the most; any other exception
    ends the diagnosis and arrives with its traceback. More than one worker needs a
    function that makes objects, and gains only where they release the interpreter.
    """

    def __init__(
        self,
        simulator: Any,
        *,
        sample_time: float,
        inputs: Entries,
        outputs: Entries,
        parameters: Entries = None,
        initial: Entries = None,
        ports: Entries = None,
        native_effects: Entries = None,
        name: str | None = None,
        workers: int = 1,
        resets: bool = True,
    ):
        is_object = hasattr(simulator, "step") and not isinstance(simulator, type)
        factory = (lambda: simulator) if is_object else simulator
        if not callable(factory):
            raise InputError(
                "simulator: expected an object with `reset` and `step`, or a function that makes one, found a value "
                f"of type `{type(simulator).__name__}`"
            )
        if is_object and workers != 1:
            raise InputError("workers: expected 1 for a single object, or a function that makes objects")
        if is_object and not resets:
            raise InputError("resets: expected a function that makes objects, of which each makes one run, found an object")
        probe = simulator if is_object else factory()
        for method in ("reset", "step"):
            if not callable(getattr(probe, method, None)):
                kind = type(probe).__name__
                raise InputError(f"simulator: `{kind}` has no method `{method}`")
        rooms = rooms_of(inputs, outputs, parameters, initial, ports, native_effects)
        takes_forces = takes(getattr(probe, "step"), 2)
        if rooms["ports"] and not takes_forces:
            raise InputError("ports: expected a method `step(u, f)`, found one that takes no forces")
        powers = {
            "step": True,
            "resets": bool(resets),
            "measure": callable(getattr(probe, "measure", None)),
            "states": callable(getattr(probe, "state", None)) and bool(rooms["states"]),
        }
        native = lent(
            Opener(factory),
            powers,
            name=name or type(probe).__name__,
            sample_time=sample_time,
            rooms=rooms,
            takes_forces=takes_forces,
            workers=workers,
        )
        super().__init__(native)
        self._is_single = is_object


def takes(function: Callable[..., Any], count: int) -> bool:
    """Whether a function or bound method can be called with so many arguments."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return True
    of_place = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    names = [p.name for p in of_place if p.name != "self"]
    return len(names) >= count or any(p.kind is p.VAR_POSITIONAL for p in parameters)


def as_simulator(model: Any) -> Simulator:
    """A simulator, a path, a text, or an object that says itself what it is."""
    if isinstance(model, Simulator):
        return model
    if isinstance(model, str) and "\n" in model:
        return Model(text=model)
    if isinstance(model, (str, os.PathLike)):
        return Model(model)
    if hasattr(model, "step") and hasattr(model, "reset"):
        said: dict[str, Any] = {
            key: getattr(model, key, None)
            for key in (
                "sample_time",
                "inputs",
                "outputs",
                "parameters",
                "initial",
                "ports",
                "native_effects",
                "name",
            )
        }
        for key in ("sample_time", "inputs", "outputs"):
            if said[key] is None:
                kind = type(model).__name__
                raise InputError(
                    f"model: `{kind}` has no attribute `{key}`: give it one, or use fdiag.Steps(...)"
                )
        name = said.pop("name")
        return Steps(model, name=name if isinstance(name, str) else None, **said)
    raise InputError(
        "model: expected a path, the text of a model file, a simulator, or an object with `reset` and `step`, found "
        f"a value of type `{type(model).__name__}`"
    )
