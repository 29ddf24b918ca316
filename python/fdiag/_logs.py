"""Logs as Python people have them: paths, dicts of arrays, data frames, datasets."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import InputError

#: What a log can be: a path, a mapping from names to one-dimensional arrays, or a data frame.
Log = Any
#: As the native half takes it.
Native = str | tuple[str, list[tuple[str, npt.NDArray[np.float64]]]]

_TIMES = ("time", "time_s", "timestamp")
#: Most columns that lists may become.
_MOST_COLUMNS = 4096


def native(
    logs: Log,
    what: str,
    sample_time: float | None = None,
    needed: Callable[[], Iterable[str]] = tuple,
) -> list[Native]:
    """One log or a list of logs for the native half; `what` is what they are called in messages."""
    if logs is None:
        return []
    several = list(logs) if isinstance(logs, (list, tuple)) else [logs]
    if not several:
        raise InputError(f"{what}: expected at least one log, found an empty list")
    names = [what if i == 0 else f"{what} {i + 1}" for i in range(len(several))]
    return [_one(log, name, sample_time, needed) for log, name in zip(several, names)]


def _one(
    log: Log, name: str, sample_time: float | None, needed: Callable[[], Iterable[str]]
) -> Native:
    if isinstance(log, (str, os.PathLike)):
        return os.fspath(log)
    columns: list[tuple[str, npt.NDArray[np.float64]]] = []
    unfit: dict[str, str] = {}
    for header, values in _columns(log, name):
        try:
            parts = _parts(header, values)
            columns.extend(parts)
            if parts[:1] and parts[0][0] != header:
                shape = [len(parts[0][1]), len(parts)]
                unfit[header.split(" [")[0]] = f"expected one number per row, found an array of shape {shape}"
        except (TypeError, ValueError) as why:
            unfit[header.split(" [")[0]] = str(why)
    if unfit:
        # Columns that nobody asks for may hold anything.
        for wanted in needed():
            if wanted in unfit:
                raise InputError(f"{name}: column `{wanted}`: {unfit[wanted]}")
    if sample_time is not None and not any(_is_time(header) for header, _ in columns):
        rows = len(columns[0][1]) if columns else 0
        columns.insert(0, ("time [s]", np.arange(rows, dtype=np.float64) * np.float64(sample_time)))
    return name, columns


def _is_time(header: str) -> bool:
    name = header.split("[")[0].strip()
    # A capital T is a temperature.
    return name == "t" or name.lower() in _TIMES


def _columns(log: Log, name: str) -> Iterator[tuple[str, Any]]:
    """Headers and values; a unit of the source stands behind the name."""
    if isinstance(log, Mapping) and not hasattr(log, "data_vars"):
        for key in log:
            yield str(key), log[key]
    elif hasattr(log, "data_vars"):  # an xarray dataset
        for group in (log.coords, log.data_vars):
            for key in group:
                unit = group[key].attrs.get("units")
                yield (f"{key} [{unit}]" if unit else str(key)), group[key].values
    elif hasattr(log, "columns"):  # a data frame
        index = getattr(log, "index", None)
        title = getattr(index, "name", None)
        if title is not None and str(title) not in map(str, log.columns):
            yield str(title), index
        for key in log.columns:
            yield str(key), log[key]
    elif isinstance(log, np.ndarray) and log.dtype.names:
        for key in log.dtype.names:
            yield key, log[key]
    else:
        raise InputError(
            f"{name}: expected a path, a dict of arrays, a data frame, a dataset or a structured array, "
            f"found a value of type `{type(log).__name__}`"
        )


def _parts(header: str, values: Any) -> list[tuple[str, npt.NDArray[np.float64]]]:
    """The column, or one for each entry where its cells are lists of one length: `q[0]`, `q[1]`."""
    array = np.asarray(values)
    if array.ndim == 1 and array.dtype.kind == "O" and len(array):
        first = next((cell for cell in array if cell is not None), None)
        if isinstance(first, (list, tuple, np.ndarray)):
            length = len(first)
            empty = np.full(length, np.nan)
            cells = [empty if cell is None else np.asarray(cell, dtype=np.float64) for cell in array]
            odd = next((k for k, cell in enumerate(cells) if cell.shape != (length,)), None)
            if odd is not None:
                raise ValueError(
                    f"expected lists of {length} numbers, as in the first row, found {list(cells[odd].shape)} in row {odd}"
                )
            array = np.stack(cells)
    if array.ndim != 2:
        return [(header, _numbers(array))]
    if array.shape[1] > _MOST_COLUMNS:
        raise ValueError(f"expected lists of at most {_MOST_COLUMNS} numbers, found {array.shape[1]}")
    name, bracket, unit = header.partition(" [")
    columns = (array[:, i] for i in range(array.shape[1]))
    return [(f"{name}[{i}]{bracket}{unit}", _numbers(column)) for i, column in enumerate(columns)]


def _numbers(values: Any) -> npt.NDArray[np.float64]:
    """One-dimensional numbers, NaN where there is no value; times become seconds from the first."""
    array = np.asarray(values)
    if array.ndim != 1:
        raise ValueError(f"expected one number per row, found an array of shape {list(array.shape)}")
    if array.dtype.kind in "mM":
        since = array - array[0] if array.dtype.kind == "M" and len(array) else array
        seconds = since / np.timedelta64(1, "s")
        return np.ascontiguousarray(seconds, dtype=np.float64)
    if array.dtype.kind not in "biuf":
        if array.dtype.kind != "O":
            raise ValueError(f"expected numbers, found values of type `{array.dtype}`")
        array = np.array([np.nan if value is None else value for value in array.tolist()])
        if array.dtype.kind not in "biuf":
            raise ValueError("expected numbers, found something else")
    return np.ascontiguousarray(array, dtype=np.float64)
