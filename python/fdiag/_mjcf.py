"""Causes that MJCF can hold, written into the scene."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

import numpy as np

from ._parts import Part, Path
from ._scene import library
from .errors import Error

if TYPE_CHECKING:
    from .result import Cause

__all__ = ["WrittenScene", "write"]

#: Numbers of the scene that agree to so much are those that were asked for: MJCF is a text.
_ROUNDING = 1e-6
#: Fields of a model that have another name in the specification of a scene.
_NAMES = {"qpos_spring": "springref"}
#: What says that a range holds.
_FLAGS = {
    "range": "limited",
    "ctrlrange": "ctrllimited",
    "forcerange": "forcelimited",
    "actfrcrange": "actfrclimited",
}


@dataclass(frozen=True)
class WrittenScene:
    """What became of a result in MJCF."""

    path: File
    """The file."""
    numbers: dict[str, tuple[float, float]]
    """What was changed, `kind/name.field[number]`: the value before and after."""
    written: tuple[str, ...]
    """Causes that the file holds."""
    remaining: tuple[str, ...]
    """Causes that it does not hold: they remain in the shell around the scene, as in `Result.patched()`."""


def write(
    source: Any,
    model: Any,
    values: Mapping[Part, float],
    causes: Iterable[Cause],
    to: str | os.PathLike[str],
) -> WrittenScene:
    """Writes a scene with other values, and with what MJCF can hold of the causes."""
    mujoco = library()
    if not hasattr(mujoco, "MjSpec"):
        raise Error(f"write_mjcf: expected MuJoCo 3.2 or later, found {mujoco.__version__}")
    spec = _spec(mujoco, source)
    numbers: dict[str, tuple[float, float]] = {}
    wanted: list[tuple[Path, float]] = []
    for part, value in values.items():
        for path, after in part.numbers(model, value):
            before = float(path.array(model)[path.index])
            if abs(after - before) > 1e-12 * abs(before):
                wanted.append((path, after))
                _set(spec, path, before, after)
                numbers[path.text + (f"[{path.index}]" if path.index else "")] = (before, after)
    written: list[str] = []
    remaining: list[str] = []
    for cause in causes:
        is_number = cause.law == "native" or cause.label == "parameter-error"
        done = is_number or _hold(spec, cause)
        (written if done else remaining).append(cause.name)
    compiled = spec.compile()
    for path, value in wanted:
        found = float(path.array(compiled)[path.index])
        if abs(found - value) > _ROUNDING * max(abs(value), 1e-9):
            raise Error(f"write_mjcf: `{path.text}`: expected {value} in the new scene, found {found}")
    file = File(to)
    file.write_text(spec.to_xml(), encoding="utf-8")
    return WrittenScene(file, numbers, tuple(written), tuple(remaining))


def _spec(mujoco: Any, source: Any) -> Any:
    if isinstance(source, mujoco.MjModel):
        raise Error("write_mjcf: expected a scene that was given as a file or a text, found an MjModel")
    text = os.fspath(source)
    return mujoco.MjSpec.from_string(text) if "<" in text else mujoco.MjSpec.from_file(text)


def _set(spec: Any, path: Path, before: float, after: float) -> None:
    """Writes one number into the elements of a scene."""
    if path.kind == "option":
        _put(spec.option, path.field, path.index, after)
        return
    element = getattr(spec, path.kind)(path.name)
    if (path.kind, path.field) != ("body", "mass"):
        if path.kind == "joint" and path.unit == "rad" and spec.compiler.degree:
            after = float(np.degrees(after))
        _put(element, _NAMES.get(path.field, path.field), path.index, after)
        if path.field in _FLAGS:
            setattr(element, _FLAGS[path.field], True)
        if path.field == "delay":
            _between_steps(spec, element)
        return
    ratio = after / before
    if element.explicitinertial:
        element.mass = after
        element.inertia = np.asarray(element.inertia) * ratio
        element.fullinertia = np.asarray(element.fullinertia) * ratio
        return
    for geom in element.geoms:
        # A mass that is not stated comes from the density.
        if np.isfinite(geom.mass):
            geom.mass *= ratio
        else:
            geom.density *= ratio


def _between_steps(spec: Any, element: Any) -> None:
    """A delay that is no whole number of time steps needs values between them."""
    steps = float(element.delay) / float(spec.option.timestep)
    if int(element.interp) == 0 and abs(steps - round(steps)) > 1e-9:
        element.interp = 1


def _put(element: Any, field: str, index: int, value: float) -> None:
    if not hasattr(element, field):
        raise Error(f"write_mjcf: MuJoCo's specification of a scene has no `{field}` to write")
    numbers = getattr(element, field)
    if np.ndim(numbers) == 0:
        setattr(element, field, value)
        return
    numbers = np.array(numbers, dtype=np.float64)
    numbers[index] = value
    setattr(element, field, numbers)


def _hold(spec: Any, cause: Cause) -> bool:
    """Puts a cause of the shell into the scene, where MJCF has a word for it."""
    if cause.label not in ("input-delay", "sensor-delay") or len(cause.parameters) != 1:
        return False
    kind = "actuator" if cause.label == "input-delay" else "sensor"
    element = getattr(spec, kind)(cause.place or "")
    if element is None or not hasattr(element, "delay"):
        return False
    # MuJoCo delays by whole time steps; the history has what is on its way, and what is held.
    step = float(spec.option.timestep)
    steps = round(cause.parameters[0].value / step)
    if steps < 1:
        return False
    element.delay, element.nsample = steps * step, steps + 1
    return True
