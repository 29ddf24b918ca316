"""From a simulator and logs to an answer."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from . import _fdiag, _settings
from ._logs import Log, native
from ._progress import Bar, Progress, shown
from .effects import Effect, entries
from .errors import InputError
from .result import Result
from .simulators import as_simulator

__all__ = ["gap"]


def gap(
    model: Any,
    log: Log | Sequence[Log],
    *,
    held_out: Log | Sequence[Log] | None = None,
    split: float | None = None,
    horizon: str | float = "auto",
    effects: Iterable[Effect] = (),
    exclude: Sequence[str] = (),
    only: Sequence[str] = (),
    tolerance: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    columns: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    sample_time: float | None = None,
    resample: float | None = None,
    longest_hole: float | None = None,
    drop_disorder: bool = False,
    as_read: bool = False,
    starts: str | None = None,
    controller_sees: str | None = None,
    calibrate: int | None = None,
    most: int | None = None,
    budget: str | None = None,
    thorough: bool = False,
    seed: int = 1,
    yes: bool = False,
    threads: int = 0,
    progress: Progress = None,
) -> Result:
    """Says which unmodelled effect separates a simulator from logs of the real system.

    Refits the parameters within their tolerances, tries every known effect at every place of the model, and says
    where the gap lies, which effect causes it and how certain that is, and how far the gap shrinks on data that no
    fit has seen. The same inputs, settings and seed give the same answer as the command line `fdiag gap`.

    Parameters
    ----------
    model
        A model file or its text; a `Simulator`; or an object with `reset` and `step`, and attributes
        `sample_time`, `inputs`, `outputs` (and `parameters`, `initial`, `ports`) as `Steps` takes them.
    log
        A path, a dict of arrays, a data frame (pandas, polars), a dataset (xarray), or a list of these. Columns have
        the names of the channels, or are named in `columns`; a unit may follow a name, `"speed [m/s]"`.
    held_out
        Logs that no fit sees. Without them the end of every log is held out.
    split
        Share of each log that is fitted to, between 0 and 1; .67 if not given.
    horizon
        How long simulations run without seeing the outputs: `"auto"`, `"free"`, or a number of seconds.
    effects
        Effects of your own, each an `Effect`, which are tried with those of the library.
    exclude, only
        Effects that are not tried, or the only ones: labels, mechanisms, or either at a place (`"input-delay@u"`).
    tolerance
        How well parameters are known, relative to their values, instead of what the model says.
    noise
        Standard deviations of the noise of outputs, in their units, instead of what the model says.
    columns
        A column map: a TOML file, or a dict of the same keys.
    sample_time
        Time between the rows of arrays without a column of time, in s.
    resample, longest_hole
        Time between samples to which logs are resampled, and the longest hole that is bridged, in s.
    drop_disorder
        Drop rows that are not later than the row before, instead of refusing the log.
    as_read
        Take the log as it is read, without looking for wrong signs, units, columns and clocks.
    starts
        Where the logs begin: "stated" (where the model says), "free" (anywhere), or "either", whichever explains
        them better (the default).
    controller_sees
        What a controller in the model acts on: "logged" (what was measured, noise included), "simulated" (a loop that
        is closed in the simulator), or "either", whichever leaves less without any effect (the default).
    calibrate
        Also diagnose this many simulated logs of each known cause.
    most
        Most causes that are sought one after another; 1 for no more.
    budget
        What a diagnosis of a simulator of your own may cost: time in it (`"10min"`) or runs (`"300runs"`).
    thorough
        Search such a simulator with thousands of runs, as equations are, instead of with few.
    seed
        Seed of everything random.
    yes
        Begin also what will take hours.
    threads
        Number of threads; 0 takes all cores.
    progress
        `True` for a bar of tqdm, `False` for none, or a function of the stage, what is done, and of how much.

    Raises
    ------
    InputError
        When a model, a log or a setting is missing or wrong.
    AnalysisError
        When the data or the model do not allow what was asked.
    SimulatorError
        When a simulator of yours raises an exception (its `__cause__`), or breaks its contract.

    Examples
    --------
    >>> result = gap(CART, MONDAY, held_out=FRIDAY, only=["coulomb-friction", "viscous-friction"])
    >>> result.verdict, result.causes[0].name
    ('cause', 'coulomb-friction@rail')
    """
    simulator = as_simulator(model)
    if held_out is not None and split is not None:
        raise InputError("split: expected either `held_out` or `split`, found both")
    if split is not None and not 0.0 < split < 1.0:
        raise InputError(f"split: expected a number between 0 and 1, both excluded, found {split}")
    for name, seconds in (("sample_time", sample_time), ("resample", resample), ("longest_hole", longest_hole)):
        if seconds is not None and not 0.0 < seconds < float("inf"):
            raise InputError(f"{name}: expected seconds above 0, found {seconds}")
    for name, count in (("calibrate", calibrate), ("most", most)):
        if count is not None and int(count) < 1:
            raise InputError(f"{name}: expected at least 1, found {count}")
    settings: dict[str, Any] = {
        "split": split,
        "horizon": horizon if isinstance(horizon, str) else repr(float(horizon)),
        "effects": entries(effects),
        "exclude": _names("exclude", exclude),
        "only": _names("only", only),
        "tolerances": _named("tolerance", tolerance),
        "noise": _named("noise", noise),
        "columns": _settings.columns(columns),
        "sample_time": resample,
        "longest_hole": longest_hole,
        "drop_disorder": bool(drop_disorder),
        "as_read": bool(as_read),
        "starts": starts,
        "controller_sees": controller_sees,
        "calibrate": calibrate,
        "most": most,
        "budget": budget,
        "thorough": bool(thorough),
        "seed": int(seed),
        "yes": bool(yes),
    }

    def needed() -> list[str]:
        return _settings.needed(simulator, settings["columns"])

    fitted = native(log, "log", sample_time, needed)
    later = native(held_out, "held-out", sample_time, needed)
    call = shown(progress)
    # Threads that wait for actors take no processor.
    waiting = getattr(simulator, "least_threads", 0)
    count = int(threads) or (max(waiting, os.cpu_count() or 1) if waiting else 0)
    try:
        study = _fdiag.study(simulator._native, fitted, later, json.dumps(settings), count, call)
    finally:
        if isinstance(call, Bar):
            call.close()
    return Result(study, tuple((channel.name, channel.unit) for channel in simulator.inputs), simulator)


def _names(option: str, names: Sequence[str]) -> list[str]:
    if isinstance(names, str):
        raise InputError(f"{option}: expected a list of names, found the text `{names}`")
    return [str(name) for name in names]


def _named(option: str, values: Mapping[str, float] | None) -> list[tuple[str, float]]:
    for name, value in (values or {}).items():
        if not 0.0 <= float(value) < float("inf"):
            raise InputError(f"{option}: `{name}`: expected a number from 0 on, found {value}")
    return [(str(name), float(value)) for name, value in (values or {}).items()]

