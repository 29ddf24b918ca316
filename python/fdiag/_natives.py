"""Effects that MuJoCo has in itself: numbers of a scene that most scenes leave as they are."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np

from ._names import nearest
from ._parts import Delay, Limit, Part, Path, Preload, Reserve, Scaled, numbers_of, parameter_path
from ._scene import library
from .errors import InputError

__all__ = ["effects"]

#: Label, field and size of what joints have, per inertia of the joint: with 1 rad/s it makes 10 rad/s^2.
_JOINT = (
    ("viscous-friction", "damping", 10.0),
    ("coulomb-friction", "frictionloss", 10.0),
    ("linear-stiffness", "stiffness", 10.0),
    ("armature", "armature", 0.1),
)
_OF_LIMITS = ("constant-load", "range-reserve", "end-stop", "force-limit", "force-reserve")
_AT_JOINTS = (*(label for label, _, _ in _JOINT), *_OF_LIMITS)
#: Families of labels that are not in the library.
_FAMILIES = {
    "armature": "inertia",
    "body-mass": "inertia",
    "contact-friction": "contact",
    "servo-gain": "actuator-gain",
    "servo-damping": "actuator-gain",
    "gear-ratio": "actuator-gain",
    "force-limit": "actuator-nonlinearity",
    "force-reserve": "actuator-nonlinearity",
    "command-reserve": "actuator-nonlinearity",
    "range-reserve": "limit",
    "sensor-reserve": "sensor-nonlinearity",
    "contact-softness": "contact",
    "contact-damping": "contact",
    "contact-torsion": "contact",
    "contact-rolling": "contact",
    "coupling-ratio": "coupling",
    "coupling-offset": "coupling",
    "coupling-softness": "coupling",
}
#: What is noticed of a number that has a value, and how far it may go, relative to that.
_SHARE, _RANGE = 0.1, (0.01, 100.0)
#: Where fits of a limit begin, as a part of the inverse of that of the scene: a tenth of this to ten times as much.
_NEARER = 1.25

Native = tuple[Part, dict[str, Any]]


def effects(
    model: Any,
    joints: Mapping[str, tuple[int, float]],
    called: Mapping[str, str],
    inputs: Collection[str],
    outputs: Mapping[str, str],
    known: Collection[tuple[str, str, str]],
    wanted: str | Iterable[str] | None,
) -> list[Native]:
    """The effects that are wanted, with what there is to say of each. `joints` are degrees of freedom and positions at
    the start by name, `called` what joints are called in answers, `outputs` sensors by the names of outputs, and `known`
    fields that are parameters already."""
    if wanted is None:
        return []
    found = [
        *_of_joints(model, joints, called),
        *_of_actuators(model, inputs),
        *_of_sensors(model, outputs),
        *_of_bodies(model),
        *_of_geoms(model),
        *_of_tendons(model),
        *_of_equalities(model),
    ]
    # A tendon may have the name of a joint.
    first = {(entry["label"], entry["place"]): i for i, (_, entry) in reversed([*enumerate(found)])}
    found = [
        (part, entry)
        for i, (part, entry) in enumerate(found)
        if first[entry["label"], entry["place"]] == i and not _fields(part) & set(known)
    ]
    if wanted == "all":
        return found
    names = [wanted] if isinstance(wanted, str) else [str(name) for name in wanted]
    of_joints = {f"{label}@{joint}": f"{label}@{name}" for joint, name in called.items() for label in _AT_JOINTS}
    names = [of_joints.get(name, name) for name in names]
    of_entry = [(entry["label"], f"{entry['label']}@{entry['place']}") for _, entry in found]
    for name in names:
        if not any(name in both for both in of_entry):
            listed = sorted({label for both in of_entry for label in both})
            raise InputError(f"native: the scene has no effect `{name}`{nearest(name, listed)}")
    return [native for native, both in zip(found, of_entry) if set(both) & set(names)]


def _fields(part: Part) -> set[tuple[str, str, str]]:
    match part:
        case Scaled(paths):
            return {(path.kind, path.name, path.field) for path in paths}
        case Preload(joint):
            return {("joint", joint, "qpos_spring")}
        case Delay(kind, name):
            return {(kind, name, "delay")}
        case Path() | Limit() | Reserve():
            return {(part.kind, part.name, part.field)}
    return set()


def _entry(label: str, place: str, name: str, **said: Any) -> dict[str, Any]:
    family = _FAMILIES.get(label)
    return {"name": name, "label": label, "place": place, **({"family": family} if family else {}), **said}


def _of_joints(model: Any, joints: Mapping[str, tuple[int, float]], called: Mapping[str, str]) -> Iterable[Native]:
    for joint, (dof, start) in joints.items():
        inertia, place = float(model.dof_M0[dof]), called[joint]
        for label, field, share in _JOINT:
            # The first is the linear part, where this version of MuJoCo has polynomials.
            path = Path("joint", joint, field, 0, parameter_unit(model, joint, field))
            found = _strength(label, place, path, model, share * inertia)
            if found is not None:
                yield found
        is_hinge = int(model.joint(joint).type[0]) == 3
        unit, force = ("rad", "N m") if is_hinge else ("m", "N")
        if float(numbers_of(model, "joint", joint, "stiffness")[0]) > 0.0 and not _bends(model, joint):
            size = _JOINT[1][2] * inertia
            said = {"value": 0.0, "size": size, "bounds": [-_RANGE[1] * size, _RANGE[1] * size], "unit": force}
            yield Preload(joint, unit), _entry("constant-load", place, f"joint/{joint}.preload", **said)
        yield from _reserve("range-reserve", place, Reserve("joint", joint, "range", "limited", unit), model)
        # As far to either side of where runs begin: one of one side is the same where the other is not reached.
        said = {"value": 0.0, "size": 1.0, "bounds": [0.0, _RANGE[1]], "unit": f"1/{unit}", "reciprocal": True}
        stop = Limit("joint", joint, "range", "limited", unit, start)
        yield stop, _entry("end-stop", place, f"joint/{joint}.stop", **said)
        if _is_on(model, "joint", joint, "actfrclimited"):
            limit = ("joint", joint, "actfrcrange", "actfrclimited", force)
            yield from _limit(place, Limit(*limit), model)
            yield from _reserve("force-reserve", place, Reserve(*limit), model)


def _strength(label: str, place: str, path: Path, model: Any, least: float) -> Native | None:
    """A number of what resists, which is noticed from a least change on."""
    value = float(path.array(model)[path.index])
    size = max(least, _SHARE * value)
    if not size > 0.0:
        return None
    # In reality it may be less than the scene says, and what the scene has may be no number that makes sense.
    bounds = [min(0.0, value), _RANGE[1] * max(size, value)]
    return path, _entry(label, place, path.text, value=value, size=size, bounds=bounds, unit=path.unit)


def parameter_unit(model: Any, joint: str, field: str) -> str:
    """The unit of a field of a joint, whatever else this version of MuJoCo keeps in it."""
    size = len(Path("joint", joint, field, 0, "1").array(model))
    text = f"joint/{joint}.{field}" + ("[0]" if size > 1 else "")
    return parameter_path(model, text).unit


def _bends(model: Any, joint: str) -> bool:
    """Whether the stiffness of a joint is a polynomial."""
    holder = model.joint(joint)
    more = [*np.ravel(holder.stiffness)[1:], *np.ravel(getattr(holder, "stiffnesspoly", ()))]
    return any(number != 0.0 for number in more)


def _is_on(model: Any, kind: str, name: str, flag: str) -> bool:
    return bool(numbers_of(model, kind, name, flag)[0])


def _limit(place: str, limit: Limit, model: Any) -> Iterable[Native]:
    """A limit that is nearer than that of the scene."""
    reach = min(-limit.ends(model)[0], limit.ends(model)[1])
    if 0.0 < reach < np.inf:
        size = _NEARER / reach
        unit = f"1/({limit.unit})" if " " in limit.unit else f"1/{limit.unit}"
        said = {"value": 0.0, "size": size, "bounds": [0.0, _RANGE[1] * size], "unit": unit, "reciprocal": True}
        yield limit, _entry("force-limit", place, f"{limit.kind}/{limit.name}.limit", **said)


def _reserve(label: str, place: str, reserve: Reserve, model: Any) -> Iterable[Native]:
    """A range that is wider than the scene has it."""
    low, high = reserve.ends(model)
    if np.isfinite([low, high]).all() and low < high:
        said = {"value": 0.0, "size": _SHARE, "bounds": [0.0, 10.0], "unit": "1"}
        yield reserve, _entry(label, place, f"{reserve.kind}/{reserve.name}.{label}", **said)


def _scaled(label: str, place: str, paths: Iterable[Path], low: float = 0.01, high: float = 10.0) -> Native:
    """Numbers that grow together."""
    part = Scaled(tuple(paths))
    said = {"value": 1.0, "size": _SHARE, "bounds": [low, high], "unit": "1"}
    first = part.paths[0]
    return part, _entry(label, place, f"{first.kind}/{first.name}.{label.removeprefix('input-')}", **said)


def _of_actuators(model: Any, inputs: Iterable[str]) -> Iterable[Native]:
    mujoco = library()
    for name in inputs:
        actuator = model.actuator(name)
        index = int(actuator.id)
        yield from _delayed("actuator", name, name, model)
        control = Reserve("actuator", name, "ctrlrange", "ctrllimited", "1")
        yield from _reserve("command-reserve", name, control, model)
        force = ("actuator", name, "forcerange", "forcelimited", "1")
        yield from _reserve("force-reserve", name, Reserve(*force), model)
        if int(model.actuator_gaintype[index]) != int(mujoco.mjtGain.mjGAIN_FIXED):
            continue
        is_affine = int(model.actuator_biastype[index]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
        of_position, of_velocity = (float(x) for x in model.actuator_biasprm[index][1:3])

        def path(field: str, i: int, name: str = name) -> Path:
            return Path("actuator", name, field, i, "1")

        if is_affine and (of_position or of_velocity):
            # What a servo does depends on the motion: its gear and a limit of its force are none of the command.
            yield from _of_servo(model, name, index)
        if is_affine and of_position:
            yield _scaled("servo-gain", name, (path("gainprm", 0), path("biasprm", 1)))
            if of_velocity:
                yield _scaled("servo-damping", name, (path("biasprm", 2),))
        elif is_affine and of_velocity:
            yield _scaled("servo-gain", name, (path("gainprm", 0), path("biasprm", 2)))
        else:
            yield _scaled("input-gain", name, (path("gainprm", 0),))


def _of_servo(model: Any, name: str, index: int) -> Iterable[Native]:
    """Of one at a hinge or slide joint."""
    joint = int(model.actuator_trnid[index][0])
    is_at_joint = int(model.actuator_trntype[index]) == int(library().mjtTrn.mjTRN_JOINT)
    if not is_at_joint or int(model.jnt_type[joint]) not in (2, 3):
        return
    gear = float(model.actuator_gear[index][0])
    if gear:
        yield _scaled("gear-ratio", name, (Path("actuator", name, "gear", 0, "1"),))
    if bool(model.jnt_actfrclimited[joint]):
        # The joint has one, which is the same where this is the only actuator of it.
        return
    unit = "N m" if int(model.jnt_type[joint]) == 3 else "N"
    yield from _limit(name, Limit("actuator", name, "forcerange", "forcelimited", unit), model)


def _delayed(kind: str, name: str, place: str, model: Any) -> Iterable[Native]:
    """A delay that the scene has may be shorter or longer; what the scene has not is in the shell."""
    if getattr(model, "nhistory", 0) == 0:
        return
    delay, samples = float(numbers_of(model, kind, name, "delay")[0]), int(numbers_of(model, kind, name, "history")[0])
    step = float(model.opt.timestep)
    if samples and delay > 0.0 and samples * step > delay:
        label = "input-delay" if kind == "actuator" else "sensor-delay"
        said = {"value": delay, "size": 0.5 * step, "bounds": [min(step, delay), samples * step], "unit": "s"}
        yield Delay(kind, name), _entry(label, place, f"{kind}/{name}.delay", **said)


def _of_sensors(model: Any, outputs: Mapping[str, str]) -> Iterable[Native]:
    seen = set()
    for output, name in outputs.items():
        if name in seen:
            continue
        seen.add(name)
        yield from _delayed("sensor", name, output, model)
        if float(numbers_of(model, "sensor", name, "cutoff")[0]) > 0.0:
            yield _scaled("sensor-reserve", output, (Path("sensor", name, "cutoff", 0, "1"),), 1.0, 100.0)


def _of_bodies(model: Any) -> Iterable[Native]:
    for i in range(1, model.nbody):
        # What is welded to the world does not move.
        name, mass = model.body(i).name, float(model.body_mass[i])
        if name and mass > 0.0 and int(model.body_weldid[i]) != 0:
            yield _relative("body-mass", name, Path("body", name, "mass", 0, "kg"), mass)


def _of_geoms(model: Any) -> Iterable[Native]:
    for i in range(model.ngeom):
        name = model.geom(i).name
        if not name or not any(_collide(model, i, other) for other in range(model.ngeom)):
            continue
        for label, number, least in (("contact-friction", 0, 1), ("contact-torsion", 1, 4), ("contact-rolling", 2, 6)):
            value = float(model.geom_friction[i][number])
            if value > 0.0 and int(model.geom_condim[i]) >= least:
                yield _relative(label, name, Path("geom", name, "friction", number, "1"), value)
        yield from _soft("contact", name, "geom", model.geom_solref[i], model)


def _soft(what: str, name: str, kind: str, solref: Any, model: Any) -> Iterable[Native]:
    """How soft a constraint is, where it is given by a time constant and a damping ratio."""
    time, damping = (float(x) for x in solref)
    if time > 0.0:
        # MuJoCo takes no less than two time steps.
        low = min(0.99, 2.0 * float(model.opt.timestep) / time)
        yield _scaled(f"{what}-softness", name, (Path(kind, name, "solref", 0, "s"),), low, 100.0)
        if what == "contact" and damping > 0.0:
            yield _scaled("contact-damping", name, (Path(kind, name, "solref", 1, "1"),))


def _of_tendons(model: Any) -> Iterable[Native]:
    for i in range(model.ntendon):
        name = model.tendon(i).name
        inertia = 1.0 / float(model.tendon_invweight0[i]) if float(model.tendon_invweight0[i]) > 0.0 else 0.0
        if not name:
            continue
        for label, field, share in _JOINT:
            if hasattr(model, f"tendon_{field}"):
                found = _strength(label, name, Path("tendon", name, field, 0, "1"), model, share * inertia)
                if found is not None:
                    yield found
        yield from _reserve("range-reserve", name, Reserve("tendon", name, "range", "limited", "1"), model)


def _of_equalities(model: Any) -> Iterable[Native]:
    kinds = library().mjtEq
    coupled = (int(kinds.mjEQ_JOINT), int(kinds.mjEQ_TENDON))
    for i in range(model.neq):
        name = model.equality(i).name
        if not name or not model.eq_active0[i]:
            continue
        if int(model.eq_type[i]) in coupled:
            offset, ratio = (Path("equality", name, "data", k, "1") for k in (0, 1))
            value = float(offset.array(model)[0])
            said = {"value": value, "size": 0.05, "bounds": [value - 5.0, value + 5.0], "unit": "1"}
            yield offset, _entry("coupling-offset", name, f"equality/{name}.offset", **said)
            if float(ratio.array(model)[1]):
                yield _scaled("coupling-ratio", name, (ratio,))
        yield from _soft("coupling", name, "equality", model.eq_solref[i], model)


def _collide(model: Any, i: int, j: int) -> bool:
    """Whether two geoms may touch: not those of one body, nor of one and the next that carries it."""
    asked = [int(model.geom_contype[a]) & int(model.geom_conaffinity[b]) for a, b in ((i, j), (j, i))]
    a, b = (int(model.body_weldid[model.geom_bodyid[geom]]) for geom in (i, j))
    parents = [int(model.body_weldid[model.body_parentid[body]]) for body in (a, b)]
    is_carried = (parents[0] == b and b != 0) or (parents[1] == a and a != 0)
    return any(asked) and a != b and not is_carried


def _relative(label: str, place: str, path: Path, value: float) -> Native:
    bounds = [end * value for end in _RANGE]
    said = {"value": value, "size": _SHARE * value, "bounds": bounds, "unit": path.unit}
    # A field may hold several of them.
    field = label if path.index else path.field
    return path, _entry(label, place, f"{path.kind}/{place}.{field}", **said)
