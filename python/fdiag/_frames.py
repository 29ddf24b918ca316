"""Columns as a data frame of a library that may be there."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from .errors import Error

__all__ = ["frame"]


def frame(columns: Mapping[str, Any], library: str | None) -> Any:
    """A frame of pandas if it is there, else of polars, or of the library that is named."""
    for name in ("pandas", "polars") if library is None else (library,):
        try:
            module = importlib.import_module(name)
        except ImportError:
            continue
        return module.DataFrame(dict(columns))
    raise Error(f"to_frame: expected {library or 'pandas or polars'} to be installed, found neither")
