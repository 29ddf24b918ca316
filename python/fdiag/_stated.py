"""What is said of a simulator: channels, parameters, states and ports."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from .errors import InputError

__all__ = ["Initial", "Native", "Output", "Port", "Uncertain", "entries", "toml"]


@dataclass(frozen=True)
class Uncertain:
    """A parameter that is known to within a tolerance.

    >>> Uncertain(1.2, 0.05, "kg")
    Uncertain(value=1.2, tolerance=0.05, unit='kg', bounds=None)
    """

    value: float
    """Nominal value, in the unit."""
    tolerance: float | None = None
    """How well it is known, relative to the value; 0 for exactly, `None` for 5 %."""
    unit: str = "1"
    """Its unit."""
    bounds: tuple[float, float] | None = None
    """Values that make sense."""


@dataclass(frozen=True)
class Initial:
    """A state of which the initial value can be set."""

    value: float = 0.0
    """Nominal initial value, in the unit."""
    tolerance: float | None = None
    """How well it is known, in the unit; `None` for exactly."""
    unit: str = "1"
    """Its unit."""


@dataclass(frozen=True)
class Output:
    """An output with its noise."""

    unit: str = "1"
    """Its unit."""
    noise: float | None = None
    """Standard deviation of the noise of its sensor, in the unit; `None` where it is not known."""
    wraps: bool | None = None
    """Whether it is an angle (`rad`, `deg`, `rev`) that begins anew after a turn: whole turns are then no gap."""


@dataclass(frozen=True)
class Port:
    """A place at which forces may be added."""

    unit: str = "1"
    """Unit of the force."""
    position: str | None = None
    """The output that is the position of what the force moves."""
    velocity: str | None = None
    """The output that is its velocity."""


@dataclass(frozen=True)
class Native:
    """An effect that a simulator has in itself and that rests: `reset` gets its parameter with those of the others.

    >>> Native("coulomb-friction", "elbow", size=0.1, unit="N m", bounds=(0, 10)).place
    'elbow'
    """

    label: str
    """Name of the effect; one of the library, such as `coulomb-friction`, means the same cause there."""
    place: str
    """Where it is: the name of a port, an input or an output, or of any other part."""
    value: float | None = None
    """Value of its parameter at which it rests; `None` for 0, and of an FMU for its start value."""
    size: float | None = None
    """A change of the value that is noticed, in the unit; the value if not given."""
    unit: str = "1"
    """Unit of its parameter."""
    bounds: tuple[float, float] | None = None
    """Values that make sense."""
    family: str | None = None
    """The mechanism, wider than the label."""
    reciprocal: bool | None = None
    """Whether `1/value` is what a person would call it: a limit that is infinite at 0."""


Entries = Mapping[str, Any] | Iterable[str] | None


def entries(room: str, said: Entries) -> list[dict[str, Any]]:
    """The entries of a room, in the words of the process protocol."""
    if said is None:
        return []
    if isinstance(said, str):
        raise InputError(f"{room}: expected a list of names or a dict, found the text `{said}`")
    if not isinstance(said, Mapping):
        return [{"name": str(name), **_entry(room, str(name), None)} for name in said]
    return [{"name": str(name), **_entry(room, str(name), value)} for name, value in said.items()]


def _entry(room: str, name: str, value: Any) -> dict[str, Any]:
    of_value = {"parameters": "value", "states": "initial"}.get(room)
    entry: dict[str, Any]
    if value is None:
        entry = {}
    elif isinstance(value, str):
        entry = {"unit": value}
    elif isinstance(value, Mapping):
        entry = dict(value)
    elif isinstance(value, (Uncertain, Initial, Output, Port, Native)):
        entry = {key: part for key, part in vars(value).items() if part is not None}
        if isinstance(value, Initial):
            entry["initial"] = entry.pop("value")
    elif of_value and isinstance(value, (int, float)) and not isinstance(value, bool):
        entry = {of_value: float(value)}
    else:
        raise InputError(
            f"{room}: `{name}`: expected a unit, a number or an entry, found a value of type "
            f"`{type(value).__name__}`"
        )
    for key in ("value", "initial", "tolerance", "noise", "size"):
        if key in entry:
            entry[key] = float(entry[key])
    if "bounds" in entry:
        entry["bounds"] = [float(bound) for bound in entry["bounds"]]
    return entry


def with_units(all_entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Entries with a unit each: a pure number where none is said."""
    return [{"unit": "1", **entry} for entry in all_entries]


def toml(head: Mapping[str, Any], rooms: Mapping[str, list[dict[str, Any]]]) -> str:
    """The text of a model file.

    >>> print(toml({"kind": "process"}, {"outputs": [{"name": "y", "noise": 0.1}]}))
    kind = "process"
    <BLANKLINE>
    [outputs]
    "y" = { noise = 0.1 }
    <BLANKLINE>
    """
    lines = [f"{key} = {_value(value)}" for key, value in head.items() if value is not None]
    for room, said in rooms.items():
        if said:
            lines += ["", f"[{room}]"]
        for entry in said:
            parts = [f"{key} = {_value(part)}" for key, part in entry.items() if key != "name"]
            lines.append(f"{_value(entry['name'])} = {{ {', '.join(parts)} }}")
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(part) for part in value)}]"
    # A text of JSON is one of TOML.
    return json.dumps(value, ensure_ascii=False)
