"""What to run next."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import CART

import fdiag

ONLY = ["coulomb-friction", "constant-load"]


def rubbed(u: np.ndarray, seed: int) -> np.ndarray:
    """Speeds of a cart with dry friction of 0.4 N, in small steps of Euler's."""
    v, y = 0.0, []
    for force in u:
        y.append(v)
        for _ in range(10):
            friction = 0.4 * np.sign(v) if v else np.clip(force, -0.4, 0.4)
            v += 0.001 * (force - 1.5 * v - friction) / 1.2
    return np.array(y) + 0.004 * np.random.default_rng(seed).standard_normal(len(u))


def forward() -> dict[str, np.ndarray]:
    """A log of a cart that never turns round."""
    t = np.arange(300) * 0.01
    u = 2.0 + 3.5 * np.cos(12.0 * t)
    return {"time": t, "force": u, "speed": rubbed(u, 1)}


@pytest.fixture(scope="module")
def tied() -> fdiag.Result:
    """While the cart goes forward, dry friction and a constant load are one."""
    return fdiag.gap(CART, forward(), only=ONLY, most=1)


def test_causes_that_a_step_cannot_tell_apart_get_an_input_that_does(tied: fdiag.Result) -> None:
    assert tied.verdict == "tied", tied.headline
    plan = fdiag.next_experiment(tied)
    assert plan is not None and plan.is_enough and plan.distance > 9.0 > plan.now
    assert plan.statement.startswith("run ") and len(plan.between) == 2
    assert set(plan.signals) == {"time", "force"} and plan.units == {"force": "N"}
    assert plan.sample_time == 0.01 and np.allclose(np.diff(plan.signals["time"]), 0.01)
    assert plan.sensor is None and plan.faster == 1


def test_the_new_log_does_tell_them_apart(tied: fdiag.Result) -> None:
    plan = fdiag.next_experiment(tied)
    assert plan is not None
    u = plan.signals["force"]
    new = {"time": plan.signals["time"], "force": u, "speed": rubbed(u, 2)}
    found = fdiag.gap(CART, [forward(), new], only=ONLY, most=1)
    assert found.verdict == "cause" and found.causes[0].name == "coulomb-friction@rail", found.headline


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_it_is_a_frame(tied: fdiag.Result, library: str) -> None:
    pytest.importorskip(library)
    plan = fdiag.next_experiment(tied)
    assert plan is not None
    frame = plan.to_frame(library)
    assert list(frame.columns) == ["time [s]", "force [N]"] and len(frame) == len(plan.signals["force"])


def test_a_clear_answer_needs_none(quick: dict[str, str]) -> None:
    clear = fdiag.gap(quick["model"], quick["monday"], only=["coulomb-friction"], most=1)
    assert clear.verdict == "cause" and fdiag.next_experiment(clear) is None
