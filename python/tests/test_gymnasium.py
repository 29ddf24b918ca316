"""Environments as simulators; the log is made by a loop that knows nothing of this package."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fdiag

gym = pytest.importorskip("gymnasium")

SAID: dict[str, Any] = {
    "inputs": {"force": "N"},
    "outputs": {"x": fdiag.Output("m", 0.002), "v": fdiag.Output("m/s", 0.005)},
    "uncertain": {"mass": fdiag.Uncertain(1.0, 0.05, "kg"), "drag": 0.1},
}


class Sled(gym.Env):  # type: ignore[misc, name-defined]
    """A sled on ice that begins anywhere, and ends at a wall."""

    metadata: dict[str, Any] = {}
    tau = 0.02
    wall = 100.0

    def __init__(self) -> None:
        self.action_space = gym.spaces.Box(-5.0, 5.0, (1,), np.float64)
        self.observation_space = gym.spaces.Box(-np.inf, np.inf, (2,), np.float64)
        self.mass, self.drag = 1.0, 0.5
        self.state = np.zeros(2)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.state = self.np_random.uniform(-0.1, 0.1, 2)
        return self.state.copy(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        x, v = self.state
        for _ in range(4):
            v += 0.005 * (float(action[0]) - self.drag * v) / self.mass
            x += 0.005 * v
        self.state = np.array([x, v])
        return self.state.copy(), 0.0, abs(x) > self.wall, False, {}


def excitation(samples: int, size: float) -> np.ndarray:
    return np.repeat(np.random.default_rng(2).uniform(-size, size, samples // 15 + 1), 15)[:samples]


def real(env: Any, u: np.ndarray, late: int) -> np.ndarray:
    """Observations of an environment of which the action comes late."""
    env.reset(seed=0)
    seen, told = [], np.concatenate([np.full(late, u[0]), u])[: len(u)]
    for action in told:
        seen.append(env.unwrapped.shown())
        env.step(np.array([action]))
    return np.array(seen)


class Seen(Sled):
    """The real sled: at rest, and seen."""

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.state = np.zeros(2)
        return self.state.copy(), {}

    def shown(self) -> np.ndarray:
        return self.state.copy()


def test_a_delay_of_the_action_is_named() -> None:
    sled = fdiag.Gymnasium(Sled(), **SAID, initial={"x0": 0.0, "v0": 0.0})
    assert sled.sample_time == 0.02 and sled.name == "Sled"
    u = excitation(300, 4.0)
    y = real(Seen(), u, late=3)
    y += np.random.default_rng(5).standard_normal(y.shape) * [0.002, 0.005]
    log = {"time": 0.02 * np.arange(300), "force": u, "x": y[:, 0], "v": y[:, 1]}
    only = ["input-delay", "input-gain", "sensor-bias", "input-lag"]
    result = fdiag.gap(sled, log, only=only, most=1)
    assert result.causes[0].name == "input-delay@force", result.headline
    delay = result.causes[0].parameters[0]
    assert delay.unit == "s" and abs(delay.value - 0.06) < 0.01


def test_starts_are_set_and_parameters_reach_the_environment() -> None:
    sled = fdiag.Gymnasium(Sled, **SAID, initial={"x0": 0.0, "v0": 0.0})
    u = np.ones(3)
    assert sled.simulate(u, initial={"x0": 2.0, "v0": 1.0})[0].tolist() == [2.0, 1.0]
    light, heavy = (sled.simulate(u, {"mass": mass})[-1, 1] for mass in (1.0, 4.0))
    assert light > 3.0 * heavy > 0.0
    found = fdiag.check(sled, samples=60)
    assert found.grade == "fine", str(found)


def test_the_noise_of_a_reset_is_the_same_in_each_run() -> None:
    first = fdiag.Gymnasium(Sled(), **SAID).simulate(np.ones(4))
    again = fdiag.Gymnasium(Sled(), **SAID).simulate(np.ones(4))
    other = fdiag.Gymnasium(Sled(), **SAID, seed=1).simulate(np.ones(4))
    assert (first == again).all() and first[0, 0] != 0.0 and (first[0] != other[0]).all()
    assert not fdiag.check(fdiag.Gymnasium(Sled(), **SAID), samples=40).is_broken


def test_a_run_ends_where_the_environment_says_so() -> None:
    class Close(Sled):
        wall = 0.05

    u = np.full(40, 5.0)
    start: dict[str, Any] = {"initial": {"x0": 0.0, "v0": 0.0}}
    y = fdiag.Gymnasium(Close, **SAID, **start).simulate(u)
    last = int(np.flatnonzero(np.isfinite(y[:, 0]))[-1])
    # The sample that is beyond the wall is none.
    assert last < 39 and y[last, 0] < 0.05 < y[last, 0] + 0.02 * y[last, 1] + 0.002
    assert np.isnan(y[last + 1 :]).all()
    assert np.isfinite(fdiag.Gymnasium(Close, **SAID, **start, ignore_terminated=True).simulate(u)).all()


def test_pendulum_by_its_id() -> None:
    said: dict[str, Any] = {
        "inputs": {"torque": "N m"},
        "outputs": [None, "sine", "rate"],
        "uncertain": {"m": 0.05, "l": 0.02},
        "initial": {"angle": fdiag.Initial(0.5, 0.01, "rad"), "speed": fdiag.Initial(0.0, 0.01, "rad/s")},
    }
    pendulum = fdiag.Gymnasium("Pendulum-v1", **said)
    assert pendulum.sample_time == 0.05 and pendulum.name == "Pendulum"
    # Beyond its limit of 200 steps, as long as a log is.
    y = pendulum.simulate(np.zeros(300))
    assert y.shape == (300, 2) and np.isfinite(y).all() and abs(y[0, 0] - np.sin(0.5)) < 1e-6
    found = fdiag.check(pendulum, samples=100)
    # Its observations are in single precision.
    assert [f.what for f in found.doubts] == ["precision"], str(found)


def test_wrappers_are_seen_and_discrete_actions_rounded() -> None:
    env = gym.wrappers.RescaleAction(Sled(), -1.0, 1.0)
    start: dict[str, Any] = {"initial": {"x0": 0.0, "v0": 0.0}}
    plain = fdiag.Gymnasium(Sled(), **SAID, **start).simulate(np.full(5, 5.0))
    assert np.allclose(fdiag.Gymnasium(env, **SAID, **start).simulate(np.ones(5)), plain)
    cart = fdiag.Gymnasium("CartPole-v1", ignore_terminated=True, initial=["x", "v", "angle", "rate"])
    assert [c.name for c in cart.inputs] == ["action"] and cart.sample_time == 0.02
    left, right = cart.simulate([0.2, 0.2]), cart.simulate([0.8, 0.8])
    assert left[1, 1] < 0.0 < right[1, 1]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"uncertain": {"mas": 0.1}}, "has no number `mas`, did you mean `mass`"),
        ({"inputs": ["a", "b"]}, "inputs: expected 1 names, one per entry of the action, found 2"),
        ({"outputs": ["x"]}, "outputs: expected 2 names"),
        ({"initial": ["x0"]}, "initial: expected 2 names, the numbers of the attribute `state`, found 1"),
        ({"env": "Pendulm-v1"}, "expected the id of an environment, found `Pendulm-v1`"),
        ({"env": 3}, "found a value of type `int`"),
        ({"workers": 2}, "workers: expected 1 for a single environment"),
    ],
)
def test_what_is_said_of_an_environment_is_checked(change: dict[str, Any], message: str) -> None:
    asked = {**SAID, **change}
    with pytest.raises(fdiag.InputError, match=message):
        fdiag.Gymnasium(asked.pop("env", Sled()), **asked)


def sleds(count: int, made: Any = Sled) -> Any:
    return gym.vector.SyncVectorEnv([made] * count)


class Counted:
    """A vector of sleds that counts its calls."""

    def __new__(cls, count: int) -> Any:
        env = sleds(count)
        stepped, env.calls = env.step, 0

        def step(actions: np.ndarray) -> Any:
            env.calls += 1
            return stepped(actions)

        env.step = step
        return env


def test_a_vector_of_environments_is_each_of_them() -> None:
    start: dict[str, Any] = {"initial": {"x0": 0.0, "v0": 0.0}}
    u = excitation(80, 4.0)
    for runs in (1, 5):
        one = fdiag.Gymnasium(Sled(), **SAID, **start)
        many = fdiag.Gymnasium(sleds(runs), **SAID, **start)
        for mass in (0.9, 1.0, 1.2):
            assert (one.simulate(u, {"mass": mass}) == many.simulate(u, {"mass": mass})).all()
        assert not fdiag.check(many, samples=60).is_broken


def test_a_vector_of_environments_is_stepped_in_one_call() -> None:
    start: dict[str, Any] = {"initial": {"x0": 0.0, "v0": 0.0}}
    u = excitation(300, 4.0)
    y = real(Seen(), u, late=3)
    y += np.random.default_rng(5).standard_normal(y.shape) * [0.002, 0.005]
    log = {"time": 0.02 * np.arange(300), "force": u, "x": y[:, 0], "v": y[:, 1]}
    only = ["input-delay", "input-gain", "sensor-bias", "input-lag"]
    answers, calls = [], []
    for env in (Counted(1), Counted(8)):
        result = fdiag.gap(fdiag.Gymnasium(env, **SAID, **start), log, only=only, most=1)
        answers.append((result.verdict, result.causes[0].name, result.causes[0].parameters[0].value))
        calls.append(env.calls)
    assert answers[0][:2] == answers[1][:2] and answers[0][1] == "input-delay@force"
    assert answers[0][2] == pytest.approx(answers[1][2], rel=1e-6)
    assert calls[1] < calls[0], calls


def test_one_environment_that_ends_does_not_touch_the_others() -> None:
    class Close(Sled):
        wall = 0.05

    start: dict[str, Any] = {"initial": {"x0": 0.0, "v0": 0.0}}
    u = np.full(40, 5.0)
    one = fdiag.Gymnasium(Close, **SAID, **start).simulate(u)
    many = fdiag.Gymnasium(sleds(4, Close), **SAID, **start).simulate(u)
    np.testing.assert_array_equal(one, many)
    with pytest.raises(fdiag.InputError, match="autoreset_mode"):
        fdiag.Gymnasium(sleds(2), **SAID, ignore_terminated=True)
