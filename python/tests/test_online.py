"""Pipelines from specs."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import ROOT, columns

import fdiag

MODEL = str(ROOT / "examples" / "turbine.toml")
SPEC = """
generator = { kind = "observer", rate = 2.0 }
bias.orders = { kind = "fixed", na = 2, nb = 3 }
detector = { kind = "maximum", margin = 0.1 }
"""


@pytest.fixture(scope="module")
def log() -> dict[str, np.ndarray]:
    return columns(str(ROOT / "examples" / "turbine-run.csv"))


@pytest.fixture(scope="module")
def trained(log: dict[str, np.ndarray]) -> fdiag.Trained:
    # The drift begins at 40 s.
    return fdiag.spec(MODEL, {name: values[:400] for name, values in log.items()}, SPEC)


def signals(log: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return log["wf [kg/s]"], np.stack([log["N [rpm]"], log["T_7 [K]"]], axis=1)


def test_a_drift_is_found_and_nothing_before(trained: fdiag.Trained, log: dict[str, np.ndarray]) -> None:
    assert [c.name for c in trained.outputs] == ["N", "T_7"] and abs(trained.sample_time - 0.1) < 1e-12
    run = trained.pipeline().run(*signals(log))
    assert run.residual.shape == (len(log["wf [kg/s]"]), 2)
    alarm = run.first_alarm()
    assert alarm is not None and 400 <= alarm < 480


def test_steps_and_runs_give_the_same_bits(trained: fdiag.Trained, log: dict[str, np.ndarray]) -> None:
    u, y = signals(log)
    run, pipeline = trained.pipeline().run(u, y), trained.pipeline()
    for k in range(200):
        step = pipeline.step([u[k]], {"N": y[k, 0], "T_7": y[k, 1]})
        assert np.array_equal(step.compensated, run.compensated[k])
        assert step.statistic == run.statistic[k] and step.is_alarm == run.alarm[k]


def test_a_snapshot_goes_on_to_the_bit(trained: fdiag.Trained, log: dict[str, np.ndarray]) -> None:
    u, y = signals(log)
    whole = trained.pipeline().run(u, y)
    first, second = trained.pipeline(), trained.pipeline()
    first.run(u[:300], y[:300])
    second.restore(first.snapshot())
    assert np.array_equal(second.run(u[300:], y[300:]).statistic, whole.statistic[300:])
    second.reset()
    assert np.array_equal(second.run(u, y).statistic, whole.statistic)
    with pytest.raises(fdiag.InputError):
        second.restore("{}")


def test_missing_samples_are_refused_or_held(trained: fdiag.Trained, log: dict[str, np.ndarray]) -> None:
    u, y = signals(log)
    y = y.copy()
    y[100, 0] = np.nan
    run = trained.pipeline().run(u, y)
    assert run.refused[100] and run.refused.sum() == 1 and np.isnan(run.residual[100]).all()
    with pytest.raises(fdiag.InputError):
        trained.pipeline().step(u[:1], [np.nan, 900.0])
    healthy = {name: values[:400] for name, values in log.items()}
    held = fdiag.spec(MODEL, healthy, SPEC + "hold_missing = 2\n").pipeline().run(u, y)
    assert not held.refused.any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"description": 'generator = { kind = "observr" }'}, "observer"),
        ({"model": "none.toml"}, "none.toml: expected a file of text"),
        ({"healthy": {"t": [0.0, 1.0], "wf": [1.0, 2.0], "N": [1.0, 2.0]}}, "no column `T_7`"),
        ({"learn_share": 1.5}, "learn_share"),
    ],
)
def test_what_is_wrong_is_said(log: dict[str, np.ndarray], change: dict[str, object], message: str) -> None:
    asked = {"model": MODEL, "healthy": log, "description": SPEC} | change
    with pytest.raises(fdiag.InputError, match=message):
        fdiag.spec(**asked)  # type: ignore[arg-type]


def test_shapes_are_checked(trained: fdiag.Trained) -> None:
    with pytest.raises(fdiag.InputError, match=r"y: expected an array of shape \[samples, 2\]"):
        trained.pipeline().run(np.zeros(5), np.zeros(5))
    with pytest.raises(fdiag.InputError, match="5 rows"):
        trained.pipeline().run(np.zeros(4), np.zeros((5, 2)))
    with pytest.raises(fdiag.InputError, match="no `T_7`"):
        trained.pipeline().step([0.2], {"N": 1.0, "T7": 2.0})
