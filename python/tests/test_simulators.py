"""Objects, functions and programs as simulators."""

from __future__ import annotations

import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from conftest import ROOT, Cart

import fdiag

ONLY = ["coulomb-friction", "viscous-friction"]


def test_an_object_names_the_cause(quick: dict[str, str]) -> None:
    result = fdiag.gap(Cart(), quick["monday"], only=ONLY, most=1)
    assert result.causes[0].name == "coulomb-friction@rail"
    force = next(p for p in result.causes[0].parameters if p.is_strength)
    assert force.unit == "N" and abs(force.value - 0.35) < 0.05
    work = result.work
    assert work is not None and work.steps > 10_000 and work.trouble is None
    assert work.made <= work.asked and work.lost == 0


def test_the_patched_object_is_a_simulator_again(
    short: dict[str, np.ndarray], logs: list[dict[str, np.ndarray]]
) -> None:
    cart = fdiag.Steps(Cart(), sample_time=0.01, **{k: getattr(Cart, k) for k in (
        "inputs", "outputs", "parameters", "initial", "ports")})
    result = fdiag.gap(cart, short, only=["coulomb-friction"], most=1)
    better = result.patched()
    u, y = logs[1]["force [N]"], logs[1]["speed [m/s]"]
    errors = [np.sqrt(np.mean((s.simulate(u).ravel() - y) ** 2)) for s in (cart, better)]
    assert errors[1] < 0.2 * errors[0]
    assert "rail_coulomb" in better.text()
    assert any(name.endswith("coulomb") for name in better.parameters)


def test_a_function_makes_whole_runs(short: dict[str, np.ndarray]) -> None:
    @fdiag.rollout(
        inputs={"force": "N"},
        outputs={"speed": fdiag.Output("m/s", 0.004)},
        parameters={"m": fdiag.Uncertain(1.2, 0.03, "kg"), "d": fdiag.Uncertain(1.5, 0.1, "N s/m")},
        initial={"v": fdiag.Initial(0.0, None, "m/s")},
        sample_time=0.01,
    )
    def cart(parameters: dict[str, float], x0: dict[str, float], u: np.ndarray) -> np.ndarray:
        decay = float(np.exp(-parameters["d"] / parameters["m"] * 0.01))
        y, v = np.empty((len(u), 1)), x0["v"]
        for k, force in enumerate(u[:, 0] / parameters["d"]):
            y[k, 0], v = v, force + (v - force) * decay
        return y

    # A gain of the input, which needs no force: made here, by another way than the effects.
    y = cart.simulate(0.8 * short["force [N]"])
    noise = 0.004 * np.random.default_rng(1).standard_normal(y.shape)
    log = {**short, "speed [m/s]": (y + noise).ravel()}
    result = fdiag.gap(cart, log, only=["input-gain", "input-delay", "sensor-bias"], most=1)
    assert result.causes[0].label == "input-gain", result.headline
    assert callable(cart) and cart.__name__ == "cart"


def test_a_run_is_made_again_where_a_connection_is_lost(short: dict[str, np.ndarray]) -> None:
    steps = 0

    class Rig(Cart):
        def step(self, u: np.ndarray, f: np.ndarray) -> float:
            nonlocal steps
            steps += 1
            if steps == 1234:
                raise ConnectionResetError("the rig has hung up")
            return super().step(u, f)

    said = {k: getattr(Cart, k) for k in ("inputs", "outputs", "parameters", "initial", "ports")}
    rig = fdiag.Steps(Rig, sample_time=0.01, **said)
    result = fdiag.gap(rig, short, only=["coulomb-friction"], most=1)
    plain = fdiag.gap(Cart(), short, only=["coulomb-friction"], most=1)
    assert result.work is not None and (result.work.deaths, result.work.lost) == (1, 0)
    assert "hung up" in (result.work.trouble or "")
    assert result.to_dict()["diagnosis"] == plain.to_dict()["diagnosis"]
    assert result.causes[0].name == "coulomb-friction@rail"


def test_an_object_that_makes_one_run_is_made_for_each(short: dict[str, np.ndarray]) -> None:
    made = 0

    class Once(Cart):
        def __init__(self) -> None:
            nonlocal made
            made += 1
            self.is_used = False

        def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
            assert not self.is_used, "a second run"
            self.is_used = True
            super().reset(parameters, x0)

    said = {k: getattr(Cart, k) for k in ("inputs", "outputs", "parameters", "initial", "ports")}
    once = fdiag.Steps(Once, sample_time=0.01, resets=False, **said)
    result = fdiag.gap(once, short, only=["coulomb-friction"], most=1)
    again = fdiag.gap(fdiag.Steps(Cart(), sample_time=0.01, **said), short, only=["coulomb-friction"], most=1)
    assert result.headline == again.headline
    work = result.work
    assert work is not None and 10 < work.made <= made
    with pytest.raises(fdiag.InputError, match="resets: expected a function"):
        fdiag.Steps(Cart(), sample_time=0.01, resets=False, **said)


def test_a_program_gives_the_answer_of_the_object(short: dict[str, np.ndarray]) -> None:
    command = [sys.executable, str(ROOT / "examples" / "process" / "cart.py")]
    process = fdiag.Process(command, parameters={"m": {"tolerance": 0.03}})
    assert process.name == "cart" and process.inputs == (fdiag.Channel("force", "N"),)
    result = fdiag.gap(process, short, only=["coulomb-friction"], most=1)
    assert result.causes[0].name == "coulomb-friction@rail"
    u = np.ones(50)
    own = fdiag.gap(Cart(), short, only=["coulomb-friction"], most=1).patched()
    assert np.allclose(result.patched().simulate(u), own.simulate(u), rtol=0.05, atol=1e-3)
    with pytest.raises(fdiag.SimulatorError, match="cannot be started"):
        fdiag.gap(fdiag.Process(["./no-such-program"]), short)


class Faulty(Cart):
    """A cart with something wrong in it."""

    def __init__(self, fault: str):
        self.fault, self.count = fault, 0

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        if self.fault == "raises at some" and parameters["m"] != 1.2:
            raise RuntimeError("the mass must not change")
        super().reset(parameters, x0)

    def step(self, u: np.ndarray, f: np.ndarray) -> Any:
        self.count += 1
        y = super().step(u, f)
        match self.fault:
            case "raises" if self.count > 150:
                raise KeyError("left_wheel")
            case "shape":
                return np.zeros(3)
            case "none":
                return None
            case "text":
                return "fast"
            case "nan" if self.count > 20:
                return float("nan")
        return y


def test_an_exception_arrives_with_its_traceback(quick: dict[str, str]) -> None:
    with pytest.raises(fdiag.SimulatorError, match="failed in `step` at m = 1.2, d = 1.5") as caught:
        fdiag.gap(Faulty("raises"), quick["monday"])
    cause = caught.value.__cause__
    assert isinstance(cause, KeyError)
    shown = "".join(traceback.format_exception(caught.value))
    assert 'raise KeyError("left_wheel")' in shown and "in step" in shown


def test_a_simulator_that_raises_at_some_parameters_ends_the_diagnosis(quick: dict[str, str]) -> None:
    with pytest.raises(fdiag.SimulatorError, match="`reset` at m = ") as caught:
        fdiag.gap(Faulty("raises at some"), quick["monday"], only=["coulomb-friction"])
    assert "the mass must not change" in str(caught.value.__cause__)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("shape", r"`step`: expected 1 numbers, the outputs `speed`, found an array of shape \[3\]"),
        ("none", "found None: does it return its outputs?"),
        ("text", "found a value of type `str`"),
        ("nan", "expected finite outputs, found NaN in `speed` at sample"),
    ],
)
def test_outputs_that_are_none(quick: dict[str, str], fault: str, message: str) -> None:
    with pytest.raises(fdiag.SimulatorError, match=message):
        fdiag.gap(Faulty(fault), quick["monday"])


class Narrow(Cart):
    """A cart that has no numbers for heavy carts."""

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        if parameters["m"] > 1.26:
            raise fdiag.Diverged("too heavy")
        super().reset(parameters, x0)


def test_parameters_without_numbers_are_left_alone(short: dict[str, np.ndarray]) -> None:
    result = fdiag.gap(Narrow(), short, only=["coulomb-friction"], most=1)
    assert result.causes[0].name == "coulomb-friction@rail"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"outputs": None}, "has no attribute `outputs`"),
        ({"ports": {"rail": {"unit": "N", "velocity": "sped"}}}, "ports.rail: expected an output out of `speed`, found `sped`"),
        ({"parameters": {"m": {"value": 1.2, "bounds": [2.0, 3.0]}}}, "parameters.m: expected bounds around its value"),
        ({"parameters": {"m": "kg"}}, "parameters.m: expected a value, found none"),
        ({"inputs": "force"}, "inputs: expected a list of names or a dict, found the text `force`"),
        ({"sample_time": -1.0}, "sample_time: expected seconds above 0"),
        ({"step": lambda self, u: 0.0}, "expected a method `step\\(u, f\\)`"),
        ({"reset": None}, "has no method `reset`"),
    ],
)
def test_what_an_object_says_of_itself_is_checked(
    quick: dict[str, str], change: dict[str, Any], message: str
) -> None:
    with pytest.raises(fdiag.InputError, match=message):
        fdiag.gap(type("Odd", (Cart,), change)(), quick["monday"])


@pytest.fixture
def heard() -> Iterator[None]:
    """Ctrl-C is heard, also in the background of a shell, where it is ignored from the start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heard")
def test_ctrl_c_stops_an_object(quick: dict[str, str]) -> None:
    class Slow(Cart):
        begun = False

        def step(self, u: np.ndarray, f: np.ndarray) -> float:
            if not Slow.begun:
                Slow.begun = True
                threading.Timer(0.3, signal.raise_signal, [signal.SIGINT]).start()
            return super().step(u, f)

    with pytest.raises(KeyboardInterrupt):
        fdiag.gap(Slow(), quick["monday"])


@pytest.mark.usefixtures("heard")
def test_ctrl_c_stops_equations(quick: dict[str, str]) -> None:
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            fdiag.gap(quick["model"], quick["monday"], calibrate=20)
