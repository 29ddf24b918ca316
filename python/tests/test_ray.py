"""Jobs and simulators on a cluster: the answers of one machine, whatever becomes of a worker."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fdiag
import fdiag.ray
import spreads
from conftest import FEW, QUICK, Cart
from fdiag import _spread, jobs

ray = pytest.importorskip("ray", reason="ray is not installed")


@pytest.fixture(scope="module", autouse=True)
def cluster() -> Iterator[None]:
    """Two workers on this machine."""
    here = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    _spread.started(num_cpus=2, runtime_env={"env_vars": {"PYTHONPATH": here}})
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


class Mortal(Cart):
    """A cart whose process is killed in the middle of a run, once; `left` is how many samples it has till then."""

    left = 5000

    def __init__(self, mark: str):
        self._mark = Path(mark)

    def step(self, u: np.ndarray, f: np.ndarray) -> float:
        Mortal.left -= 1
        if Mortal.left == 0:
            try:
                self._mark.touch(exist_ok=False)
            except FileExistsError:
                return super().step(u, f)
            os.kill(os.getpid(), signal.SIGKILL)
        return super().step(u, f)


def test_one_diagnosis_by_two_actors_of_which_one_is_killed(short: dict[str, np.ndarray], tmp_path: Path) -> None:
    settings: dict[str, Any] = {"only": ["coulomb-friction", "viscous-friction", "input-delay"], "most": 1}
    here = fdiag.gap(Cart(), short, **settings)
    mark = tmp_path / "killed"
    spread = fdiag.ray.Spread(lambda: Mortal(str(mark)), actors=2)
    there = fdiag.gap(spread, short, **settings)
    assert mark.exists() and there.work is not None and here.work is not None
    assert (there.work.deaths, there.work.lost, here.work.deaths) == (1, 0, 0)
    assert spreads.report(there) == spreads.report(here) and there.causes[0].name == "coulomb-friction@rail"
    # The actors are still there, and what was found is a simulator that they run.
    u = short["force [N]"]
    assert np.array_equal(there.patched().simulate(u), here.patched().simulate(u))


def lag(parameters: dict[str, float], x0: dict[str, float], u: np.ndarray) -> np.ndarray:
    y = np.empty((len(u), 1))
    shown = 0.0
    for k, value in enumerate(u[:, 0]):
        y[k, 0], shown = shown, shown + parameters["rate"] * (value - shown)
    return y


def whole_runs() -> fdiag.Rollout:
    rate = {"rate": fdiag.Uncertain(0.1, 0.05)}
    return fdiag.rollout(inputs=["u"], outputs=["y"], sample_time=0.1, parameters=rate)(lag)


def test_whole_runs_by_actors() -> None:
    random = np.random.default_rng(20261125)
    u = np.repeat(random.uniform(-1.0, 1.0, 30), 10)
    late = np.concatenate([np.zeros(3), u[:-3]])
    y = whole_runs().simulate(late).ravel() + 0.01 * random.standard_normal(300)
    log = {"time": 0.1 * np.arange(300), "u": u, "y": y}
    settings: dict[str, Any] = {"noise": {"y": 0.01}, "only": ["input-delay", "input-gain", "sensor-delay"], "most": 1}
    here, there = (fdiag.gap(s, log, **settings) for s in (whole_runs(), fdiag.ray.Spread(whole_runs, actors=2)))
    assert spreads.report(there) == spreads.report(here) and here.causes[0].label in ("input-delay", "sensor-delay")


@pytest.mark.parametrize("kind", spreads.KINDS)
def test_each_kind_of_simulator_by_actors(kind: str, request: pytest.FixtureRequest) -> None:
    spreads.is_the_same(kind, request)


class Broken(Cart):
    def step(self, u: np.ndarray, f: np.ndarray) -> float:
        raise KeyError("no such joint")


def test_what_is_wrong_with_an_actor_is_said(short: dict[str, np.ndarray]) -> None:
    with pytest.raises(fdiag.SimulatorError) as raised:
        fdiag.ray.Spread(Broken, actors=1).simulate(np.ones(5))
    assert "no such joint" in str(raised.value.__cause__) and "failed in `step`" in str(raised.value.__cause__)
    with pytest.raises(fdiag.SimulatorError) as raised:
        fdiag.ray.Spread(Cart, actors=1, cpus=64.0, patience=0.5).simulate(np.ones(5))
    assert "are 64.0 processors free?" in str(raised.value.__cause__)
    with pytest.raises(fdiag.InputError, match="found equations"):
        fdiag.ray.Spread(lambda: fdiag.Model(QUICK / "model.toml"), actors=1)
    with pytest.raises(fdiag.InputError, match="actors: expected at least 1"):
        fdiag.ray.Spread(Cart, actors=0)
    with pytest.raises(fdiag.InputError, match="a function that makes a simulator"):
        fdiag.ray.Spread(Cart(), actors=1)
