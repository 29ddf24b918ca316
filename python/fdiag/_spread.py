"""One simulator whose runs are made by actors of Ray."""

from __future__ import annotations

import importlib
import itertools
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _fdiag
from .errors import Error, InputError
from .simulators import Simulator, as_simulator

__all__ = ["Spread", "started"]

Array = npt.NDArray[np.float64]
#: So often Ray is started, and an actor that dies before it has a simulator.
_STARTS = 3


def started(**settings: Any) -> Any:
    """The package `ray`, started on this machine (by `ray.init` with these settings) unless somebody has started it or has
    named a cluster."""
    try:
        ray: Any = importlib.import_module("ray")
    except ImportError as error:
        raise Error("ray: expected the package to be installed: pip install ray") from error
    for start in range(_STARTS):
        if ray.is_initialized():
            break
        try:
            ray.init(**{"include_dashboard": False, "log_to_driver": False, **settings})
        except Exception as error:
            ray.shutdown()
            # Ray has no class for that. Its node gives up where the processes beside it are not there after 15 s.
            if type(error) is not Exception:
                raise
            if start + 1 == _STARTS:
                raise Error(
                    f"ray: expected it to start on this machine, found {_STARTS} times: {error} Is the machine busy? "
                    "A cluster that runs already can be named by RAY_ADDRESS."
                ) from error
    return ray


class Spread(Simulator):
    """A simulator whose runs are made by actors of Ray, several at the same time. A diagnosis of it gives the answer of
    one machine, to the bit.

    A run is one call, also where forces depend on the motion: the equations of a candidate are sent to the actor. What is
    stepped by itself, as in a linearisation from states, takes a call per step. A call takes some milliseconds, so this is
    for simulators of which a run takes longer.

    A run whose actor or node is lost is made again by another one. Three losses at the same parameters are a run that
    diverges there.

    Parameters
    ----------
    make
        A function that makes the simulator: `Steps`, `rollout`, `MuJoCo`, `Gymnasium`, `Process`, `Fmu`, or an object
        that says itself what it is. It is called once here, and once in each actor; files that it reads must be there.
        Not a model of equations, whose runs take less time than to ask for them.
    actors
        How many there are at most. They are started when they are needed.
    lanes
        How many runs an actor is asked for in one call, if the simulator does not say so itself. In each actor as many
        simulators step side by side.
    cpus
        Processors of an actor.
    patience
        How long, in s, an actor may take to start, before a diagnosis gives up.

    `sought = fdiag.gap(fdiag.ray.Spread(make_plant, actors=8), "monday.csv")`
    """

    def __init__(
        self,
        make: Callable[[], Any],
        *,
        actors: int,
        lanes: int = 16,
        cpus: float = 1.0,
        patience: float = 120.0,
    ):
        if not callable(make) or isinstance(make, Simulator):
            raise InputError(
                "make: expected a function that makes a simulator, which every actor calls, found a value of type "
                f"`{type(make).__name__}`"
            )
        for name, count in (("actors", actors), ("lanes", lanes)):
            if int(count) < 1:
                raise InputError(f"{name}: expected at least 1, found {count}")
        for name, value in (("cpus", cpus), ("patience", patience)):
            if not 0.0 < value < float("inf"):
                raise InputError(f"{name}: expected a number above 0, found {value}")
        #: The simulator as it is here, of which no runs are asked.
        self.here: Simulator = as_simulator(make())
        #: Threads that do nothing but wait for an actor.
        self.least_threads = int(actors)
        opener = _Opener(started(), make, int(actors), float(cpus), float(patience))
        super().__init__(self.here._native.elsewhere(opener, int(actors), int(lanes)))


class _Opener:
    """Gives what the native half asks for runs, of the actor that has the fewest of them."""

    def __init__(self, ray: Any, make: Callable[[], Any], actors: int, cpus: float, patience: float):
        self._ray, self._patience = ray, patience
        self._make = ray.put(make)
        self._host = ray.remote(num_cpus=cpus, max_restarts=0, max_task_retries=0)(Host)
        self._cpus = cpus
        self._lock = threading.Lock()
        self._actors: list[Any] = [None] * actors
        self._asked = [0] * actors
        self._numbers = itertools.count()

    def open(self) -> _Session:
        for start in range(_STARTS):
            with self._lock:
                room = min(range(len(self._asked)), key=lambda i: self._asked[i])
                if self._actors[room] is None:
                    self._actors[room] = self._host.remote(self._make)
                actor, number = self._actors[room], next(self._numbers)
                self._asked[room] += 1
            try:
                self._ray.get(actor.open.remote(number), timeout=self._patience)
                return _Session(self, room, actor, number)
            except self._ray.exceptions.RayActorError as error:
                self.bury(room, actor)
                self.closed(room)
                if start + 1 == _STARTS:
                    raise Error(f"an actor ends before it has a simulator: {_first_line(error)}") from error
            except self._ray.exceptions.GetTimeoutError as error:
                self.closed(room)
                raise Error(
                    f"an actor: expected to be ready within {self._patience} s, found none: are {self._cpus} processors free?"
                ) from error
        raise AssertionError

    def ask(self, room: int, actor: Any, number: int, *asked: Any) -> Any:
        try:
            return self._ray.get(actor.ask.remote(number, *asked))
        except self._ray.exceptions.RayActorError as error:
            self.bury(room, actor)
            # The native half then asks another one.
            raise ConnectionError(_first_line(error)) from error

    def bury(self, room: int, actor: Any) -> None:
        """Another actor takes the room of one that is lost."""
        with self._lock:
            if self._actors[room] is actor:
                self._actors[room] = None

    def closed(self, room: int) -> None:
        with self._lock:
            self._asked[room] -= 1


class _Session:
    """The runs of one instance of the native half, by one actor."""

    def __init__(self, opener: _Opener, room: int, actor: Any, number: int):
        self._opener, self._at, self._actor, self._number = opener, (room, actor, number), actor, number

    def ask(
        self, op: str, starts: Array, rows: Array, runs: int, samples: int, around: tuple[str, float] | None
    ) -> Any:
        return self._opener.ask(*self._at, op, starts, rows, runs, samples, around)

    def __del__(self) -> None:
        try:
            self._opener.closed(self._at[0])
            self._actor.close.remote(self._number)
        except Exception:  # The interpreter, or Ray, is at its end.
            pass


class Host:
    """What an actor is: the simulator, and what has begun in it, by the number of the session."""

    def __init__(self, make: Callable[[], Any]):
        self._make = make
        self._simulator: Simulator | None = self._another()
        self._is_single = self._simulator._is_single
        self._hosted: dict[int, _fdiag.Hosted] = {}

    def _another(self) -> Simulator:
        return as_simulator(self._make())

    def open(self, number: int) -> None:
        simulator = self._simulator or self._another()
        if self._is_single:
            # Each run that is under way needs one of its own.
            self._simulator = None
            self._hosted[number] = simulator._native.hosted(lambda: self._another()._native)
        else:
            self._hosted[number] = simulator._native.hosted(None)

    def ask(self, number: int, *asked: Any) -> tuple[Array, Array] | None:
        return self._hosted[number].ask(*asked)

    def close(self, number: int) -> None:
        self._hosted.pop(number, None)


def _first_line(error: BaseException) -> str:
    return f"{type(error).__name__}: {(str(error).splitlines() or [''])[0]}"
