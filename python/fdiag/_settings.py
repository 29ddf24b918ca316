"""Settings that several questions have in common."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

from . import _fdiag
from .simulators import Simulator

__all__ = ["columns", "needed"]


def columns(said: str | os.PathLike[str] | Mapping[str, Any] | None) -> dict[str, Any] | None:
    """A column map as a dict."""
    if said is None:
        return None
    if isinstance(said, Mapping):
        return dict(said)
    read: dict[str, Any] = json.loads(_fdiag.column_map(os.fspath(said)))
    return read


def needed(simulator: Simulator, mapped: Mapping[str, Any] | None) -> list[str]:
    """Columns that a simulator asks a log for."""
    named = mapped or {}
    # What an expression is made of stands under `columns`, or is found when it is read.
    said = [c for room in ("inputs", "outputs", "columns") for c in named.get(room, ())]
    of_map = [c.get("column", c["name"]) for c in said if not {"expression", "constant"} & set(c)]
    return [channel.name for channel in simulator.inputs + simulator.outputs] + of_map
