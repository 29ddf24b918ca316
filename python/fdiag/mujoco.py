"""MuJoCo scenes as simulators. Needs the package `mujoco` (3 or later)."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _stated
from ._names import nearest
from ._mjcf import WrittenScene, write
from ._natives import effects as _effects
from ._parts import Path as _Path
from ._parts import parameter_path
from ._scene import Place as _Place
from ._scene import Scene, as_model, input_unit, output_place
from .errors import InputError
from .simulators import Opener, Simulator, lent

if TYPE_CHECKING:
    from .result import Cause

__all__ = ["MuJoCo"]

#: Fields that cannot be negative.
_POSITIVE = ("mass", "inertia", "armature", "damping", "frictionloss", "stiffness")
#: How well positions and velocities at the start are known if nobody says it, in rad or m, and per s.
_KNOWN = (0.01, 0.05)


class MuJoCo(Simulator):
    """A MuJoCo scene.

    Parameters
    ----------
    scene
        A file of MJCF or URDF, the text of one, or an `MjModel` (which is copied).
    inputs
        Names of actuators; all if not given.
    outputs
        Names of sensors (`"force[2]"` for one number of several), of joints (their positions), or
        `"joint.qpos"` and `"joint.qvel"`; a dict gives noise: `{"q1": fdiag.Output("rad", noise=1e-3)}`. All sensors
        if not given. Whole turns of hinges without limits are no gap, unless it says `wraps=False`.
    uncertain
        Parameters by path, with how well they are known, relative to their values:
        `{"joint/q1.damping": .1, "body/link2.mass": .05, "actuator/u1.gear[0]": .02, "option/gravity[2]": .001}`.
        With the mass of a body its inertia grows in the same proportion.
    ports
        Hinge and slide joints at which forces may be added, or `"all"` of them.
    native
        Effects that MuJoCo has in itself and that are tried as well: `"all"`, labels (`"coulomb-friction"`), either at
        one place (`"coulomb-friction@q1"`), or `None`. A number that is `uncertain` is none of them.
    initial
        How well positions and velocities at the start are known: `{"q1": .01, "q1.qvel": .1}` in rad or m, and per
        s. Those of hinge and slide joints that are not named are known to .01 and .05; `None` is exactly.
    keyframe
        Where runs begin: a keyframe, or the reference configuration.
    sample_time
        Time between samples, in s: a whole number of time steps of the scene, one if not given.

    Free and ball joints begin where the keyframe has them. Inputs and forces are held over a sample. A run of which
    a number is not finite is one that diverges.
    """

    def __init__(
        self,
        scene: Any,
        inputs: _stated.Entries = None,
        outputs: _stated.Entries = None,
        uncertain: Mapping[str, float | Mapping[str, Any]] | None = None,
        ports: str | Iterable[str] | None = None,
        *,
        native: str | Iterable[str] | None = "all",
        initial: Mapping[str, float | None] | None = None,
        keyframe: str | None = None,
        sample_time: float | None = None,
        name: str | None = None,
        workers: int = 1,
    ):
        model = as_model(scene)
        step = float(model.opt.timestep)
        ts = step if sample_time is None else float(sample_time)
        substeps = round(ts / step)
        if substeps < 1 or abs(substeps * step - ts) > 1e-9 * ts:
            raise InputError(
                f"sample_time: expected a whole number of time steps of {step} s, found {ts} s"
            )
        actuators = [model.actuator(i).name for i in range(model.nu)]
        sensors = [model.sensor(i).name for i in range(model.nsensor)]
        said_inputs = _stated.entries("inputs", actuators if inputs is None else inputs)
        for entry in said_inputs:
            if entry["name"] not in actuators:
                known = nearest(entry["name"], actuators)
                raise InputError(f"inputs: the scene has no actuator `{entry['name']}`{known}")
            entry.setdefault("unit", input_unit(model, entry["name"]))
        said_outputs = _stated.entries("outputs", sensors if outputs is None else outputs)
        places = [output_place(model, entry["name"], sensors) for entry in said_outputs]
        for entry, place in zip(said_outputs, places):
            entry.setdefault("unit", place.unit)
            if place.wraps and entry["unit"] == place.unit:
                entry.setdefault("wraps", True)
        paths, said_parameters = _parameters(model, uncertain or {})
        joints = _joints(model)
        of_joint = _moved(said_outputs, places)
        chosen = _chosen(ports, joints)
        called = _called(joints, [*said_inputs, *said_outputs])
        said_ports = [
            {"name": called[joint], "unit": joints[joint].force, **of_joint.get(joint, {})}
            for joint in chosen
        ]
        states = _states(model, joints, initial or {}, keyframe)
        uncertain_fields = {(path.kind, path.name, path.field) for path in paths}
        positions = [state["initial"] for state in states[::2]]
        of_joints = {name: (joint.velocity, at) for (name, joint), at in zip(joints.items(), positions)}
        of_sensors = {entry["name"]: place.sensor for entry, place in zip(said_outputs, places) if place.sensor}
        natives = _effects(
            model,
            of_joints,
            called,
            [entry["name"] for entry in said_inputs],
            of_sensors,
            uncertain_fields,
            native,
        )
        frame = None if keyframe is None else _keyframe(model, keyframe)
        opener = Opener(
            lambda: Scene(
                copy.copy(model),
                substeps,
                [model.actuator(entry["name"]).id for entry in said_inputs],
                places,
                [*paths, *(part for part, _ in natives)],
                [joints[joint].velocity for joint in chosen],
                [(joint.position, joint.velocity) for joint in joints.values()],
                frame,
            )
        )
        # What a run begins with is then all that it depends on.
        is_whole = len(states) == model.nq + model.nv and model.na == 0 and not getattr(model, "nhistory", 0)
        lent_out = lent(
            opener,
            {"step": True, "measure": True, "states": is_whole and bool(states)},
            name=name or _name(scene, model),
            sample_time=ts,
            rooms={
                "inputs": said_inputs,
                "outputs": said_outputs,
                "parameters": said_parameters,
                "states": states,
                "ports": said_ports,
                "native_effects": [entry for _, entry in natives],
            },
            takes_forces=True,
            workers=workers,
        )
        super().__init__(lent_out)
        self._source = scene
        self._model = model
        self._parts = [*paths, *(part for part, _ in natives)]
        # What they are called, and where they rest.
        self._dormant = {f"{entry['label']}@{entry['place']}": (part, float(entry["value"])) for part, entry in natives}

    def _written(
        self, values: list[float], causes: Iterable[Cause], path: str | os.PathLike[str]
    ) -> WrittenScene:
        """The scene with these values of its parameters and effects, as a file."""
        return write(self._source, self._model, dict(zip(self._parts, values)), causes, path)


@dataclass(frozen=True)
class _Joint:
    """A joint of one degree of freedom."""

    position: int
    """Its place in `qpos`."""
    velocity: int
    """Its place in `qvel`."""
    unit: str
    force: str


def _joints(model: Any) -> dict[str, _Joint]:
    """Hinge and slide joints with a name."""
    found = {}
    for i in range(model.njnt):
        name, kind = model.joint(i).name, int(model.jnt_type[i])
        if name and kind in (2, 3):
            unit, force = (("m", "N"), ("rad", "N m"))[kind - 2]
            found[name] = _Joint(int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i]), unit, force)
    return found


def _called(joints: Iterable[str], channels: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    """What joints are called in answers: robots often have an actuator, or a log a column, of the name of a joint."""
    taken = {channel["name"] for channel in channels}
    return {joint: f"{joint}_joint" if joint in taken else joint for joint in joints}


def _chosen(ports: str | Iterable[str] | None, joints: Mapping[str, _Joint]) -> list[str]:
    if ports is None:
        return []
    if isinstance(ports, str):
        ports = joints if ports == "all" else [ports]
    chosen = list(ports)
    for port in chosen:
        if port not in joints:
            raise InputError(f"ports: the scene has no hinge or slide joint `{port}`{nearest(port, joints)}")
    return chosen


def _moved(outputs: list[dict[str, Any]], places: list[_Place]) -> dict[str, dict[str, str]]:
    """Which outputs are the position and the velocity of each joint."""
    moved: dict[str, dict[str, str]] = {}
    for entry, place in zip(outputs, places):
        if place.joint is not None:
            key = "position" if place.room == "qpos" else "velocity"
            moved.setdefault(place.joint, {}).setdefault(key, entry["name"])
    return moved


def _parameters(
    model: Any, uncertain: Mapping[str, float | Mapping[str, Any]]
) -> tuple[list[_Path], list[dict[str, Any]]]:
    paths, entries = [], []
    for text, known in uncertain.items():
        path = parameter_path(model, text)
        value = float(path.array(model)[path.index])
        said: dict[str, Any] = (
            dict(known) if isinstance(known, Mapping) else {"tolerance": float(known)}
        )
        if path.field in _POSITIVE and value > 0.0:
            # Beyond, MuJoCo has no numbers, or other laws.
            said.setdefault("bounds", [0.01 * value, 100.0 * value])
        if value == 0.0:
            raise InputError(
                f"uncertain: `{text}`: expected a value other than 0, to which the tolerance is relative, found 0.0"
            )
        paths.append(path)
        entries.append({"name": text, "unit": path.unit, "value": value, **said})
    return paths, entries


def _states(
    model: Any,
    joints: Mapping[str, _Joint],
    initial: Mapping[str, float | None],
    keyframe: str | None,
) -> list[dict[str, Any]]:
    """Position and velocity of each joint."""
    known = [name for joint in joints for name in (joint, f"{joint}.qpos", f"{joint}.qvel")]
    for name in initial:
        if name not in known:
            raise InputError(f"initial: the scene has no joint `{name}`{nearest(name, known)}")
    qpos: npt.NDArray[np.float64] = model.qpos0
    qvel = np.zeros(model.nv)
    if keyframe is not None:
        frame = _keyframe(model, keyframe)
        qpos, qvel = model.key_qpos[frame], model.key_qvel[frame]
    states = []
    for name, joint in joints.items():
        position = initial.get(name, initial.get(f"{name}.qpos", _KNOWN[0]))
        velocity = initial.get(f"{name}.qvel", _KNOWN[1])
        for room, value, tolerance, unit in (
            ("qpos", qpos[joint.position], position, joint.unit),
            ("qvel", qvel[joint.velocity], velocity, f"{joint.unit}/s"),
        ):
            said = {"name": f"{name}.{room}", "unit": unit, "initial": float(value)}
            states.append(said if tolerance is None else {**said, "tolerance": float(tolerance)})
    return states


def _keyframe(model: Any, keyframe: str) -> int:
    names = [model.key(i).name for i in range(model.nkey)]
    if keyframe not in names:
        raise InputError(f"keyframe: the scene has no keyframe `{keyframe}`{nearest(keyframe, names)}")
    return names.index(keyframe)


def _name(scene: Any, model: Any) -> str:
    """That of the file, or of the scene."""
    if isinstance(scene, (str, os.PathLike)) and "<" not in os.fspath(scene):
        return os.path.splitext(os.path.basename(os.fspath(scene)))[0]
    name = bytes(model.names).split(b"\0", 1)[0].decode(errors="replace")
    return "scene" if name in ("", "MuJoCo Model") else name
