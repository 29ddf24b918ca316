"""Many diagnoses, each by a name: the logs of a fleet, cases of a bench, a Monte Carlo study.

A job is a name and the arguments of a function. Its seed follows from its name, its answer goes into a file of its own,
and a study that was interrupted goes on where it was. `run` works on this machine; `fdiag.ray.map` does the same on a
cluster, with the same answers.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from .errors import InputError
from .result import Result

__all__ = ["Outcome", "run", "seed_of"]

#: Version of the files.
_VERSION = 1
#: Longest name of a job, so that it can be the name of a file.
_LONGEST = 150


@dataclass(frozen=True)
class Outcome:
    """What became of a job."""

    name: str
    """That of the job."""
    seed: int
    """The seed that follows from its name."""
    result: Any
    """What the function returned, as JSON has it: for a diagnosis the report, as `Result.to_dict()` without its
    `timing`. `None` after an error."""
    error: str | None
    """Kind and text of the exception that the function raised; of a job whose worker was lost, too."""
    seconds: float
    """Time that the function took."""
    is_new: bool
    """Whether it was run now, not read from its file."""

    @property
    def is_ok(self) -> bool:
        """Whether there is a result."""
        return self.error is None


def run(
    function: Callable[..., Any],
    jobs: Mapping[str, Mapping[str, Any]],
    *,
    seed: int = 0,
    folder: str | os.PathLike[str] | None = None,
) -> list[Outcome]:
    """Calls a function once per job, one after the other, and returns the outcomes in the order of the jobs.

    Parameters
    ----------
    function
        Such as `fdiag.gap`. It is called with the arguments of the job, and with `seed` where it takes one that the
        job does not give. It returns a `Result`, or what JSON can hold.
    jobs
        Arguments by the name of the job.
    seed
        Seed of the study; with the name of a job it gives the seed of that job.
    folder
        Where the answers are kept, a file per job. A job whose file is there is not run again; a file of another
        job of that name is refused. An error is kept, too.

    Examples
    --------
    >>> found = run(lambda x, seed: [x, seed % 2**8], {"a": {"x": 1}, "b": {"x": 2}}, seed=7)
    >>> [(o.name, o.result[0], o.seed == seed_of(7, o.name)) for o in found]
    [('a', 1, True), ('b', 2, True)]
    """
    shelf = Shelf(folder, function, seed)
    outcomes = []
    for name, arguments in checked(jobs):
        kept = shelf.kept(name, arguments)
        if kept is None:
            kept = shelf.keep(name, arguments, called(function, arguments, seed_of(seed, name)))
        outcomes.append(kept)
    return outcomes


def seed_of(seed: int, name: str) -> int:
    """The seed of a job: the first 63 bits of the SHA-256 of `seed/name`. It does not depend on other jobs or on where
    the job runs.

    >>> seed_of(7, "cart 3")
    6825443352935164601
    """
    digest = hashlib.sha256(f"{seed}/{name}".encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


def checked(jobs: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The jobs, if their names can be names of files and their arguments have names."""
    for name, arguments in jobs.items():
        if not isinstance(name, str) or not 0 < len(quote(name, safe="")) <= _LONGEST:
            raise InputError(f"jobs: expected names of 1 to {_LONGEST} characters, found `{name}`")
        if not isinstance(arguments, Mapping):
            kind = type(arguments).__name__
            raise InputError(f"jobs: `{name}`: expected a dict of arguments, found a value of type `{kind}`")
    return ((name, dict(arguments)) for name, arguments in jobs.items())


def called(
    function: Callable[..., Any], arguments: Mapping[str, Any], seed: int, threads: int | None = None
) -> dict[str, Any]:
    """Calls the function of a job; an exception is an answer, and the other jobs go on."""
    arguments = dict(arguments)
    takes = _parameters(function)
    for name, value in (("seed", seed), ("threads", threads)):
        if name in takes and value is not None:
            arguments.setdefault(name, value)
    begun = time.perf_counter()
    try:
        result = function(**arguments)
        if isinstance(result, Result):
            # How long it took is no part of the answer, which is the same wherever it is found.
            result = {key: value for key, value in result.to_dict().items() if key != "timing"}
        answer = {"result": result, "error": None}
        # As it will be in the file, whoever asks.
        answer = json.loads(json.dumps(answer))
    except Exception as error:
        answer = {"result": None, "error": f"{type(error).__name__}: {error}"}
    return {**answer, "seconds": time.perf_counter() - begun}


def _parameters(function: Callable[..., Any]) -> set[str]:
    try:
        return set(inspect.signature(function).parameters)
    except (TypeError, ValueError):
        return set()


class Shelf:
    """The folder of a study, if it has one."""

    def __init__(self, folder: str | os.PathLike[str] | None, function: Callable[..., Any], seed: int):
        self._folder = None if folder is None else Path(folder)
        self._function = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', '')}"
        self._seed = int(seed)
        if self._folder is not None:
            self._folder.mkdir(parents=True, exist_ok=True)

    def _path(self, name: str) -> Path:
        assert self._folder is not None
        return self._folder / f"{quote(name, safe='')}.json"

    def kept(self, name: str, arguments: Mapping[str, Any]) -> Outcome | None:
        """The outcome of a job that was run before."""
        if self._folder is None or not self._path(name).exists():
            return None
        path = self._path(name)
        try:
            held = json.loads(path.read_text(encoding="utf-8"))
            about = (held["version"], held["name"], held["seed"], held["job"])
            outcome = Outcome(name, held["seed"], held["result"], held["error"], held["seconds"], False)
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"{path}: expected the outcome of a job, found {error!r}") from error
        if about != (_VERSION, name, seed_of(self._seed, name), self._job(arguments)):
            raise InputError(f"{path}: expected the job `{name}` as it is now, found another one of that name")
        return outcome

    def keep(self, name: str, arguments: Mapping[str, Any], answer: Mapping[str, Any]) -> Outcome:
        """Puts an answer into its file: it is there as a whole, or not at all."""
        seed = seed_of(self._seed, name)
        if self._folder is not None:
            held = {"version": _VERSION, "name": name, "seed": seed, "job": self._job(arguments), **answer}
            handle, draft = tempfile.mkstemp(dir=self._folder, prefix=".", suffix=".part")
            try:
                with os.fdopen(handle, "w", encoding="utf-8") as file:
                    json.dump(held, file)
                    file.flush()
                    os.fsync(file.fileno())
                os.replace(draft, self._path(name))
            except BaseException:
                os.unlink(draft)
                raise
        return Outcome(name, seed, answer["result"], answer["error"], answer["seconds"], True)

    def _job(self, arguments: Mapping[str, Any]) -> str:
        """What tells one job from another: the function and its arguments."""
        digest = hashlib.sha256(self._function.encode())
        _digest(digest, arguments)
        return digest.hexdigest()[:16]


def _digest(into: Any, value: Any) -> None:
    """Numbers, texts, arrays, and lists and dicts of them, by value; other objects by their type, for what they
    are made of has no order that holds from one process to the next."""
    into.update(type(value).__name__.encode() + b"\0")
    if isinstance(value, Mapping):
        for key, entry in value.items():
            _digest(into, key)
            _digest(into, entry)
    elif isinstance(value, (list, tuple)):
        for entry in value:
            _digest(into, entry)
    elif isinstance(value, np.ndarray) and value.dtype != object:
        into.update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, (str, int, float, bool, bytes, type(None), os.PathLike)):
        into.update(repr(os.fspath(value) if isinstance(value, os.PathLike) else value).encode())
