"""Numbers of a MuJoCo model that are parameters, alone or several that move together."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ._names import nearest
from .errors import InputError

Array = npt.NDArray[np.float64]

#: Units of fields, of slide and hinge joints where they differ.
_FIELD_UNITS: dict[str, str | tuple[str, str]] = {
    "mass": "kg",
    "inertia": "kg m^2",
    "pos": "m",
    "ipos": "m",
    "timestep": "s",
    "gravity": "m/s^2",
    "damping": ("N s/m", "N m s/rad"),
    "armature": ("kg", "kg m^2"),
    "frictionloss": ("N", "N m"),
    "stiffness": ("N/m", "N m/rad"),
    "range": ("m", "rad"),
    "qpos_spring": ("m", "rad"),
}
_KINDS = ("joint", "body", "geom", "actuator", "sensor", "tendon", "site", "equality", "option")
#: How fields of an element begin in the arrays of a model.
_PREFIXES = {"joint": "jnt", "equality": "eq"}


class Part(Protocol):
    """What a parameter is in a model."""

    def set(self, model: Any, value: float, pristine: Any) -> None:
        """Writes a value into a model; `pristine` is the model as it came."""

    def numbers(self, pristine: Any, value: float) -> list[tuple[Path, float]]:
        """The numbers that it then has, by their paths."""


def _fields(model: Any, kind: str, holder: Any) -> list[str]:
    """What there is to know of an element of a kind."""
    known = [f for f in dir(holder) if not f.startswith("_") and f not in ("id", "name")]
    if kind == "option":
        return known
    # MuJoCo shows some fields of an element only in the array of all of them.
    prefix = f"{_PREFIXES.get(kind, kind)}_"
    return sorted({*known, *(f.removeprefix(prefix) for f in dir(model) if f.startswith(prefix))})


def numbers_of(model: Any, kind: str, name: str, field: str) -> Array:
    """A field, in the memory of the model."""
    holder = model.opt if kind == "option" else getattr(model, kind)(name)
    if hasattr(holder, field):
        numbers: Array = np.atleast_1d(getattr(holder, field)).reshape(-1)
        return numbers
    i, every = int(holder.id), getattr(model, f"{_PREFIXES.get(kind, kind)}_{field}")
    # Not `every[i]`, which would be a copy where it is one number.
    numbers = every[i : i + 1].reshape(-1)
    return numbers

@dataclass(frozen=True)
class Path:
    """A number of a model."""

    kind: str
    name: str
    field: str
    index: int
    unit: str

    @property
    def text(self) -> str:
        """As it is written."""
        return f"{self.kind}/{self.name}.{self.field}" if self.name else f"{self.kind}/{self.field}"

    def array(self, model: Any) -> Array:
        """The numbers among which it is, in the memory of the model."""
        return numbers_of(model, self.kind, self.name, self.field)

    def numbers(self, pristine: Any, value: float) -> list[tuple[Path, float]]:
        """What it writes."""
        return [(self, value)]

    def set(self, model: Any, value: float, pristine: Any) -> None:
        """Writes it. The inertia of a body goes with its mass; `pristine` is the model as it came."""
        if self.kind == "option" and np.ndim(getattr(model.opt, self.field)) == 0:
            setattr(model.opt, self.field, value)
            return
        if (self.kind, self.field) == ("body", "mass"):
            ratio = value / float(pristine.body(self.name).mass[0])
            model.body(self.name).inertia[:] = pristine.body(self.name).inertia * ratio
        self.array(model)[self.index] = value


def parameter_path(model: Any, text: str) -> Path:
    """A path such as `joint/q1.damping` or `actuator/u1.gear[0]`."""
    found = re.fullmatch(r"(\w+)/(?:(.*)\.)?(\w+)(?:\[(\d+)\])?", text)
    where = f"uncertain: `{text}`"
    if not found:
        raise InputError(f"{where}: expected a path such as `joint/q1.damping` or `actuator/u1.gear[0]`")
    kind, name, field, number = found[1], found[2] or "", found[3], found[4]
    if kind not in _KINDS:
        raise InputError(f"{where}: there is no kind `{kind}`{nearest(kind, _KINDS)}")
    if kind == "option":
        holder = model.opt
    else:
        count = {"joint": "njnt", "actuator": "nu", "equality": "neq"}.get(kind, f"n{kind}")
        names = [getattr(model, kind)(i).name for i in range(getattr(model, count))]
        if not name or name not in names:
            raise InputError(f"{where}: the scene has no {kind} `{name}`{nearest(name, names)}")
        holder = getattr(model, kind)(name)
    known = _fields(model, kind, holder)
    if field not in known:
        raise InputError(f"{where}: a {kind} has no field `{field}`{nearest(field, known)}")
    numbers = numbers_of(model, kind, name, field)
    if numbers.dtype.kind != "f":
        raise InputError(f"{where}: expected a field of numbers, found one of `{numbers.dtype}`")
    if number is None and numbers.size != 1:
        size = numbers.size
        raise InputError(f"{where}: has {size} numbers: expected one of them, such as `{text}[0]`")
    if number is not None and not int(number) < numbers.size:
        raise InputError(f"{where}: has {numbers.size} numbers, counted from 0")
    unit = _FIELD_UNITS.get(field, "1")
    if isinstance(unit, tuple):
        is_hinge = kind == "joint" and int(holder.type[0]) == 3
        unit = (unit[1] if is_hinge else unit[0]) if kind == "joint" else "1"
    return Path(kind, name, field, int(number or 0), unit)


@dataclass(frozen=True)
class Scaled:
    """Numbers of a model that grow together, by a factor."""

    paths: tuple[Path, ...]

    def set(self, model: Any, value: float, pristine: Any) -> None:
        """Multiplies them, as they are in the model as it came."""
        for path, number in self.numbers(pristine, value):
            path.array(model)[path.index] = number

    def numbers(self, pristine: Any, value: float) -> list[tuple[Path, float]]:
        """Each times the factor."""
        return [(path, value * float(path.array(pristine)[path.index])) for path in self.paths]


@dataclass(frozen=True)
class Preload:
    """A torque of a spring at rest, which moves its reference."""

    joint: str
    unit: str
    """Of the position."""

    def set(self, model: Any, value: float, pristine: Any) -> None:
        """Moves the reference, with the stiffness as it came."""
        for path, number in self.numbers(pristine, value):
            path.array(model)[path.index] = number

    def numbers(self, pristine: Any, value: float) -> list[tuple[Path, float]]:
        """The reference."""
        path = Path("joint", self.joint, "qpos_spring", 0, self.unit)
        stiffness = float(numbers_of(pristine, "joint", self.joint, "stiffness")[0])
        return [(path, float(path.array(pristine)[0]) + value / stiffness)]


@dataclass(frozen=True)
class Delay:
    """A delay that the scene has, in s: of an actuator or a sensor, as long as its history."""

    kind: str
    name: str

    def set(self, model: Any, value: float, pristine: Any) -> None:
        """Between whole time steps the history is interpolated."""
        numbers_of(model, self.kind, self.name, "delay")[0] = value
        history = numbers_of(model, self.kind, self.name, "history")
        history[1] = numbers_of(pristine, self.kind, self.name, "history")[1]
        steps = value / float(pristine.opt.timestep)
        if history[1] == 0 and abs(steps - round(steps)) > 1e-9:
            history[1] = 1

    def numbers(self, pristine: Any, value: float) -> list[tuple[Path, float]]:
        """The delay."""
        return [(Path(self.kind, self.name, "delay", 0, "s"), value)]


@dataclass(frozen=True)
class Ranged:
    """A range of an element, and the field that says whether it holds."""

    kind: str
    name: str
    field: str
    flag: str
    unit: str
    """Of its ends."""

    def clear(self, model: Any, pristine: Any) -> None:
        """The range as it came."""
        for field in (self.field, self.flag):
            numbers_of(model, self.kind, self.name, field)[:] = numbers_of(pristine, self.kind, self.name, field)

    def ends(self, model: Any) -> tuple[float, float]:
        """Where it ends."""
        if not numbers_of(model, self.kind, self.name, self.flag)[0]:
            return -np.inf, np.inf
        low, high = numbers_of(model, self.kind, self.name, self.field)
        return float(low), float(high)

    def moved(self, ends: tuple[float, float], value: float) -> tuple[float, float]:
        """Where it ends with a value of the parameter; nowhere else for 0."""
        raise NotImplementedError

    def set(self, model: Any, value: float, pristine: Any) -> None:
        """Moves the ends of a range that is as it came, or as another part has left it."""
        if value != 0.0:
            numbers_of(model, self.kind, self.name, self.field)[:] = self.moved(self.ends(model), value)
            numbers_of(model, self.kind, self.name, self.flag)[0] = True

    def numbers(self, pristine: Any, value: float) -> list[tuple[Path, float]]:
        """Both ends."""
        if value == 0.0:
            return []
        ends = enumerate(self.moved(self.ends(pristine), value))
        return [(Path(self.kind, self.name, self.field, i, self.unit), end) for i, end in ends]


@dataclass(frozen=True)
class Limit(Ranged):
    """A limit at both sides of a middle that is nearer than the range says; the value is its inverse."""

    middle: float = 0.0

    def moved(self, ends: tuple[float, float], value: float) -> tuple[float, float]:
        """The nearer ends."""
        return max(ends[0], self.middle - 1.0 / value), min(ends[1], self.middle + 1.0 / value)


@dataclass(frozen=True)
class Reserve(Ranged):
    """A range that is wider, by a part of itself."""

    def moved(self, ends: tuple[float, float], value: float) -> tuple[float, float]:
        """Half of it at each end."""
        more = 0.5 * value * (ends[1] - ends[0])
        return ends[0] - more, ends[1] + more
