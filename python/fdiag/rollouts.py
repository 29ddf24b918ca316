"""Functions of Python that make whole runs, one or many at a time."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy.typing as npt

from . import _fdiag
from ._stated import Entries
from .errors import InputError
from .simulators import Opener, Simulator, lent, rooms_of, takes

__all__ = ["Rollout", "rollout"]

#: Most runs that are stacked for one call.
LANES = 256


class Rollout(Simulator):
    """A function that makes whole runs, as a simulator. Still a function: calling it calls the function."""

    def __init__(self, function: Callable[..., npt.ArrayLike], native: _fdiag.Simulator):
        super().__init__(native)
        self._function = function
        functools.update_wrapper(self, function)

    def __call__(self, *args: Any, **kwargs: Any) -> npt.ArrayLike:
        return self._function(*args, **kwargs)


class _Runs:
    """What the native half asks for whole runs."""

    def __init__(self, function: Callable[..., npt.ArrayLike]):
        self.rollout = function


def rollout(
    *,
    inputs: Entries,
    outputs: Entries,
    sample_time: float,
    parameters: Entries = None,
    initial: Entries = None,
    ports: Entries = None,
    native_effects: Entries = None,
    vectorised: bool = False,
    name: str | None = None,
) -> Callable[[Callable[..., npt.ArrayLike]], Rollout]:
    """Makes a simulator of a function `(parameters, x0, u) -> y` that makes a whole run.

    `parameters` and `x0` are dicts of numbers by name, `u` an array `[samples, inputs]`, `y` one of
    `[samples, outputs]`. With ports the function is `(parameters, x0, u, f)`, `f` an array `[samples, ports]`.
    A force that depends on the motion, as friction does, takes two runs where the plant is linear and more where it is
    not: until the forces are those that follow from the outputs.

    `native_effects` are effects that the function has in itself, at rest, as of `Steps`.

    A function that is `vectorised` makes many runs at once: everything has an axis of runs in front. `parameters` and
    `x0` are dicts of arrays `[runs]`, `u` is `[runs, samples, inputs]`, `f` `[runs, samples, ports]` and `y`
    `[runs, samples, outputs]`. A run must be the same whatever is beside it; one that diverges has values that are not
    finite.

    >>> @rollout(inputs=["u"], outputs=["y"], sample_time=0.1, parameters={"k": 2.0})
    ... def gain(parameters, x0, u):
    ...     return parameters["k"] * u
    >>> gain.simulate([1.0, 2.0], {"k": 3.0}).ravel().tolist()
    [3.0, 6.0]
    >>> @rollout(inputs=["u"], outputs=["y"], sample_time=0.1, parameters={"k": 2.0}, vectorised=True)
    ... def gains(parameters, x0, u):
    ...     return parameters["k"][:, None, None] * u
    >>> gains.simulate([1.0, 2.0], {"k": 3.0}).ravel().tolist()
    [3.0, 6.0]
    """

    def made(function: Callable[..., npt.ArrayLike]) -> Rollout:
        rooms = rooms_of(inputs, outputs, parameters, initial, ports, native_effects)
        takes_forces = takes(function, 4)
        if rooms["ports"] and not takes_forces:
            raise InputError("ports: expected a function `(parameters, x0, u, f)`, found one without forces")
        native = lent(
            Opener(lambda: _Runs(function)),
            {"step": False, "rollout": True},
            name=name or str(getattr(function, "__name__", "function")),
            sample_time=sample_time,
            rooms=rooms,
            takes_forces=takes_forces,
            stacked=LANES if vectorised else None,
        )
        return Rollout(function, native)

    return made
