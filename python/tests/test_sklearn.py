"""Estimators in the manner of scikit-learn, by its own checks."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from conftest import CART, ROOT

import fdiag

pytest.importorskip("sklearn")

from fdiag.sklearn import CompensatedRegressor, GapRegressor  # noqa: E402
from sklearn.base import clone  # noqa: E402
from sklearn.model_selection import GridSearchCV, TimeSeriesSplit  # noqa: E402
from sklearn.utils.estimator_checks import check_estimator  # noqa: E402

SIMULATES = "it simulates: a row is predicted from the rows before it"
FEW = "some 10 rows for up to 22 parameters of a difference equation: refused, or unstable and refused"
#: Checks of scikit-learn that ask for what a simulation cannot have, or for an answer from too little.
NOT_FOR_IT = {
    "check_estimators_dtypes": FEW,
    "check_estimators_nan_inf": FEW,
    "check_n_features_in_after_fitting": FEW,
    "check_regressor_multioutput": FEW,
    "check_regressors_no_decision_function": FEW,
    "check_methods_sample_order_invariance": SIMULATES,
    "check_methods_subset_invariance": SIMULATES,
}


def lagging(samples: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A plant of one state, about 3."""
    random = np.random.default_rng(seed)
    inputs = random.standard_normal((samples, 2))
    x, y = 0.0, np.empty(samples)
    for k, u in enumerate(inputs):
        y[k] = 3.0 + 2.0 * x
        x = 0.8 * x + u[0] - 0.5 * u[1]
    return inputs, y + 0.01 * random.standard_normal(samples)


def test_the_checks_of_scikit_learn() -> None:
    estimator = CompensatedRegressor()
    checks = check_estimator(estimator, expected_failed_checks=NOT_FOR_IT, on_fail=None, on_skip=None)
    failed = [f"{c['check_name']}: {c['exception']!r}" for c in checks if c["status"] == "failed"]
    assert not failed, "\n".join(failed)
    assert {c["check_name"] for c in checks if c["status"] == "xfail"} == set(NOT_FOR_IT)
    assert sum(c["status"] == "passed" for c in checks) >= 45


def test_a_plant_is_learned_without_a_model() -> None:
    learned = CompensatedRegressor().fit(*lagging(300, 0))
    inputs, y = lagging(200, 1)
    assert learned.score(inputs, y) > 0.99
    assert (pickle.loads(pickle.dumps(learned)).predict(inputs) == learned.predict(inputs)).all()
    too_little = CompensatedRegressor(na=0, nb=1).fit(*lagging(300, 0))
    assert too_little.score(inputs, y) < 0.3


def test_a_search_chooses_the_orders() -> None:
    orders = {"na": [0, 1], "nb": [1, 2]}
    search = GridSearchCV(CompensatedRegressor(), orders, cv=TimeSeriesSplit(3)).fit(*lagging(400, 2))
    assert search.best_params_ == {"na": 1, "nb": 2}


def test_a_model_is_compensated(capsys: pytest.CaptureFixture[str]) -> None:
    run = np.genfromtxt(ROOT / "examples" / "turbine-run.csv", delimiter=",", skip_header=2)[:400]
    file = str(ROOT / "examples" / "turbine.toml")
    learned = CompensatedRegressor(file, na=2, nb=3, sample_time=float(run[1, 0] - run[0, 0]))
    learned.fit(run[:300, 1:2], run[:300, 2:4])
    y = learned.predict(run[:, 1:2])
    assert y.shape == (400, 2)
    # From the start of the run, so what was not learned from is at its end.
    errors = np.sqrt(np.mean((y[300:] - run[300:, 2:4]) ** 2, axis=0))
    assert (errors < 0.2 * np.std(run[300:, 2:4], axis=0)).all(), errors
    with pytest.raises(fdiag.InputError, match="X: expected 1 columns, one per channel of the model, found 2"):
        clone(learned).fit(run[:, 1:3], run[:, 2:4])


def test_a_gap_is_closed(logs: list[dict[str, np.ndarray]]) -> None:
    settings: dict[str, Any] = {"only": ["coulomb-friction"], "most": 1}
    (u, y), (later, seen) = ((log["force [N]"][:, None], log["speed [m/s]"]) for log in logs)
    closed = GapRegressor(CART, settings=settings).fit(u, y)
    assert closed.result_.causes[0].name == "coulomb-friction@rail"
    assert closed.score(later, seen) > 0.999 > fdiag_score(later, seen)


def fdiag_score(u: np.ndarray, y: np.ndarray) -> float:
    left = y - fdiag.Model(text=CART).simulate(u).ravel()
    return float(1.0 - np.sum(left**2) / np.sum((y - y.mean()) ** 2))
