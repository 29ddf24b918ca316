"""Effects of one's own, as text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .errors import InputError

__all__ = ["Effect"]

#: Keys of a parameter, and of a state.
_PARAMETER, _STATE = ("size", "unit", "bounds", "shape", "starts"), ("unit", "derivative")


@dataclass(frozen=True)
class Effect:
    """An effect of your own, tried with those of the library.

    The law is an expression as in [model files](../../docs/model-equations.md). In it `u` is what arrives at an input,
    `v` and `x` are velocity and position where a force acts, `y` is what a sensor measures and `p` a parameter; `t` is
    time, and all names of the model mean what they mean there. What the law says takes the place of `u`, `y` or `p`; a
    force is added.

    >>> swing = Effect("daily-swing", "input", "u*(1 + a*sin(2*pi*t/86400))", {"a": 0.1})
    >>> swing.at
    ()
    """

    label: str
    """Its name: small letters, digits and dashes."""
    side: str
    """`input`, `force`, `output` or `parameter`."""
    law: str
    """The expression. Where all strengths are 0 it must be `u`, `y`, `p`, or for a force 0."""
    parameters: Mapping[str, float | Mapping[str, Any]]
    """Parameters of the law. A number is the size of a strength, a change that is noticed, in its unit. Else a dict:
    `size`, and perhaps `unit`, `bounds` (from 0 to ten sizes if not given), `starts`, and `shape`: the value from which
    a parameter starts that is no strength, such as a width or a period."""
    at: str | Iterable[str] = ()
    """Names of the places; all of the side if none is given."""
    family: str | None = None
    """The mechanism, wider than the label."""
    states: Mapping[str, str | Mapping[str, Any]] = field(default_factory=dict)
    """States of the effect, 0 at the start of a run: their rates, or dicts of `derivative` and `unit`."""


def entries(effects: Iterable[Effect]) -> dict[str, dict[str, Any]]:
    """As the native half takes them."""
    if isinstance(effects, (str, Mapping, Effect)):
        raise InputError(f"effects: expected a list of fdiag.Effect, found a value of type `{type(effects).__name__}`")
    said: dict[str, dict[str, Any]] = {}
    for effect in effects:
        if not isinstance(effect, Effect):
            kind = type(effect).__name__
            raise InputError(f"effects: expected a list of fdiag.Effect, found a value of type `{kind}`")
        if effect.label in said:
            raise InputError(f"effects: `{effect.label}`: expected every label once, found it twice")
        said[effect.label] = {
            "side": str(effect.side),
            "law": str(effect.law),
            "at": [effect.at] if isinstance(effect.at, str) else [str(at) for at in effect.at],
            "parameters": {
                str(name): _part(effect, "parameters", name, known, "size", _PARAMETER)
                for name, known in effect.parameters.items()
            },
            "states": {
                str(name): _part(effect, "states", name, known, "derivative", _STATE)
                for name, known in effect.states.items()
            },
            **({} if effect.family is None else {"family": effect.family}),
        }
    return said


def _part(
    effect: Effect, room: str, name: str, known: Any, single: str, keys: tuple[str, ...]
) -> dict[str, Any]:
    part = dict(known) if isinstance(known, Mapping) else {single: known}
    where = f"effects: `{effect.label}`: {room}.{name}"
    for key, value in part.items():
        if key not in keys:
            raise InputError(f"{where}: expected {', '.join(f'`{k}`' for k in keys)}, found `{key}`")
        is_text = key in ("unit", "derivative")
        if is_text != isinstance(value, str):
            expected = "a text" if is_text else "a number" if key in ("size", "shape") else "numbers"
            raise InputError(f"{where}.{key}: expected {expected}, found {value!r}")
        if not is_text:
            part[key] = float(value) if key in ("size", "shape") else [float(x) for x in value]
    if single not in part:
        raise InputError(f"{where}: expected a `{single}`, found none")
    return part
