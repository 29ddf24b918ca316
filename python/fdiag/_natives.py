"""Effects that MuJoCo has in itself: numbers of a scene that most scenes leave as they are."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from ._names import nearest
from ._scene import Path, Scaled, library, parameter_path
from .errors import InputError

__all__ = ["effects"]

#: Label, field and size of what joints have, per inertia of the joint: with 1 rad/s it makes 10 rad/s^2.
_JOINT = (
    ("viscous-friction", "damping", 10.0),
    ("coulomb-friction", "frictionloss", 10.0),
    ("linear-stiffness", "stiffness", 10.0),
    ("armature", "armature", 0.1),
)
#: Families of labels that are not in the library.
_FAMILIES = {
    "armature": "inertia",
    "body-mass": "inertia",
    "contact-friction": "contact",
    "servo-gain": "actuator-gain",
    "servo-damping": "actuator-gain",
}
#: What is noticed of a number that has a value, and how far it may go, relative to that.
_SHARE, _RANGE = 0.1, (0.01, 100.0)

Part = Path | Scaled
Native = tuple[Part, dict[str, Any]]


def effects(
    model: Any,
    joints: Mapping[str, int],
    called: Mapping[str, str],
    inputs: Iterable[str],
    known: Collection[tuple[str, str, str]],
    wanted: str | Iterable[str] | None,
) -> list[Native]:
    """The effects that are wanted, with what there is to say of each. `joints` are degrees of freedom by name,
    `called` what joints are called in answers, and `known` fields that are parameters already."""
    if wanted is None:
        return []
    found = [*_of_joints(model, joints, called), *_of_actuators(model, inputs), *_of_bodies(model), *_of_geoms(model)]
    found = [(part, entry) for part, entry in found if not _fields(part) & set(known)]
    if wanted == "all":
        return found
    names = [wanted] if isinstance(wanted, str) else [str(name) for name in wanted]
    of_joints = {f"{label}@{joint}": f"{label}@{name}" for joint, name in called.items() for label, _, _ in _JOINT}
    names = [of_joints.get(name, name) for name in names]
    of_entry = [(entry["label"], f"{entry['label']}@{entry['place']}") for _, entry in found]
    for name in names:
        if not any(name in both for both in of_entry):
            listed = sorted({label for both in of_entry for label in both})
            raise InputError(f"native: the scene has no effect `{name}`{nearest(name, listed)}")
    return [native for native, both in zip(found, of_entry) if set(both) & set(names)]


def _fields(part: Part) -> set[tuple[str, str, str]]:
    paths = part.paths if isinstance(part, Scaled) else (part,)
    return {(path.kind, path.name, path.field) for path in paths}


def _entry(label: str, place: str, name: str, **said: Any) -> dict[str, Any]:
    family = _FAMILIES.get(label)
    return {"name": name, "label": label, "place": place, **({"family": family} if family else {}), **said}


def _of_joints(model: Any, joints: Mapping[str, int], called: Mapping[str, str]) -> Iterable[Native]:
    for joint, dof in joints.items():
        inertia = float(model.dof_M0[dof])
        for label, field, share in _JOINT:
            # The first is the linear part, where this version of MuJoCo has polynomials.
            path = Path("joint", joint, field, 0, parameter_unit(model, joint, field))
            value = float(path.array(model)[0])
            size = max(share * inertia, _SHARE * value)
            if size > 0.0:
                said = {"value": value, "size": size, "bounds": [0.0, _RANGE[1] * max(size, value)]}
                yield path, _entry(label, called[joint], f"joint/{joint}.{field}", unit=path.unit, **said)


def parameter_unit(model: Any, joint: str, field: str) -> str:
    """The unit of a field of a joint, whatever else this version of MuJoCo keeps in it."""
    size = len(Path("joint", joint, field, 0, "1").array(model))
    text = f"joint/{joint}.{field}" + ("[0]" if size > 1 else "")
    return parameter_path(model, text).unit


def _of_actuators(model: Any, inputs: Iterable[str]) -> Iterable[Native]:
    mujoco = library()
    for name in inputs:
        actuator = model.actuator(name)
        index = int(actuator.id)
        if int(model.actuator_gaintype[index]) != int(mujoco.mjtGain.mjGAIN_FIXED):
            continue
        is_affine = int(model.actuator_biastype[index]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
        of_position, of_velocity = (float(x) for x in model.actuator_biasprm[index][1:3])

        def path(field: str, i: int, name: str = name) -> Path:
            return Path("actuator", name, field, i, "1")

        def scaled(label: str, *paths: Path, name: str = name) -> Native:
            said = {"value": 1.0, "size": _SHARE, "bounds": [0.01, 10.0], "unit": "1"}
            part = Scaled(paths)
            return part, _entry(label, name, f"actuator/{name}.{label.removeprefix('input-')}", **said)

        if is_affine and of_position:
            yield scaled("servo-gain", path("gainprm", 0), path("biasprm", 1))
            if of_velocity:
                yield scaled("servo-damping", path("biasprm", 2))
        elif is_affine and of_velocity:
            yield scaled("servo-gain", path("gainprm", 0), path("biasprm", 2))
        else:
            yield scaled("input-gain", path("gainprm", 0))


def _of_bodies(model: Any) -> Iterable[Native]:
    for i in range(1, model.nbody):
        # What is welded to the world does not move.
        name, mass = model.body(i).name, float(model.body_mass[i])
        if name and mass > 0.0 and int(model.body_weldid[i]) != 0:
            yield _relative("body-mass", name, Path("body", name, "mass", 0, "kg"), mass)


def _of_geoms(model: Any) -> Iterable[Native]:
    for i in range(model.ngeom):
        name, friction = model.geom(i).name, float(model.geom_friction[i][0])
        if name and friction > 0.0 and any(_collide(model, i, other) for other in range(model.ngeom)):
            yield _relative("contact-friction", name, Path("geom", name, "friction", 0, "1"), friction)


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
    return path, _entry(label, place, f"{path.kind}/{place}.{path.field}", **said)
