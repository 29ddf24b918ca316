"""Messages say what, where, expected and found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CART

import fdiag


def log(**columns: Any) -> dict[str, Any]:
    return {"t": np.arange(100) * 0.01, "force": np.ones(100), "speed": np.zeros(100)} | columns


@pytest.mark.parametrize(
    ("given", "settings", "message"),
    [
        ({"sped": np.zeros(100), "speed": None}, {}, "no column `speed`, did you mean `sped`"),
        ({"force": np.ones(90)}, {}, "column `force`: expected 100 values, as in the others, found 90"),
        ({"force": np.ones((100, 2))}, {}, r"column `force`: expected one number per row, found an array of shape \[100, 2\]"),
        ({"force": ["x"] * 100}, {}, "column `force`: expected numbers"),
        ({"speed": np.full(100, np.inf)}, {}, "row 1: expected a finite number, found `inf`"),
        ({"speed": np.full(100, np.nan)}, {}, "column of output `speed`: expected numbers, found none in"),
        ({"t": None}, {}, "expected a column `time`, `t`, `time_s` or `timestamp`"),
        ({}, {"only": ["coulomb-frictio"]}, "coulomb-friction"),
        ({}, {"tolerance": {"mass": 0.1}}, "no parameter `mass`"),
        ({}, {"noise": {"speed": -1.0}}, "noise: `speed`: expected a number from 0 on, found -1.0"),
        ({}, {"horizon": "soon"}, "horizon: expected `auto`, `free` or a number"),
        ({}, {"split": 2.0}, "split: expected a number between 0 and 1"),
        ({}, {"split": 0.5, "held_out": log()}, "found both"),
        ({}, {"columns": {"inptus": []}}, "unknown field `inptus`"),
        ({}, {"only": "friction"}, "expected a list of names, found the text `friction`"),
        ({}, {"resample": 0.0}, "resample: expected seconds above 0"),
    ],
)
def test_wrong_inputs(given: dict[str, Any], settings: dict[str, Any], message: str) -> None:
    columns = {name: values for name, values in log(**given).items() if values is not None}
    with pytest.raises(fdiag.InputError, match=message) as caught:
        fdiag.gap(CART, columns, **settings)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, fdiag.Error)


def test_columns_that_nobody_asks_for_may_hold_anything() -> None:
    columns = log(note=["a"] * 100, picture=np.zeros((100, 4)))
    with pytest.raises(fdiag.AnalysisError):
        # Far too short; but read.
        fdiag.gap(CART, {name: values[:4] for name, values in columns.items()})


def test_files_that_are_not_there(tmp_path: Path) -> None:
    missing = str(tmp_path / "none.toml")
    with pytest.raises(fdiag.InputError, match="none.toml"):
        fdiag.gap(missing, log())
    with pytest.raises(fdiag.InputError, match="none.csv"):
        fdiag.gap(CART, str(tmp_path / "none.csv"))
    with pytest.raises(fdiag.InputError, match="none.toml"):
        fdiag.gap(CART, log(), columns=missing)


def test_a_model_that_is_wrong_says_where() -> None:
    with pytest.raises(fdiag.InputError, match="did you mean `force`"):
        fdiag.gap(CART.replace("(force - d*v)/m", "(forc - d*v)/m"), log())


@pytest.mark.parametrize("model", [3.5, None, object()])
def test_what_is_no_model_is_refused(model: Any) -> None:
    with pytest.raises(fdiag.InputError, match="model: expected a path, the text of a model file"):
        fdiag.gap(model, log())


def test_what_is_no_log_is_refused() -> None:
    with pytest.raises(fdiag.InputError, match="log: expected a path, a dict of arrays"):
        fdiag.gap(CART, 5)
    with pytest.raises(fdiag.InputError, match="found an empty list"):
        fdiag.gap(CART, [])


def test_text_of_a_file_cannot_command_a_terminal() -> None:
    with pytest.raises(fdiag.InputError) as caught:
        fdiag.gap(CART, log(), only=["\x1b[31mred"])
    assert "\x1b" not in str(caught.value)


def test_columns_of_lists_are_a_column_for_each_entry() -> None:
    from fdiag import _logs

    rows = np.empty(3, dtype=object)
    rows[:] = [[1.0, 2.0], None, np.array([5.0, 6.0])]
    log = {"time": [0.0, 1.0, 2.0], "state [rad]": rows, "action": np.ones((3, 2)), "T": [1.0, 2.0, 3.0]}
    [(_, columns)] = _logs.native(log, "log")
    found = dict(columns)
    assert list(found) == ["time", "state[0] [rad]", "state[1] [rad]", "action[0]", "action[1]", "T"]
    assert found["state[1] [rad]"][2] == 6.0 and np.isnan(found["state[0] [rad]"][1])
    rows[2] = [1.0]
    with pytest.raises(fdiag.InputError, match=r"column `state`: expected lists of 2 numbers.*found \[1\] in row 2"):
        _logs.native(log, "log", needed=lambda: ["state"])
    # A capital T is a temperature.
    assert _logs.native({"T": [1.0, 2.0]}, "log", 0.5)[0][1][0][0] == "time [s]"
