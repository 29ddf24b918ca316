"""What differs in the real system, made by another path than the effects of `fdiag`: the scene is edited (MjSpec), the
command on its way to the actuators is changed by a function, or what the sensors show is; and the log of it, from a
loop around `mj_step`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from robots import Scene

Rng = np.random.Generator
Array = np.ndarray


@dataclass
class Truth:
    """A withheld change: what is right, and how the real system differs."""

    names: set[str]
    edit: Callable[[Any], None] = lambda spec: None
    command: Callable[[Array], Array] = lambda u: u
    shown: Callable[[Array], Array] = lambda y: y
    size: dict[str, float] = field(default_factory=dict)


def joint_edit(joint: str, **values: float) -> Callable[[Any], None]:
    """Adds to numbers of a joint; to the linear part where there is a polynomial."""

    def edit(spec: Any) -> None:
        for name, value in values.items():
            old = getattr(spec.joint(joint), name)
            if np.ndim(old):
                new = np.array(old, float)
                new[0] += value
                setattr(spec.joint(joint), name, new)
            else:
                setattr(spec.joint(joint), name, old + value)

    return edit


def mass_edit(body: str, factor: float) -> Callable[[Any], None]:
    def edit(spec: Any) -> None:
        if spec.body(body).explicitinertial:
            whole = spec.body(body)
            whole.mass *= factor
            whole.inertia, whole.fullinertia = np.array(whole.inertia) * factor, np.array(whole.fullinertia) * factor
            return
        for geom in spec.body(body).geoms:
            # By its mass where that is stated, else by its density.
            if np.isnan(geom.mass):
                geom.density *= factor
            else:
                geom.mass *= factor

    return edit


def later(values: Array, i: int, samples: int) -> Array:
    """One column that comes later; before, it is what it was at first."""
    moved = values.copy()
    moved[samples:, i] = values[:-samples, i]
    moved[:samples, i] = values[0, i]
    return moved


def draw(scene: Scene, kind: str, random: Rng) -> Truth:
    """One change of a kind, at a place by chance."""
    i = int(random.integers(len(scene.joints)))
    joint, name, amplitude = scene.joints[i], scene.inputs[i], scene.amplitude[i]
    model = scene.spec().compile()
    dof = int(model.joint(joint).dofadr[0])
    inertia, damping = float(model.dof_M0[dof]), float(np.ravel(model.joint(joint).damping)[0])
    # What the actuator does at full command.
    torque = amplitude * float(model.actuator(name).gainprm[0]) * float(model.actuator(name).gear[0])
    if scene.is_servo:
        # That of the servo; where it has none, that of the joint.
        damping = float(-model.actuator(name).biasprm[2]) or damping
    much = float(random.uniform(1.0, 2.0))
    if kind == "nothing":
        return Truth(set())
    if kind == "friction":
        size = 0.06 * torque * much
        return Truth({f"coulomb-friction@{joint}"}, edit=joint_edit(joint, frictionloss=size), size={"f": size})
    if kind == "damping":
        # Far beyond the 10 % of the parameter: an error of it, and friction there, are the same.
        size = 0.5 * much * damping
        names = {f"viscous-friction@{joint}", f"parameter-error@joint_{joint}_damping"}
        return Truth(names, edit=joint_edit(joint, damping=size), size={"c": size})
    if kind == "armature":
        size = 0.25 * much * inertia
        return Truth({f"armature@{joint}"}, edit=joint_edit(joint, armature=size), size={"I": size})
    if kind == "spring":
        size = 0.5 * torque * much
        return Truth({f"linear-stiffness@{joint}"}, edit=joint_edit(joint, stiffness=size), size={"k": size})
    if kind == "payload":
        body = scene.payload[int(random.integers(len(scene.payload)))]
        # A gripper, or what it holds: as heavy as the arm's upper parts, and more.
        factor = 1.0 + 2.0 * much
        return Truth({f"body-mass@{body}"}, edit=mass_edit(body, factor), size={"m": factor})
    if kind == "gain":
        factor = 1.0 - 0.12 * much

        def weaken(spec: Any) -> None:
            actuator = spec.actuator(name)
            gain, bias = np.array(actuator.gainprm, float), np.array(actuator.biasprm, float)
            if scene.is_servo:
                # A servo with another kp, and the kv it had.
                gain[0], bias[1] = gain[0] * factor, bias[1] * factor
                actuator.gainprm, actuator.biasprm = gain, bias
            else:
                actuator.gear = np.array(actuator.gear) * factor

        label = "servo-gain" if scene.is_servo else "input-gain"
        return Truth({f"{label}@{name}"}, edit=weaken, size={"e": factor - 1.0})
    if kind == "delay":
        late = int(random.integers(2, 5))
        size = {"T": scene.sample_time * late}
        return Truth({f"input-delay@{name}"}, command=lambda u: later(u, i, late), size=size)
    if kind == "lag":
        constant = 2.0 * scene.sample_time * much

        def lag(u: Array) -> Array:
            u, share = u.copy(), 1.0 - np.exp(-scene.sample_time / constant)
            for k in range(1, len(u)):
                u[k, i] = u[k - 1, i] + share * (u[k, i] - u[k - 1, i])
            return u

        return Truth({f"input-lag@{name}"}, command=lag, size={"T": constant})
    if kind == "dead-zone":
        size = 0.1 * amplitude * much

        def dead(u: Array) -> Array:
            u = u.copy()
            u[:, i] -= np.clip(u[:, i], -size, size)
            return u

        return Truth({f"input-dead-zone@{name}"}, command=dead, size={"w": size})
    if kind == "bias":
        size = 10.0 * scene.noise[0] * much

        def bias(y: Array) -> Array:
            y = y.copy()
            y[:, i] += size
            return y

        return Truth({f"sensor-bias@at_{joint}"}, shown=bias, size={"b": size})
    if kind == "slow-sensor":
        late = int(random.integers(2, 5))
        size = {"T": scene.sample_time * late}
        return Truth({f"sensor-delay@at_{joint}"}, shown=lambda y: later(y, i, late), size=size)
    raise ValueError(kind)


def excitation(scene: Scene, home: Array, random: Rng) -> Array:
    """Steps of random height, each held for a while, about the home position of a servo."""
    u = np.empty((scene.samples, len(scene.inputs)))
    for i, amplitude in enumerate(scene.amplitude):
        values: list[float] = []
        while len(values) < scene.samples:
            values += [float(random.uniform(-amplitude, amplitude))] * int(random.integers(*scene.hold))
        u[:, i] = values[: scene.samples]
    # From rest.
    u[:10] = 0.0
    return u + home if scene.is_servo else u


def real(scene: Scene, truth: Truth, random: Rng) -> dict[str, Array]:
    """A log of the real system."""
    spec = scene.spec()
    for path, tolerance in scene.uncertain.items():
        factor = 1.0 + float(random.uniform(-0.5, 0.5)) * tolerance
        kind, _, rest = path.partition("/")
        name, _, what = rest.rpartition(".")
        if kind == "joint":
            joint_edit(name, **{what: (factor - 1.0) * float(np.ravel(getattr(spec.joint(name), what))[0])})(spec)
        else:
            mass_edit(name, factor)(spec)
    truth.edit(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    if scene.keyframe is not None:
        mujoco.mj_resetDataKeyframe(model, data, model.key(scene.keyframe).id)
    u = excitation(scene, scene.home(model), random)
    sent = truth.command(u)
    names = list(scene.outputs)
    y = np.empty((scene.samples, len(names)))
    substeps = round(scene.sample_time / model.opt.timestep)
    places = [_address(model, name) for name in names]
    for k in range(scene.samples):
        data.ctrl[:] = sent[k]
        mujoco.mj_step1(model, data)
        y[k] = data.sensordata[places]
        mujoco.mj_step(model, data, substeps)
    noise = np.array([output.noise for output in scene.outputs.values()])
    y = truth.shown(y) + random.standard_normal(y.shape) * noise
    if not np.isfinite(y).all():
        raise ValueError(f"{scene.name}: the real system does not stay finite")
    named = {name: u[:, i] for i, name in enumerate(scene.inputs)}
    return {"time": np.arange(scene.samples) * scene.sample_time, **named, **dict(zip(names, y.T))}


def _address(model: Any, name: str) -> int:
    """Where a sensor, or one number of it, is in `sensordata`."""
    sensor, _, number = name.rstrip("]").partition("[")
    return int(model.sensor(sensor).adr[0]) + int(number or 0)
