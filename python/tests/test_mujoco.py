"""MuJoCo scenes as simulators, with changes made by editing the scene and not by the effects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fdiag

mujoco = pytest.importorskip("mujoco")

PENDULUM = """
<mujoco model="pendulum">
  <option timestep="0.01" integrator="implicitfast"/>
  <worldbody>
    <body name="rod">
      <joint name="pivot" axis="0 1 0" damping=".08" armature=".01"/>
      <geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02" mass="1"/>
      <site name="tip" pos="0 0 -.5"/>
    </body>
  </worldbody>
  <actuator><motor name="torque" joint="pivot"/></actuator>
  <sensor>
    <jointpos name="angle" joint="pivot"/>
    <jointvel name="rate" joint="pivot"/>
    <actuatorfrc name="felt" actuator="torque"/>
    <accelerometer name="tip" site="tip"/>
  </sensor>
  <keyframe><key name="up" qpos="3"/></keyframe>
</mujoco>
"""
OUTPUTS = {"angle": fdiag.Output("rad", 0.002), "rate": fdiag.Output("rad/s", 0.01)}
UNCERTAIN = {"joint/pivot.damping": 0.1, "body/rod.mass": 0.02}


def scene(**settings: Any) -> fdiag.MuJoCo:
    asked = {"outputs": OUTPUTS, "uncertain": UNCERTAIN, "ports": "all"} | settings
    return fdiag.MuJoCo(PENDULUM, **asked)


def excitation(samples: int, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    return np.repeat(random.uniform(-1.5, 1.5, samples // 20 + 1), 20)[:samples]


def real(text: str, samples: int, seed: int) -> dict[str, np.ndarray]:
    """A log of an edited scene, by a loop of its own."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    random = np.random.default_rng(100 + seed)
    u, y = excitation(samples, seed), np.empty((samples, 2))
    for k in range(samples):
        y[k] = data.qpos[0], data.qvel[0]
        data.ctrl[0] = u[k]
        mujoco.mj_step(model, data)
    y += random.standard_normal(y.shape) * [0.002, 0.01]
    return {"time": np.arange(samples) * 0.01, "torque": u, "angle": y[:, 0], "rate": y[:, 1]}


def test_friction_of_an_edited_scene_is_named() -> None:
    edited = PENDULUM.replace('damping=".08"', 'damping=".083" frictionloss=".15"')
    result = fdiag.gap(
        scene(),
        real(edited, 300, 1),
        only=["coulomb-friction", "viscous-friction"],
        most=1,
    )
    assert result.causes[0].name == "coulomb-friction@pivot", result.headline
    force = next(p for p in result.causes[0].parameters if p.is_strength)
    assert force.unit == "N m" and abs(force.value - 0.15) < 0.03
    # The patched scene is a simulator that is nearer to reality.
    log = real(edited, 300, 3)
    y = np.stack([log["angle"], log["rate"]], axis=1)
    errors = [np.sqrt(np.mean((s.simulate(log["torque"]) - y) ** 2)) for s in (scene(), result.patched())]
    assert errors[1] < 0.25 * errors[0]


def test_no_gap_is_no_gap() -> None:
    other = PENDULUM.replace('damping=".08"', 'damping=".083"')
    result = fdiag.gap(
        scene(), real(other, 300, 4), only=["coulomb-friction", "input-gain"], most=1
    )
    assert result.verdict == "no-gap", result.headline


def test_a_run_is_that_of_mujoco_to_the_bit() -> None:
    u = excitation(100, 5)
    model = mujoco.MjModel.from_xml_string(PENDULUM)
    data = mujoco.MjData(model)
    expected = np.empty((100, 4))
    for k in range(100):
        data.ctrl[0] = u[k]
        mujoco.mj_step(model, data)
        # One time step leaves the sensors of before it.
        expected[k] = [data.sensor(name).data[i] for name, i in
                       (("angle", 0), ("rate", 0), ("felt", 0), ("tip", 2))]
    every = scene(outputs=["angle", "rate", "felt", "tip[2]"])
    assert [c.unit for c in every.outputs] == ["rad", "rad/s", "1", "m/s^2"]
    assert np.array_equal(every.simulate(u), expected)
    # And again after other parameters, which leave nothing behind.
    other = every.simulate(u, {"body_rod_mass": 1.3, "joint_pivot_damping": 0.2})
    assert not np.allclose(other, expected)
    assert np.array_equal(every.simulate(u), expected)


def test_a_mass_takes_its_inertia_along() -> None:
    u = excitation(200, 6)
    heavy = PENDULUM.replace('mass="1"', 'mass="1.2"')
    edited = fdiag.MuJoCo(heavy, outputs=OUTPUTS).simulate(u)
    assert np.allclose(scene().simulate(u, {"body_rod_mass": 1.2}), edited, rtol=1e-9, atol=1e-9)


def test_samples_of_several_time_steps() -> None:
    fine = PENDULUM.replace('timestep="0.01"', 'timestep="0.0025"')
    u = excitation(60, 7)
    slow = fdiag.MuJoCo(fine, outputs=["pivot", "pivot.qvel", "tip[0]"], sample_time=0.01)
    fast = fdiag.MuJoCo(fine, outputs=["pivot", "pivot.qvel", "tip[0]"])
    assert np.array_equal(slow.simulate(u), fast.simulate(np.repeat(u, 4))[::4])
    with pytest.raises(fdiag.InputError, match="expected a whole number of time steps of 0.0025 s"):
        fdiag.MuJoCo(fine, outputs=["pivot"], sample_time=0.003)


def test_runs_begin_at_a_keyframe() -> None:
    up = scene(keyframe="up")
    assert up.simulate([0.0])[0, 0] == 3.0
    assert up.simulate([0.0], initial={"pivot.qpos": 2.0})[0, 0] == 2.0


def test_a_scene_that_blows_up_is_a_run_that_diverges() -> None:
    y = scene().simulate(np.zeros(20), initial={"pivot.qvel": 1e307})
    assert np.isfinite(y[0]).all() and np.isnan(y[-1]).all()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"inputs": ["torq"]}, "inputs: the scene has no actuator `torq`, did you mean `torque`"),
        ({"outputs": ["angel"]}, "no sensor or joint `angel`, did you mean `angle`"),
        ({"outputs": ["tip"]}, r"sensor `tip` has 3 numbers: expected one of them, such as `tip\[0\]`"),
        ({"outputs": ["tip[3]"]}, "the sensor has 3 numbers, counted from 0"),
        ({"ports": ["pivto"]}, "no hinge or slide joint `pivto`, did you mean `pivot`"),
        ({"uncertain": {"joint/pivto.damping": 0.1}}, "no joint `pivto`, did you mean `pivot`"),
        ({"uncertain": {"joint/pivot.dampin": 0.1}}, "a joint has no field `dampin`, did you mean `damping`"),
        ({"uncertain": {"joint/pivot.frictionloss": 0.1}}, "expected a value other than 0"),
        ({"uncertain": {"actuator/torque.gear": 0.1}}, r"has 6 numbers: expected one of them"),
        ({"uncertain": {"pivot": 0.1}}, "expected a path such as"),
        ({"initial": {"pivt": 0.1}}, "no joint `pivt`"),
        ({"keyframe": "down"}, "no keyframe `down`"),
    ],
)
def test_names_that_are_wrong(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(fdiag.InputError, match=message):
        scene(**settings)


def test_what_is_no_scene_is_refused() -> None:
    with pytest.raises(fdiag.InputError, match="scene: the text"):
        fdiag.MuJoCo("<mujoco><nonsense/></mujoco>")
    with pytest.raises(fdiag.InputError, match="none.xml"):
        fdiag.MuJoCo("none.xml")
    with pytest.raises(fdiag.InputError, match="found a value of type `int`"):
        fdiag.MuJoCo(3)


def test_a_port_moves_what_it_says() -> None:
    assert "pivot" in scene().text()
    assert scene(ports=None, outputs=["angle"]).inputs == (fdiag.Channel("torque", "N m"),)


def test_a_run_that_diverges_is_silent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for speed in (1e307, 1e306):
        assert np.isnan(scene().simulate(np.zeros(20), initial={"pivot.qvel": speed})[-1]).all()
    said = capfd.readouterr()
    assert (said.out, said.err) == ("", "") and not list(tmp_path.iterdir())


CROWD = """
<mujoco><size memory="{memory}"/><worldbody><geom type="plane" size="9 9 1"/>{bodies}</worldbody></mujoco>
"""


def test_an_error_of_mujoco_is_a_run_that_diverges(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # MuJoCo writes its errors to a file where it runs.
    monkeypatch.chdir(tmp_path)
    ball = '<body pos="{x} 0 .1"><joint name="j{i}" type="slide" axis="0 0 1"/><geom size=".2"/></body>'
    bodies = "".join(ball.format(i=i, x=0.3 * i) for i in range(6))
    for memory in range(4000, 20000, 500):
        text = CROWD.format(memory=memory, bodies=bodies)
        model = mujoco.MjModel.from_xml_string(text)
        try:
            mujoco.mj_step(model, mujoco.MjData(model), 3)
        except mujoco.FatalError:
            break
    else:
        pytest.skip("this version of MuJoCo has room for everything")
    # It has no inputs: a run of three samples.
    crowd = fdiag.MuJoCo(text, outputs=["j0"], initial={f"j{i}": None for i in range(6)})
    assert np.isnan(crowd.simulate(np.empty((3, 0)))).all()


def test_a_joint_with_the_name_of_its_actuator() -> None:
    same = PENDULUM.replace('name="torque"', 'name="pivot"').replace('actuator="torque"', 'actuator="pivot"')
    edited = PENDULUM.replace('damping=".08"', 'damping=".083" frictionloss=".15"')
    log = real(edited, 300, 1)
    log["pivot"] = log.pop("torque")
    plant = fdiag.MuJoCo(same, outputs=OUTPUTS, uncertain=UNCERTAIN, ports="all")
    assert [c.name for c in plant.inputs] == ["pivot"]
    only = ["coulomb-friction@pivot_joint", "viscous-friction", "input-gain@pivot"]
    result = fdiag.gap(plant, log, only=only, most=1)
    assert result.causes[0].name == "coulomb-friction@pivot_joint", result.headline
    # As a native effect it may be asked for by the name in the scene.
    fdiag.MuJoCo(same, outputs=OUTPUTS, native="coulomb-friction@pivot")


def test_whole_turns_of_a_hinge_are_no_gap() -> None:
    def turning(seed: int) -> dict[str, np.ndarray]:
        model = mujoco.MjModel.from_xml_string(PENDULUM)
        data, random = mujoco.MjData(model), np.random.default_rng(seed)
        torque = np.repeat(random.uniform(2, 6, 30) * random.choice([-1, 1, 1], 30), 30)
        seen = np.empty((torque.size, 2))
        for k, u in enumerate(torque):
            seen[k] = data.qpos[0], data.qvel[0]
            data.ctrl[0] = u
            mujoco.mj_step(model, data)
        seen += random.standard_normal(seen.shape) * [0.002, 0.01]
        angle = (seen[:, 0] + np.pi) % (2 * np.pi) - np.pi
        return {"time": np.arange(torque.size) * 0.01, "torque": torque, "angle": angle, "rate": seen[:, 1]}

    log = turning(1)
    assert np.sum(np.abs(np.diff(log["angle"])) > 3) > 5, "it turns over"
    answer = fdiag.gap(scene(), log, held_out=turning(2), only=["coulomb-friction", "sensor-bias"])
    assert answer.verdict == "no-gap", answer.headline
    stated = scene(outputs=OUTPUTS | {"angle": fdiag.Output("rad", 0.002, wraps=False)})
    answer = fdiag.gap(stated, log, held_out=turning(2), only=["coulomb-friction", "sensor-bias"])
    assert "jumps by a turn" in answer.headline, answer.headline
