"""Jobs on a cluster: the answers of one machine, whatever becomes of a worker."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import fdiag
import fdiag.ray
from conftest import FEW
from fdiag import jobs

ray = pytest.importorskip("ray", reason="ray is not installed")


@pytest.fixture(scope="module", autouse=True)
def cluster() -> Iterator[None]:
    """Two workers on this machine."""
    here = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": here}})
    yield
    ray.shutdown()


def settled(x: int, marks: str, deaths: int, seed: int) -> list[int]:
    """Kills its own worker, as a machine that runs out of memory does, as often as it is told."""
    mark = Path(marks) / f"{x}.{time.time_ns()}"
    mark.touch()
    if len(list(Path(marks).glob(f"{x}.*"))) <= deaths:
        os.kill(os.getpid(), signal.SIGKILL)
    return [x, seed % 1000]


def test_a_lost_worker_costs_only_its_task(tmp_path: Path) -> None:
    marks, kept = tmp_path / "marks", tmp_path / "kept"
    marks.mkdir()
    asked: dict[str, dict[str, Any]] = {
        f"job {x}": {"x": x, "marks": str(marks), "deaths": {3: 1, 5: 99}.get(x, 0)} for x in range(8)
    }
    found = fdiag.ray.map(settled, asked, seed=2, folder=kept, retries=1)
    assert [o.result for o in found if o.is_ok] == [[x, jobs.seed_of(2, f"job {x}") % 1000] for x in range(8) if x != 5]
    assert "WorkerCrashedError" in (found[5].error or "")
    # One that was lost has no file, and is tried again.
    assert not (kept / "job%205.json").exists() and len(list(kept.iterdir())) == 7
    tries = {x: len(list(marks.glob(f"{x}.*"))) for x in range(8)}
    assert tries == {x: 2 if x in (3, 5) else 1 for x in range(8)}
    again = fdiag.ray.map(settled, asked, seed=2, folder=kept, retries=0)
    assert [o.is_new for o in again] == [x == 5 for x in range(8)]


def test_answers_are_those_of_one_machine(quick: dict[str, str]) -> None:
    asked = {
        day: {"model": quick["model"], "log": quick[day], "only": FEW, "most": 1, "calibrate": 2}
        for day in ("monday", "friday")
    }
    here = jobs.run(fdiag.gap, asked, seed=5)
    there = fdiag.ray.map(fdiag.gap, asked, seed=5)
    assert [o.error for o in here] == [None, None]
    assert [(o.name, o.seed, o.result) for o in there] == [(o.name, o.seed, o.result) for o in here]


def test_bad_settings_are_refused() -> None:
    with pytest.raises(fdiag.InputError, match="cpus"):
        fdiag.ray.map(settled, {}, cpus=0.0)
    with pytest.raises(fdiag.InputError, match="retries"):
        fdiag.ray.map(settled, {}, retries=-1)
    assert fdiag.ray.map(settled, {}) == []
