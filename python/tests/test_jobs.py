"""Many jobs by name: their seeds, their files, and what is left of a study that was interrupted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fdiag
from conftest import FEW
from fdiag import jobs


def drawn(shift: float, seed: int) -> float:
    if shift < 0.0:
        raise ValueError("below zero")
    return shift + float(np.random.default_rng(seed).standard_normal())


def test_a_seed_depends_on_its_name_only() -> None:
    alone = jobs.run(drawn, {"b": {"shift": 1.0}}, seed=3)
    among = jobs.run(drawn, {"a": {"shift": 0.0}, "b": {"shift": 1.0}, "c": {"shift": 1.0}}, seed=3)
    assert [o.name for o in among] == ["a", "b", "c"]
    assert among[1].result == alone[0].result != among[2].result
    assert jobs.run(drawn, {"b": {"shift": 1.0}}, seed=4)[0].result != alone[0].result


def test_an_exception_is_an_answer_and_the_others_go_on(tmp_path: Path) -> None:
    wrong, right = jobs.run(drawn, {"x/1": {"shift": -1.0}, "y": {"shift": 1.0}}, folder=tmp_path)
    assert (wrong.error, wrong.result, wrong.is_ok, right.is_ok) == ("ValueError: below zero", None, False, True)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["x%2F1.json", "y.json"]


def test_a_study_goes_on_where_it_was(tmp_path: Path) -> None:
    asked: dict[str, dict[str, Any]] = {name: {"shift": float(i)} for i, name in enumerate("abc")}
    calls = []

    def stops(shift: float, seed: int) -> float:
        calls.append(shift)
        if shift == 1.0 and len(calls) == 2:
            raise KeyboardInterrupt
        return drawn(shift, seed)

    with pytest.raises(KeyboardInterrupt):
        jobs.run(stops, asked, seed=1, folder=tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["a.json"]
    found = jobs.run(stops, asked, seed=1, folder=tmp_path)
    assert [o.is_new for o in found] == [False, True, True]
    assert calls == [0.0, 1.0, 1.0, 2.0]
    assert [o.result for o in found] == [o.result for o in jobs.run(stops, asked, seed=1)]


def test_a_file_of_another_job_is_refused(tmp_path: Path) -> None:
    jobs.run(drawn, {"a": {"shift": 1.0}}, folder=tmp_path)
    for other, seed in ({"shift": 2.0}, 0), ({"shift": 1.0}, 1):
        with pytest.raises(fdiag.InputError, match="expected the job `a` as it is now"):
            jobs.run(drawn, {"a": other}, seed=seed, folder=tmp_path)
    (tmp_path / "a.json").write_text("{", encoding="utf-8")
    with pytest.raises(fdiag.InputError, match="expected the outcome of a job"):
        jobs.run(drawn, {"a": {"shift": 1.0}}, folder=tmp_path)
    with pytest.raises(fdiag.InputError, match="names of 1 to 150"):
        jobs.run(drawn, {"": {"shift": 1.0}})


def test_arrays_tell_jobs_apart(tmp_path: Path) -> None:
    def total(values: np.ndarray) -> float:
        return float(values.sum())

    jobs.run(total, {"a": {"values": np.arange(3.0)}}, folder=tmp_path)
    assert not jobs.run(total, {"a": {"values": np.arange(3.0)}}, folder=tmp_path)[0].is_new
    with pytest.raises(fdiag.InputError):
        jobs.run(total, {"a": {"values": np.arange(3.0) + 1e-16}}, folder=tmp_path)


def test_a_diagnosis_is_its_report(quick: dict[str, str], tmp_path: Path) -> None:
    asked = {"monday": {"model": quick["model"], "log": quick["monday"], "only": FEW, "most": 1}}
    (found,) = jobs.run(fdiag.gap, asked, folder=tmp_path)
    assert found.error is None
    own = fdiag.gap(**asked["monday"], seed=found.seed).to_dict()
    del own["timing"]
    assert found.result == json.loads(json.dumps(own))
    assert json.loads((tmp_path / "monday.json").read_text())["result"] == found.result
