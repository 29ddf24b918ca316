"""Effects that a simulator has in itself: of an object, of a MuJoCo scene, and written back into MJCF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fdiag


class Slider:
    """A mass with dry friction of its own, which a step integrates finely and a held force does not."""

    sample_time = 0.05
    inputs = {"force": "N"}
    outputs = {"speed": fdiag.Output("m/s", 0.004)}
    parameters = {"m": fdiag.Uncertain(1.0, 0.02, "kg")}
    native_effects = {
        "dry": fdiag.Native("coulomb-friction", "rail", size=0.1, unit="N", bounds=(0.0, 10.0)),
        "oil": fdiag.Native("oil-drag", "gap", size=0.1, unit="N s/m", bounds=(0.0, 10.0), family="friction"),
    }
    ports = {"rail": fdiag.Port("N", velocity="speed")}

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        self.p, self.v = parameters, 0.0

    def measure(self, u: np.ndarray) -> float:
        return self.v

    def step(self, u: np.ndarray, f: np.ndarray) -> float:
        shown = self.v
        for _ in range(20):
            dry = self.p["dry"] * np.tanh(self.v / 0.01)
            self.v += 0.05 / 20 * (u[0] + f[0] - dry - self.p["oil"] * self.v) / self.p["m"]
        return shown


def pushes(samples: int, size: float, seed: int) -> np.ndarray:
    random = np.random.default_rng(seed)
    return np.repeat(random.uniform(-size, size, samples // 10 + 1), 10)[:samples]


def log_of(real: fdiag.Simulator, parameters: dict[str, float], seed: int) -> dict[str, np.ndarray]:
    u = pushes(300, 2.0, seed)
    y = real.simulate(u, parameters).ravel() + 0.004 * np.random.default_rng(seed).standard_normal(300)
    return {"time": np.arange(300) * 0.05, "force": u, "speed": y}


def stated(**more: Any) -> fdiag.Steps:
    keys = ("sample_time", "inputs", "outputs", "parameters", "ports", "native_effects")
    return fdiag.Steps(Slider, **({key: getattr(Slider, key) for key in keys} | more))


def test_an_effect_of_an_object_is_tried_and_is_one_with_that_of_the_library() -> None:
    # The real one has its friction as a parameter like any other.
    fixed = {"m": 1.0, "dry": 0.0, "oil": 0.0}
    real = stated(native_effects=None, parameters={**fixed, "dry": fdiag.Uncertain(0.3, 0.0, "N")})
    result = fdiag.gap(Slider(), log_of(real, {"m": 1.01}, 5), most=1)
    assert result.causes[0].name == "coulomb-friction@rail", result.headline
    assert result.causes[0].law == "native"
    assert [c.name for c in result.causes].count("coulomb-friction@rail") == 1
    found = result.causes[0].parameters[0]
    assert abs(found.value - 0.3) < 4.0 * found.standard_error
    # The patched one hands it on.
    assert abs(result.patched().simulate([1.0] * 5)[-1, 0] - real.simulate([1.0] * 5)[-1, 0]) < 0.01


def test_a_place_that_is_no_port_is_a_part() -> None:
    real = stated(native_effects=None, parameters={"m": 1.0, "dry": 0.0, "oil": fdiag.Uncertain(0.8, 0.0)})
    only = ["oil-drag", "input-gain", "coulomb-friction"]
    result = fdiag.gap(Slider(), log_of(real, {}, 6), only=only, most=1, thorough=True)
    first = result.to_dict()["diagnosis"]["causes"][0]
    assert (first["label"], first["site"]) == ("oil-drag", {"kind": "part", "name": "gap"})
    assert result.causes[0].family == "friction"
    asked = fdiag.gap(Slider(), log_of(real, {}, 6), only=["oil-drag@gap"], most=1, thorough=True)
    assert [cause.name for cause in asked.causes] == ["oil-drag@gap"]


class Motor(Slider):
    """The same, whose motor may give no more than the inverse of a parameter."""

    native_effects = {
        "motor/force.limit": fdiag.Native(
            "force-limit", "motor", size=0.5, unit="1/N", bounds=(0.0, 50.0), family="limit", reciprocal=True
        )
    }

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        self.most = 1.0 / max(parameters["motor/force.limit"], 1e-9)
        super().reset({"m": parameters["m"], "dry": 0.0, "oil": 0.5}, x0)

    def step(self, u: np.ndarray, f: np.ndarray) -> float:
        return super().step(np.clip(u, -self.most, self.most), f)


def test_a_limit_may_be_called_as_it_likes() -> None:
    keys = ("sample_time", "inputs", "outputs", "ports")
    settings = {key: getattr(Motor, key) for key in keys}
    limit = fdiag.Uncertain(0.8, 0.0, "1/N")
    real = fdiag.Steps(Motor, parameters={"m": 1.0, "motor/force.limit": limit}, **settings)
    only = ["force-limit", "input-gain", "viscous-friction"]
    result = fdiag.gap(Motor(), log_of(real, {}, 9), only=only, most=1, thorough=True)
    assert (result.verdict, result.causes[0].name) == ("cause", "force-limit@motor"), result.headline
    assert "1.25" in result.headline and not result.to_dict()["diagnosis"]["not_tested"]


@pytest.mark.parametrize(
    ("native", "message"),
    [
        (fdiag.Native("Dry friction", "rail", size=1.0), "native_effects.dry.label: expected a word of small letters"),
        (fdiag.Native("dry", " ", size=1.0), "native_effects.dry.place: expected a port, an input"),
        (fdiag.Native("dry", "rail"), "native_effects.dry.size: expected a change .* found none, and a value of 0"),
        (fdiag.Native("dry", "rail", 1.0, bounds=(2.0, 3.0)), "native_effects.dry.bounds: expected bounds around"),
        ({"label": "dry", "place": "rail", "tolerance": 0.1}, "native_effects.dry: .*found `tolerance`"),
    ],
)
def test_what_is_wrong_is_said(native: Any, message: str) -> None:
    with pytest.raises(fdiag.InputError, match=message):
        stated(native_effects={"dry": native})


def test_names_are_unique() -> None:
    with pytest.raises(fdiag.InputError, match="native_effects.m: expected a name that no parameter has"):
        stated(native_effects={"m": fdiag.Native("dry", "rail", size=1.0)})
    twice = {name: fdiag.Native("dry", "rail", size=1.0) for name in ("a", "b")}
    with pytest.raises(fdiag.InputError, match="every label once at a place"):
        stated(native_effects=twice)


PENDULUM = """
<mujoco model="pendulum">
  <option timestep="0.01" integrator="implicitfast"/>
  <worldbody>
    <body name="rod">
      <joint name="pivot" axis="0 1 0" damping=".08" armature=".01"/>
      <geom name="stick" type="capsule" fromto="0 0 0 0 0 -.5" size=".02" mass="1"/>
    </body>
  </worldbody>
  <actuator><motor name="torque" joint="pivot" ctrlrange="-3 3"/></actuator>
  <sensor><jointpos name="angle" joint="pivot"/><jointvel name="rate" joint="pivot"/></sensor>
</mujoco>
"""
LEG = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1"/>
    <body name="leg" pos="0 0 .1"><joint name="height" type="slide" axis="0 0 1"/><geom name="foot" size=".1" mass="1"/></body>
  </worldbody>
  <sensor><jointpos name="height" joint="height"/></sensor>
</mujoco>
"""
OUTPUTS = {"angle": fdiag.Output("rad", 0.002), "rate": fdiag.Output("rad/s", 0.01)}


def scene(text: Any = PENDULUM, **settings: Any) -> fdiag.MuJoCo:
    pytest.importorskip("mujoco")
    asked = {"outputs": OUTPUTS, "uncertain": {"body/rod.mass": 0.02}, "ports": "all"} | settings
    return fdiag.MuJoCo(text, **asked)


def run(text: str, u: np.ndarray) -> np.ndarray:
    """By MuJoCo alone."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    y = np.empty((len(u), 2))
    for k, torque in enumerate(u):
        y[k] = data.qpos[0], data.qvel[0]
        data.ctrl[0] = torque
        mujoco.mj_step(model, data)
    return y


def log(text: str, seed: int, command: Any = None, shown: Any = None) -> dict[str, np.ndarray]:
    """A log of an edited scene, with a wrapped command, or with sensors that show something else."""
    # From rest: a delay line is taken to hold what there was before.
    u = np.concatenate([np.zeros(10), pushes(290, 1.5, seed)])
    y = run(text, u if command is None else command(u))
    y = (y if shown is None else shown(y)) + np.random.default_rng(seed).standard_normal(y.shape) * [0.002, 0.01]
    return {"time": np.arange(len(u)) * 0.01, "torque": u, "angle": y[:, 0], "rate": y[:, 1]}


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    ("change", "name", "value"),
    [
        (('damping=".08"', 'damping=".08" frictionloss=".1"'), "coulomb-friction@pivot", 0.1),
        (('damping=".08"', 'damping=".2"'), "viscous-friction@pivot", 0.12),
        (('armature=".01"', 'armature=".05"'), "armature@pivot", 0.04),
    ],
)
def test_a_change_of_a_scene_is_found_and_written_back(
    change: tuple[str, str], name: str, value: float, seed: int, tmp_path: Path
) -> None:
    edited = PENDULUM.replace(*change)
    result = fdiag.gap(scene(), log(edited, seed), exclude=["map"], most=1)
    assert (result.verdict, result.causes[0].name, result.causes[0].law) == ("cause", name, "native")
    found = result.causes[0].parameters[0]
    # Fits with few runs stop a few errors short.
    assert abs(found.value - value) < 4.0 * found.standard_error + 0.01 * value
    written = result.write_mjcf(tmp_path / "better.xml")
    assert (written.written, written.remaining) == ((name,), ())
    # What is written is what was found, to the digits of a text, and near to reality.
    u = pushes(300, 1.5, 2)
    y = run(written.path.read_text(), u)
    assert np.allclose(y, result.patched().simulate(u), rtol=1e-4, atol=1e-5)
    errors = [np.sqrt(np.mean((run(text, u) - run(edited, u)) ** 2)) for text in (PENDULUM, written.path.read_text())]
    assert errors[1] < 0.1 * errors[0]


def test_a_delay_is_written_and_a_sensor_remains(tmp_path: Path) -> None:
    late = log(PENDULUM, 3, command=lambda u: np.concatenate([np.zeros(3), u[:-3]]))
    result = fdiag.gap(scene(), late, exclude=["map"], most=1)
    assert result.causes[0].name == "input-delay@torque", result.headline
    written = result.write_mjcf(tmp_path / "late.xml")
    assert written.written == ("input-delay@torque",)
    u = np.concatenate([np.zeros(10), pushes(290, 1.5, 4)])
    apart = np.abs(run(written.path.read_text(), u) - result.patched().simulate(u)).max()
    assert apart < 0.3 * np.abs(run(PENDULUM, u) - result.patched().simulate(u)).max()
    biased = fdiag.gap(scene(), log(PENDULUM, 5, shown=lambda y: y + [0.05, 0.0]), exclude=["map"], most=1)
    written = biased.write_mjcf(tmp_path / "biased.xml")
    assert (written.written, written.remaining) == ((), ("sensor-bias@angle",))


def test_what_is_tried_can_be_chosen() -> None:
    text = scene(uncertain={}).text()
    assert all(f"joint_pivot_{field}_inside" in text for field in ("damping", "frictionloss", "stiffness"))
    # One body alone touches nothing.
    assert "body_rod_mass_inside" in text and "geom_stick_friction" not in text
    # A parameter is no effect as well.
    assert scene().text().count("body_rod_mass_inside =") == 1
    few = scene(native=["armature", "coulomb-friction@pivot"]).text()
    assert "joint_pivot_armature" in few and "joint_pivot_damping" not in few
    assert "joint_pivot" not in scene(native=None).text()
    with pytest.raises(fdiag.InputError, match="native: the scene has no effect `armatur`, did you mean `armature`"):
        scene(native="armatur")


def test_a_geom_has_three_frictions() -> None:
    text = LEG.replace('size=".1" mass="1"', 'size=".1" mass="1" condim="6"')
    asked = scene(text, outputs={"height": fdiag.Output("m", 0.001)}, uncertain={}).text()
    for label in ("friction", "contact_torsion", "contact_rolling"):
        assert f"geom_foot_{label}_inside" in asked, asked


def test_only_a_scene_of_a_file_or_text_is_written(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    of_model = fdiag.gap(
        scene(mujoco.MjModel.from_xml_string(PENDULUM)), log(PENDULUM, 7), only=["input-gain"], most=1
    )
    with pytest.raises(fdiag.Error, match="expected a scene that was given as a file or a text, found an MjModel"):
        of_model.write_mjcf(tmp_path / "none.xml")
    other = fdiag.gap(Slider(), log_of(stated(), {}, 8), only=["input-gain"], most=1)
    with pytest.raises(fdiag.Error, match="expected the result of a scene"):
        other.write_mjcf(tmp_path / "none.xml")


BOX = """
<mujoco model="slide and box">
  <option timestep="0.01" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1" friction=".4"/>
    <body name="pusher" pos="-2 0 .1">
      <joint name="slide" type="slide" axis="1 0 0" damping="2"/>
      <geom name="plate" type="box" size=".02 .1 .08" mass=".5"/>
    </body>
    <body name="box" pos="0 0 .099">
      <freejoint name="float"/>
      <geom name="crate" type="box" size=".1 .1 .1" mass="1" friction=".4"/>
    </body>
  </worldbody>
  <actuator><motor name="push" joint="slide"/></actuator>
  <sensor><jointpos name="way" joint="slide"/><jointvel name="speed" joint="slide"/></sensor>
</mujoco>
"""


def test_a_free_body_is_no_state_that_can_be_set() -> None:
    mujoco = pytest.importorskip("mujoco")
    outputs = {"way": fdiag.Output("m", 0.001), "speed": fdiag.Output("m/s", 0.005)}
    scene = fdiag.MuJoCo(BOX, outputs=outputs, ports="all")
    # Bodies that touch each other have a friction between them.
    assert "geom_crate_friction_inside" in scene.text() and "geom_floor_friction_inside" in scene.text()
    # Whole runs and steps are those of the scene, whatever the free body does.
    model = mujoco.MjModel.from_xml_string(BOX)
    data, u = mujoco.MjData(model), np.concatenate([np.full(80, 12.0), np.zeros(40)])
    y = np.empty((120, 2))
    for k in range(120):
        y[k] = data.qpos[0], data.qvel[0]
        data.ctrl[0] = u[k]
        mujoco.mj_step(model, data)
    assert data.qpos[1] > 0.01, "the box was pushed"
    assert np.array_equal(scene.simulate(u), y) and np.array_equal(scene.simulate(u), y)
    checked = fdiag.check(scene, samples=60)
    assert not [f for f in checked.findings if f.what in ("repeatability", "steps") and f.grade == "broken"]
