"""Diagnoses on a cluster, by Ray (`pip install ray`): many of them by `map`, or one whose simulator is `Spread`. Not
needed for what one machine does in an hour: `fdiag.jobs.run` and `fdiag.gap` give the same answers without it.

>>> import fdiag.ray  # doctest: +SKIP
>>> cars = {car: {"model": "car.toml", "log": f"{car}.csv"} for car in ("red", "blue")}  # doctest: +SKIP
>>> found = fdiag.ray.map(fdiag.gap, cars, folder="out")  # doctest: +SKIP
>>> slow = fdiag.ray.Spread(lambda: fdiag.MuJoCo("arm.xml", ports="all"), actors=8)  # doctest: +SKIP
>>> result = fdiag.gap(slow, "monday.csv")  # doctest: +SKIP
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

from ._spread import Spread, started
from .errors import InputError
from .jobs import Outcome, Shelf, called, checked, seed_of

__all__ = ["Spread", "map"]


def map(
    function: Callable[..., Any],
    jobs: Mapping[str, Mapping[str, Any]],
    *,
    seed: int = 0,
    folder: str | os.PathLike[str] | None = None,
    cpus: float = 1.0,
    retries: int = 3,
) -> list[Outcome]:
    """Calls a function once per job, as tasks of Ray, and returns the outcomes in the order of the jobs. They are those
    of `fdiag.jobs.run`, to the bit.

    A task whose worker or node is lost is run again, up to `retries` times; then its outcome says so, and it has no
    file. Nothing else is lost with it. Files are written where this is called, when an answer arrives: workers need no
    common disk. Logs that are given as paths must be there for every worker.

    Ray is started on this machine if nobody has started it (`ray.init`) or named a cluster (`RAY_ADDRESS`).

    Parameters
    ----------
    function, jobs, seed, folder
        As for `fdiag.jobs.run`. A function with an argument `threads` gets as many as it has processors, if the job
        does not say how many.
    cpus
        Processors of a task.
    retries
        How often a task is run again whose worker was lost.
    """
    if not 0.0 < cpus < float("inf"):
        raise InputError(f"cpus: expected a number above 0, found {cpus}")
    if retries < 0:
        raise InputError(f"retries: expected 0 or more, found {retries}")
    shelf = Shelf(folder, function, seed)
    outcomes: dict[str, Outcome] = {}
    waiting = []
    for name, arguments in checked(jobs):
        kept = shelf.kept(name, arguments)
        if kept is None:
            waiting.append((name, arguments))
        else:
            outcomes[name] = kept
    if not waiting:
        return [outcomes[name] for name in jobs]
    ray = started()
    # An exception of the function is an answer; what is tried again is a worker that died.
    task = ray.remote(num_cpus=cpus, max_retries=retries)(_task)
    running: dict[Any, tuple[str, dict[str, Any]]] = {}
    shared = ray.put(function)
    waiting.reverse()
    try:
        while waiting or running:
            # A few more than there is room for, so that no processor waits, and not all that there are.
            ahead = 2 * int(ray.cluster_resources().get("CPU", 1.0) / cpus) + 2
            while waiting and len(running) < ahead:
                name, arguments = waiting.pop()
                at = task.remote(shared, arguments, seed_of(seed, name), max(1, int(cpus)))
                running[at] = (name, arguments)
            done, _ = ray.wait(list(running), num_returns=1)
            for at in done:
                name, arguments = running.pop(at)
                try:
                    outcomes[name] = shelf.keep(name, arguments, ray.get(at))
                except ray.exceptions.RayError as error:
                    said = f"{type(error).__name__}: {str(error).splitlines()[0]}"
                    outcomes[name] = Outcome(name, seed_of(seed, name), None, said, 0.0, True)
    finally:
        for at in running:
            ray.cancel(at)
    return [outcomes[name] for name in jobs]


def _task(function: Callable[..., Any], arguments: dict[str, Any], seed: int, threads: int) -> dict[str, Any]:
    """What a worker does."""
    return called(function, arguments, seed, threads)
