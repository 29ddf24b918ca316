"""Simulators of every kind whose runs are made by actors, for the tests with and without Ray."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import FEW, ROOT

import fdiag
import fdiag.ray


@dataclass
class Kind:
    """What makes a simulator, inputs, what reality shows of them, and settings of the diagnosis."""

    make: Callable[[], Any]
    u: np.ndarray
    y: np.ndarray
    settings: dict[str, Any]
    cause: str | None = None
    """The answer, where it is clear."""


def report(result: fdiag.Result) -> dict[str, Any]:
    return {key: value for key, value in result.to_dict().items() if key != "timing"}


def held(size: float) -> np.ndarray:
    return np.repeat(np.random.default_rng(8).uniform(-size, size, 30), 10)


def late(u: np.ndarray) -> np.ndarray:
    """A command that comes three samples late."""
    return np.concatenate([np.full(3, u[0]), u[:-3]])


def scene(request: pytest.FixtureRequest) -> Kind:
    pytest.importorskip("mujoco")
    import test_native

    u = held(1.5)
    real = test_native.run(test_native.PENDULUM.replace('damping=".08"', 'damping=".08" frictionloss=".1"'), u)
    settings = {"noise": {"angle": 0.002, "rate": 0.01}, "exclude": ["map"]}
    return Kind(test_native.scene, u, real, settings, "coulomb-friction@pivot")


def program(request: pytest.FixtureRequest) -> Kind:
    program = str(ROOT / "examples" / "process" / "cart.py")

    def make() -> fdiag.Process:
        return fdiag.Process([sys.executable, program])

    u = held(3.0)
    settings = {"noise": {"speed": 0.004}, "only": FEW}
    return Kind(make, u, make().simulate(late(u), {"d": 1.6}), settings, "input-delay@force")


def fmu(request: pytest.FixtureRequest) -> Kind:
    mass: Path = request.getfixturevalue("mass")

    def make() -> fdiag.Fmu:
        return fdiag.Fmu(
            mass,
            inputs=["force"],
            outputs={"place": fdiag.Output("m", 0.001), "speed": fdiag.Output("m/s", 0.002)},
            uncertain={"d": 0.1, "k": 0.05},
            ports={"push": fdiag.Port("N", "place", "speed")},
            sample_time=0.02,
        )

    u = held(3.0)
    settings = {"noise": {"place": 0.001, "speed": 0.002}, "only": FEW}
    return Kind(make, u, make().simulate(late(u), {"d": 0.9}), settings, "input-delay@force")


def environment(request: pytest.FixtureRequest, many: int = 0) -> Kind:
    gym = pytest.importorskip("gymnasium")
    import test_gymnasium

    def make() -> fdiag.Gymnasium:
        env = gym.vector.SyncVectorEnv([test_gymnasium.Sled] * many) if many else test_gymnasium.Sled()
        return fdiag.Gymnasium(env, **test_gymnasium.SAID, initial={"x0": 0.0, "v0": 0.0})

    u = held(4.0)
    only = ["input-delay", "input-gain", "sensor-bias", "input-lag"]
    settings = {"noise": {"x": 0.002, "v": 0.005}, "only": only}
    return Kind(make, u, make().simulate(late(u), {"mass": 1.05}), settings, "input-delay@force")


def environments(request: pytest.FixtureRequest) -> Kind:
    return environment(request, 4)


#: By name; each skips its test where something is not installed.
KINDS = {kind.__name__: kind for kind in (scene, program, fmu, environment, environments)}


def is_the_same(name: str, request: pytest.FixtureRequest) -> None:
    """The answer of two actors is that of one machine, to the bit, and so are runs."""
    kind = KINDS[name](request)
    here, noise = fdiag.simulators.as_simulator(kind.make()), kind.settings["noise"]
    y = kind.y + np.random.default_rng(20261126).standard_normal(kind.y.shape) * list(noise.values())
    inputs = {channel.name: kind.u for channel in here.inputs}
    log = {"time": here.sample_time * np.arange(len(kind.u)), **inputs, **dict(zip(noise, y.T))}
    spread = fdiag.ray.Spread(kind.make, actors=2)
    found, there = (fdiag.gap(simulator, log, most=1, threads=2, **kind.settings) for simulator in (here, spread))
    assert report(there) == report(found)
    assert kind.cause in (None, there.causes[0].name), there.headline
    assert np.array_equal(spread.simulate(kind.u), here.simulate(kind.u), equal_nan=True)
    # What was found is a simulator that actors run.
    assert np.array_equal(there.patched().simulate(kind.u), found.patched().simulate(kind.u), equal_nan=True)
