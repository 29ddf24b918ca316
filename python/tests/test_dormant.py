"""What lies dormant in MuJoCo, joint by joint and limit by limit. Reality is an edited scene, run by MuJoCo alone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fdiag

mujoco = pytest.importorskip("mujoco")

TEXT = """
<mujoco model="rig">
  <option timestep="0.01" integrator="implicitfast"/>
  <worldbody>{bodies}</worldbody>
  {more}
</mujoco>
"""
ROD = """
<body name="rod">
  <joint name="pivot" axis="0 1 0" damping=".2" armature=".02" stiffness="2" springref="0"/>
  <geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02" mass="1" contype="0" conaffinity="0"/>
</body>
"""
SERVO = TEXT.format(
    bodies=ROD,
    more='<actuator><position name="u" joint="pivot" kp="9" kv=".6" ctrlrange="-1 1" forcerange="-2 2"/></actuator>'
    '<sensor><jointpos name="angle" joint="pivot"/><jointvel name="rate" joint="pivot"/></sensor>',
)
FREE = SERVO.replace(' forcerange="-2 2"', "")
STOPPED = SERVO.replace('springref="0"', 'springref="0" range="-25 25"')
WEAK = SERVO.replace('springref="0"', 'springref="0" actuatorfrcrange="-2 2"').replace(' forcerange="-2 2"', "")
CLIPPED = FREE.replace('<jointpos name="angle" joint="pivot"/>', '<jointpos name="angle" joint="pivot" cutoff=".3"/>')
LATE = FREE.replace('ctrlrange="-1 1"', 'delay=".06" nsample="12"')
LEG = TEXT.format(
    bodies="""
    <geom name="floor" type="plane" size="1 1 1"/>
    <body name="leg" pos="0 0 .0996">
      <joint name="height" type="slide" axis="0 0 1"/>
      <geom name="foot" size=".1" mass="1"/>
    </body>""",
    more='<actuator><motor name="u" joint="height" gear="3"/></actuator>'
    '<sensor><jointpos name="angle" joint="height"/><jointvel name="rate" joint="height"/></sensor>',
)
TWO = """
<body name="first"><joint name="a" type="slide" axis="1 0 0" damping="1"/><geom size=".1" mass="1"/></body>
<body name="second" pos="0 1 0"><joint name="b" type="slide" axis="1 0 0" damping="1"/><geom size=".1" mass="1"/></body>
"""
PUSHED = """
<actuator><motor name="u" joint="a" gear="3"/></actuator>
<sensor><jointpos name="angle" joint="a"/><jointpos name="rate" joint="b"/></sensor>
"""
TENDON = TEXT.format(
    bodies=TWO,
    more='<tendon><fixed name="band" stiffness="20"><joint joint="a" coef="1"/><joint joint="b" coef="-1"/></fixed>'
    "</tendon>" + PUSHED,
)
MESH = '<equality><joint name="mesh" joint1="a" joint2="b" polycoef="0 1"/></equality>'
GEARED = TEXT.format(bodies=TWO, more=MESH + PUSHED)
# One that is stiff hides how stiff it is.
SOFT = GEARED.replace('polycoef="0 1"', 'solref=".4 1" polycoef="0 1"')
NOISE = {"angle": 0.001, "rate": 0.004}


@dataclass(frozen=True)
class Edit:
    """A change of a scene, the effect that it is, and the value of its parameter."""

    scene: str
    old: str
    new: str
    cause: str
    value: float
    is_clear: bool = True
    """Whether a log of 3 s is enough for a verdict."""

    @property
    def reality(self) -> str:
        assert self.old in self.scene
        return self.scene.replace(self.old, self.new, 1)


EDITS = (
    Edit(SERVO, 'springref="0"', 'springref="8"', "constant-load@pivot", 2.0 * np.radians(8.0)),
    Edit(SERVO, 'kp="9"', 'gear="1.2" kp="9"', "gear-ratio@u", 1.2),
    Edit(FREE, 'ctrlrange="-1 1"', 'ctrlrange="-1.3 1.3"', "command-reserve@u", 0.3),
    Edit(SERVO, '"-2 2"', '"-2.6 2.6"', "force-reserve@u", 0.3),
    Edit(SERVO, '"-2 2"', '"-1.25 1.25"', "force-limit@u", 0.8),
    Edit(WEAK, '"-2 2"', '"-1.25 1.25"', "force-limit@pivot", 0.8),
    Edit(WEAK, '"-2 2"', '"-2.6 2.6"', "force-reserve@pivot", 0.3),
    Edit(STOPPED, '"-25 25"', '"-30 30"', "range-reserve@pivot", 0.2),
    Edit(FREE, 'springref="0"', 'springref="0" range="-12 12"', "end-stop@pivot", 1.0 / np.radians(12.0)),
    Edit(CLIPPED, 'cutoff=".3"', 'cutoff=".36"', "sensor-reserve@angle", 1.2),
    Edit(LATE, 'delay=".06"', 'delay=".03"', "input-delay@u", 0.03),
    Edit(LATE, 'delay=".06"', 'delay=".085" interp="linear"', "input-delay@u", 0.085),
    Edit(LEG, 'size=".1" mass="1"', 'size=".1" mass="1" solref=".06 1"', "contact-softness@foot", 3.0),
    Edit(TENDON, 'stiffness="20"', 'stiffness="20" damping="3"', "viscous-friction@band", 3.0),
    Edit(TENDON, 'stiffness="20"', 'stiffness="30"', "linear-stiffness@band", 30.0),
    Edit(TENDON, 'stiffness="20"', 'stiffness="20" frictionloss=".4"', "coulomb-friction@band", 0.4),
    Edit(GEARED, '"0 1"', '"0 1.15"', "coupling-ratio@mesh", 1.15),
    Edit(GEARED, '"0 1"', '".03 1"', "coupling-offset@mesh", 0.03),
    Edit(SOFT, 'solref=".4 1"', 'solref="1 1"', "coupling-softness@mesh", 2.5, False),
)
SEEN_LATE = FREE.replace('joint="pivot"/><jointvel', 'joint="pivot" delay=".02" nsample="8"/><jointvel')
#: Those that are not looked for in a log.
MORE = (
    Edit(SEEN_LATE, 'delay=".02"', 'delay=".05"', "sensor-delay@angle", 0.05),
    Edit(LEG, 'size=".1" mass="1"', 'size=".1" mass="1" solref=".02 .2"', "contact-damping@foot", 0.2),
    Edit(TENDON, 'stiffness="20"', 'stiffness="20" armature=".5"', "armature@band", 0.5),
)


def scene(text: str) -> fdiag.MuJoCo:
    return fdiag.MuJoCo(text, outputs={name: fdiag.Output(noise=noise) for name, noise in NOISE.items()}, ports="all")


def commands(samples: int, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    u = np.repeat(random.uniform(-1.8, 1.8, samples // 20 + 1), 20)[:samples]
    # From rest: a delay line is taken to hold what there was before.
    u[:10] = 0.0
    return u


def run(model: Any, u: np.ndarray) -> np.ndarray:
    """By MuJoCo alone."""
    data = mujoco.MjData(model)
    y = np.empty((len(u), 2))
    for k, command in enumerate(u):
        data.ctrl[0] = command
        mujoco.mj_step1(model, data)
        y[k] = data.sensordata
        mujoco.mj_step(model, data)
    return y


def name(edit: Edit) -> str:
    return f"{edit.cause}={edit.value:.3g}"


@pytest.mark.parametrize("edit", EDITS + MORE, ids=name)
def test_a_value_is_an_edit_of_the_scene(edit: Edit) -> None:
    u, (part, _) = commands(200, 1), scene(edit.scene)._dormant[edit.cause]
    pristine, model = (mujoco.MjModel.from_xml_string(edit.scene) for _ in range(2))
    part.set(model, edit.value, pristine)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    told, real = run(model, u), run(mujoco.MjModel.from_xml_string(edit.reality), u)
    # An inverse of an inverse, or degrees in radians, differ in the last digit; a contact makes more of it.
    assert np.allclose(told, real, rtol=1e-6, atol=1e-9), np.abs(told - real).max()
    assert not np.allclose(run(pristine, u), real, rtol=1e-3, atol=1e-4), "nothing to be seen"


@pytest.mark.parametrize("edit", EDITS + MORE, ids=name)
def test_a_value_is_written_as_mjcf(edit: Edit, tmp_path: Path) -> None:
    u, simulator = commands(200, 1), scene(edit.scene)
    values = [edit.value if cause == edit.cause else rest for cause, (_, rest) in simulator._dormant.items()]
    written = simulator._written(values, [], tmp_path / "edited.xml")
    assert written.numbers
    told = run(mujoco.MjModel.from_xml_path(str(written.path)), u)
    real, nominal = (run(mujoco.MjModel.from_xml_string(text), u) for text in (edit.reality, edit.scene))
    # A text has six digits, and a contact makes more of the next one.
    assert np.abs(told - real).max() < 0.01 * np.abs(nominal - real).max()


@pytest.mark.parametrize("edit", EDITS, ids=name)
def test_an_edit_of_the_scene_is_named(edit: Edit) -> None:
    u = commands(300, 2)
    y = run(mujoco.MjModel.from_xml_string(edit.reality), u)
    y = y + np.random.default_rng(3).standard_normal((300, 2)) * list(NOISE.values())
    log = {"time": 0.01 * np.arange(300), "u": u, "angle": y[:, 0], "rate": y[:, 1]}
    result = fdiag.gap(scene(edit.scene), log, exclude=["map"], most=1)
    assert result.verdict in (("cause", "tied") if edit.is_clear else ("cause", "tied", "unclear")), result.headline
    # Of two bodies that touch each other, none can be told to be the soft one.
    named = [cause for cause in result.causes if cause.is_tied] if result.verdict == "tied" else result.causes[:1]
    assert edit.cause in [cause.name for cause in named], result.headline


def test_a_nearer_range_of_commands_is_named() -> None:
    """In a scene that cuts commands off itself, which a linearisation does not see beyond."""
    u, reality = commands(300, 2), FREE.replace('"-1 1"', '"-.6 .6"')
    y = run(mujoco.MjModel.from_xml_string(reality), u)
    y = y + np.random.default_rng(3).standard_normal((300, 2)) * list(NOISE.values())
    log = {"time": 0.01 * np.arange(300), "u": u, "angle": y[:, 0], "rate": y[:, 1]}
    result = fdiag.gap(scene(FREE), log, exclude=["map"], most=1)
    assert (result.verdict, result.causes[0].name) == ("cause", "input-saturation@u"), result.headline
    assert abs(1.0 / result.causes[0].parameters[0].value - 0.6) < 0.01
