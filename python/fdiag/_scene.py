"""A MuJoCo scene that is started and stepped, and the names of what it shows."""

from __future__ import annotations

import copy
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _fdiag
from ._names import nearest
from ._parts import Part, Ranged
from .errors import Error, InputError

Array = npt.NDArray[np.float64]


def library() -> Any:
    """The package `mujoco`."""
    try:
        import mujoco
    except ImportError as error:
        raise Error("MuJoCo: expected the package to be installed: pip install mujoco") from error
    return mujoco


def as_model(scene: Any) -> Any:
    """The model of a file, of a text, or a copy."""
    mujoco = library()
    if isinstance(scene, mujoco.MjModel):
        return copy.copy(scene)
    if not isinstance(scene, (str, os.PathLike)):
        kind = type(scene).__name__
        raise InputError(f"scene: expected a file, a text or an MjModel, found a value of type `{kind}`")
    text = os.fspath(scene)
    try:
        if "<" in text:
            return mujoco.MjModel.from_xml_string(text)
        return mujoco.MjModel.from_xml_path(text)
    except ValueError as error:
        raise InputError(f"scene: {'the text' if '<' in text else text}: {error}") from error


@dataclass(frozen=True)
class Place:
    """Where an output is."""

    room: str
    """`qpos`, `qvel` or `sensordata`."""
    index: int
    unit: str
    joint: str | None = None
    """The joint of which it is the position or the velocity."""
    sensor: str | None = None
    """The sensor that gives it, where it is none of a joint that shows it as it is."""
    wraps: bool = False
    """Whether it is an angle of which a log may leave out whole turns."""


#: Names of types of sensors, and units of what they give.
_SENSOR_UNITS = {
    "ACCELEROMETER": "m/s^2",
    "VELOCIMETER": "m/s",
    "GYRO": "rad/s",
    "FORCE": "N",
    "TORQUE": "N m",
    "RANGEFINDER": "m",
    "FRAMEPOS": "m",
    "FRAMELINVEL": "m/s",
    "FRAMEANGVEL": "rad/s",
    "FRAMELINACC": "m/s^2",
    "FRAMEANGACC": "rad/s^2",
    "SUBTREECOM": "m",
    "SUBTREELINVEL": "m/s",
    "TENDONPOS": "m",
    "TENDONVEL": "m/s",
    "CLOCK": "s",
}


def output_place(model: Any, name: str, sensors: Sequence[str]) -> Place:
    """The place of an output: a sensor, a number of one, or a joint."""
    joints = [model.joint(i).name for i in range(model.njnt)]
    found = re.fullmatch(r"(.*)\[(\d+)\]", name)
    base, number = (found[1], int(found[2])) if found else (name, None)
    if base in sensors:
        return _sensor(model, name, sensors.index(base), number)
    joint, _, room = name.rpartition(".") if name.endswith((".qpos", ".qvel")) else (name, "", "qpos")
    if joint in joints:
        return _joint(model, f"outputs: `{name}`", joints.index(joint), room)
    known = [*sensors, *joints, *(f"{joint}.qvel" for joint in joints)]
    raise InputError(f"outputs: the scene has no sensor or joint `{name}`{nearest(name, known)}")


def _joint(model: Any, what: str, joint: int, room: str) -> Place:
    kind = int(model.jnt_type[joint])
    if kind not in (2, 3):
        raise InputError(f"{what}: expected a hinge or slide joint, found a free or ball joint: use a sensor")
    unit = ("m", "rad")[kind - 2]
    if room == "qpos":
        wraps = kind == 3 and not model.jnt_limited[joint]
        return Place(room, int(model.jnt_qposadr[joint]), unit, model.joint(joint).name, wraps=wraps)
    return Place(room, int(model.jnt_dofadr[joint]), f"{unit}/s", model.joint(joint).name)


def _sensor(model: Any, name: str, sensor: int, number: int | None) -> Place:
    kinds = library().mjtSensor
    size, kind = int(model.sensor_dim[sensor]), int(model.sensor_type[sensor])
    if number is None and size != 1:
        raise InputError(f"outputs: sensor `{name}` has {size} numbers: expected one of them, such as `{name}[0]`")
    if number is not None and not number < size:
        raise InputError(f"outputs: `{name}`: the sensor has {size} numbers, counted from 0")
    is_plain = not model.sensor_cutoff[sensor] and not _delay(model, sensor)
    for is_kind, room in ((kinds.mjSENS_JOINTPOS, "qpos"), (kinds.mjSENS_JOINTVEL, "qvel")):
        if kind == int(is_kind):
            place = _joint(model, f"outputs: `{name}`", int(model.sensor_objid[sensor]), room)
            # What a joint shows need not be computed first.
            if is_plain:
                return place
            index, called = int(model.sensor_adr[sensor]), model.sensor(sensor).name
            return Place("sensordata", index, place.unit, sensor=called, wraps=place.wraps)
    label = kinds(kind).name.removeprefix("mjSENS_")
    unit = _SENSOR_UNITS.get(label, "1")
    at = int(model.sensor_adr[sensor]) + (number or 0)
    return Place("sensordata", at, unit, sensor=model.sensor(sensor).name)


def _delay(model: Any, sensor: int) -> float:
    """The delay of a sensor, where this version of MuJoCo has that."""
    delays = getattr(model, "sensor_delay", None)
    return 0.0 if delays is None else float(np.ravel(delays)[sensor])


def input_unit(model: Any, name: str) -> str:
    """The unit of the control of an actuator at a joint, as far as it is plain."""
    actuator = model.actuator(name)
    mujoco = library()
    index = int(actuator.id)
    if int(model.actuator_trntype[index]) != int(mujoco.mjtTrn.mjTRN_JOINT):
        return "1"
    kind = int(model.jnt_type[int(model.actuator_trnid[index][0])])
    if kind not in (2, 3):
        return "1"
    of_position, of_velocity = model.actuator_biasprm[index][1], model.actuator_biasprm[index][2]
    unit, force = (("m", "N"), ("rad", "N m"))[kind - 2]
    if of_position:
        return unit
    return f"{unit}/s" if of_velocity else force


class Scene:
    """Model and data of one worker. Samples are taken by `steps`, without code of Python."""

    def __init__(
        self,
        model: Any,
        substeps: int,
        controls: list[int],
        places: list[Place],
        parts: Sequence[Part],
        forces: list[int],
        states: list[tuple[int, int]],
        keyframe: int | None,
    ):
        mujoco = library()
        # A scene that blows up is a run that diverges, not one that begins anew.
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        self._model, self._data = model, mujoco.MjData(model)
        self._keyframe = keyframe
        # Masses first: an inertia that is itself a parameter has the last word.
        self._parts = sorted(enumerate(parts), key=lambda p: getattr(p[1], "field", "") != "mass")
        self._ranges = [part for part in parts if isinstance(part, Ranged)]
        self._pristine = copy.copy(model)
        self._set: list[float] | None = None
        self._positions = np.array([p for p, _ in states], int)
        self._velocities = np.array([v for _, v in states], int)
        data = self._data
        self._qpos, self._qvel = data.qpos, data.qvel
        self._warnings = data.warning.number
        rooms = {"qpos": data.qpos, "qvel": data.qvel, "sensordata": data.sensordata}
        shown: dict[str, tuple[Array, list[int], list[int]]] = {}
        for room, array in rooms.items():
            to = [i for i, place in enumerate(places) if place.room == room]
            of = [place.index for place in places if place.room == room]
            if to:
                shown[room] = (array, to, of)
        sensed = [shown.pop("sensordata")] if "sensordata" in shown else []
        self.steps = _fdiag.SceneSteps(
            (mujoco.mj_step, mujoco.mj_forward),
            model,
            data,
            substeps,
            (data.ctrl, controls),
            (data.qfrc_applied, forces),
            list(shown.values()),
            # The first time step of a sample computes the sensors before it moves.
            sensed,
            data.qacc_warmstart,
            ((data.qpos, self._positions.tolist()), (data.qvel, self._velocities.tolist())),
        )
        self._mj_reset, self._mj_keyframe = mujoco.mj_resetData, mujoco.mj_resetDataKeyframe
        self._mj_set_const = mujoco.mj_setConst

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        """Begins a run."""
        values = list(parameters.values())
        if values != self._set:
            # Several parts may move the ends of one range.
            for ranged in self._ranges:
                ranged.clear(self._model, self._pristine)
            for i, part in self._parts:
                part.set(self._model, values[i], self._pristine)
            self._set = values
            # Masses and lengths have consequences that the model holds.
            self._mj_set_const(self._model, self._data)
        if self._keyframe is None:
            self._mj_reset(self._model, self._data)
        else:
            self._mj_keyframe(self._model, self._data, self._keyframe)
        # MuJoCo prints the first warning of a kind in a run, and writes it to a file. That a run diverges shows in its
        # outputs, so none is the first.
        self._warnings[:] = 1
        start = list(x0.values())
        self._qpos[self._positions] = start[0::2]
        self._qvel[self._velocities] = start[1::2]
