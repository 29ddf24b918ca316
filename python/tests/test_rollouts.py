"""Functions that make many whole runs at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fdiag

SAID: dict[str, Any] = {
    "inputs": {"force": "N"},
    "outputs": {"speed": fdiag.Output("m/s", 0.004)},
    "parameters": {"m": fdiag.Uncertain(1.2, 0.03, "kg"), "d": fdiag.Uncertain(1.5, 0.1, "N s/m")},
    "initial": {"v": fdiag.Initial(0.0, None, "m/s")},
    "sample_time": 0.01,
}
ONLY = ["input-gain", "input-delay", "sensor-bias"]


def cart(p: dict[str, np.ndarray], x0: dict[str, np.ndarray], u: np.ndarray) -> np.ndarray:
    """Runs of the cart, `u` and the outputs `[runs, samples, 1]`."""
    # The function of libm, not that of numpy for arrays: to the bit, whatever the number of runs.
    decay = np.array([float(np.exp(float(x))) for x in -p["d"] / p["m"] * 0.01])
    y, v = np.empty(u.shape), np.array(x0["v"])
    for k in range(u.shape[1]):
        aim = u[:, k, 0] / p["d"]
        y[:, k, 0], v = v, aim + (v - aim) * decay
    return y


def one_by_one() -> fdiag.Rollout:
    def alone(p: dict[str, float], x0: dict[str, float], u: np.ndarray) -> np.ndarray:
        stacked = [{name: np.array([value]) for name, value in of.items()} for of in (p, x0)]
        return cart(*stacked, u[None])[0]

    return fdiag.rollout(**SAID)(alone)


def test_stacked_runs_give_the_answer_of_single_ones(short: dict[str, np.ndarray]) -> None:
    calls: list[int] = []

    def counted(p: dict[str, np.ndarray], x0: dict[str, np.ndarray], u: np.ndarray) -> np.ndarray:
        calls.append(len(u))
        assert all(value.shape == (len(u),) for value in [*p.values(), *x0.values()])
        return cart(p, x0, u)

    stacked, alone = fdiag.rollout(**SAID, vectorised=True)(counted), one_by_one()
    y = alone.simulate(0.8 * short["force [N]"])
    y += 0.004 * np.random.default_rng(1).standard_normal(y.shape)
    log = {**short, "speed [m/s]": y.ravel()}
    answers = [fdiag.gap(s, log, only=ONLY, most=1) for s in (stacked, alone)]
    first, second = ({k: v for k, v in a.to_dict().items() if k not in ("timing", "models", "inputs")} for a in answers)
    assert first == second
    assert answers[0].causes[0].label == "input-gain"
    # Every run was in a call, and some calls made many.
    work = answers[0].work
    assert work is not None and sum(calls) >= work.made and max(calls) >= 8


def test_a_run_that_depends_on_its_neighbours_is_found() -> None:
    @fdiag.rollout(**SAID, vectorised=True)
    def mixed(p: dict[str, np.ndarray], x0: dict[str, np.ndarray], u: np.ndarray) -> np.ndarray:
        return cart({**p, "d": np.full_like(p["d"], p["d"].mean())}, x0, u)

    found = fdiag.check(mixed, samples=50)
    assert [f.what for f in found.doubts if f.grade == "broken"] == ["several runs at once"], str(found)
    right = fdiag.rollout(**SAID, vectorised=True)(cart)
    assert not fdiag.check(right, samples=50).is_broken


def test_one_run_that_diverges_leaves_the_others_alone(short: dict[str, np.ndarray]) -> None:
    def narrow(p: dict[str, np.ndarray], x0: dict[str, np.ndarray], u: np.ndarray) -> np.ndarray:
        y = cart(p, x0, u)
        y[p["m"] > 1.26] = np.nan
        return y

    def raising(p: dict[str, np.ndarray], x0: dict[str, np.ndarray], u: np.ndarray) -> np.ndarray:
        if (p["m"] > 1.26).any():
            raise fdiag.Diverged("too heavy")
        return cart(p, x0, u)

    log = {**short, "speed [m/s]": one_by_one().simulate(0.8 * short["force [N]"]).ravel()}
    for function in (narrow, raising):
        result = fdiag.gap(fdiag.rollout(**SAID, vectorised=True)(function), log, only=ONLY, most=1)
        assert result.causes[0].label == "input-gain", result.headline


def test_a_wrong_shape_says_which_was_expected(short: dict[str, np.ndarray]) -> None:
    @fdiag.rollout(**SAID, vectorised=True)
    def flat(p: dict[str, np.ndarray], x0: dict[str, np.ndarray], u: np.ndarray) -> np.ndarray:
        return cart(p, x0, u)[0, :3]

    with pytest.raises(fdiag.SimulatorError, match=r"expected an array of shape \[1, 5, 1\]: runs, samples, outputs"):
        flat.simulate(np.ones(5))


def test_steps_through_a_log_do_not_cost_a_run_each() -> None:
    calls = []

    @fdiag.rollout(inputs=["u"], outputs={"y": fdiag.Output("m", 0.01)}, sample_time=0.1, parameters={"k": fdiag.Uncertain(2.0, 0.05)})
    def lag(parameters: dict[str, float], x0: dict[str, float], u: np.ndarray) -> np.ndarray:
        calls.append(len(u))
        x, y = 0.0, np.empty((len(u), 1))
        for k, now in enumerate(u[:, 0]):
            y[k] = x
            x += 0.1 * parameters["k"] * (now - x)
        return y

    random = np.random.default_rng(5)
    n = 400
    u = random.uniform(-1.0, 1.0, n)
    y = lag.simulate(0.8 * u).ravel() + 0.01 * random.standard_normal(n)
    calls.clear()
    result = fdiag.gap(lag, {"time": 0.1 * np.arange(n), "u": u, "y": y}, most=1, threads=1)
    # Before and behind a linear plant a gain is the same.
    assert result.causes[0].name in ("input-gain@u", "sensor-scale@y")
    # A run for each of 400 steps, even once, would be 200 logs' worth beyond this.
    assert result.work is not None and sum(calls) < 500 * n, (len(calls), sum(calls) / n)


def test_friction_is_found_with_a_few_whole_runs(short: dict[str, np.ndarray]) -> None:
    """A force that depends on the motion, on a function that makes whole runs."""
    said = {**SAID, "ports": {"rail": {"unit": "N", "velocity": "speed"}}}

    @fdiag.rollout(**said)
    def pushed(p: dict[str, float], x0: dict[str, float], u: np.ndarray, f: np.ndarray) -> np.ndarray:
        decay = np.exp(-p["d"] / p["m"] * 0.01)
        y, v = np.empty(len(u)), x0["v"]
        for k, force in enumerate(u[:, 0] + f[:, 0]):
            aim = force / p["d"]
            y[k], v = v, aim + (v - aim) * decay
        return y[:, None]

    only = ["coulomb-friction", "viscous-friction", "input-gain", "constant-load"]
    answer = fdiag.gap(pushed, short, only=only, most=1)
    assert answer.causes[0].label == "coulomb-friction" and answer.causes[0].probability > 0.9
    # Many of them are of a part of the log, as those that settle where a forecast begins.
    assert answer.work is not None and answer.work.steps < 150 * 400, answer.work
