"""What a check says of simulators that are in order, and of those that are not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import Cart

import fdiag


def test_an_object_in_order_next_to_its_log(short: dict[str, np.ndarray]) -> None:
    found = fdiag.check(Cart(), short)
    assert found.grade == "fine" and not found.is_broken, str(found)
    assert found.samples == 400 and 0.0 < found.step_seconds < 1e-3 and found.precision < 1e-12
    said = {finding.what: finding.text for finding in found.findings}
    assert said["repeatability"] == "the same run three times gives the same bits"
    assert said["parameters"] == "each of 2 moves an output" and said["ports"] == "each of 1 moves an output"
    assert said["log"] == "log: 400 samples every 0.01 s"
    assert [cost.runs for cost in found.costs][1:] == [3_000, 10_000, 40_000]
    assert found.costs[0].runs is not None and 100 < found.costs[0].runs < 300
    assert found.costs[1].seconds == pytest.approx(
        1500 * (found.run_seconds + 400 * found.step_seconds), rel=1e-9
    )
    assert "repeatability" in str(found) and "<table>" in found._repr_html_()


def test_equations_are_costed_by_time(quick: dict[str, str]) -> None:
    found = fdiag.check(quick["model"], samples=100, amplitude=2.0)
    assert not found.is_broken and found.samples == 100
    assert [cost.runs for cost in found.costs] == [None, None]
    assert found.costs[0].seconds == pytest.approx(0.1) and found.costs[1].seconds == pytest.approx(2.0)


class Odd(Cart):
    """A cart with something wrong in it."""

    fault = ""
    count = 0

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        left = getattr(self, "v", 0.0)
        super().reset(parameters, x0)
        if self.fault == "something left":
            self.v += 1e-3 * left
        if self.fault == "dead parameter":
            self.d = 1.5

    def step(self, u: np.ndarray, f: np.ndarray) -> float:
        Odd.count += 1
        y = super().step(np.ones_like(u) if self.fault == "no input" else u, f)
        match self.fault:
            case "single precision":
                self.v = float(np.float32(self.v))
                return float(np.float32(y))
            case "noise":
                return y + 1e-6 * np.sin(Odd.count)
            case "nan" if self.v != 0.0:
                return float("nan")
            case "raises":
                raise KeyError("left_wheel")
        return y


def odd(fault: str) -> Any:
    return type("Odd", (Odd,), {"fault": fault})()


@pytest.mark.parametrize(
    ("fault", "grade", "what", "text"),
    [
        ("dead parameter", "broken", "parameters", "no output moves with `d`: is it applied?"),
        ("something left", "doubt", "repeatability", "of the output"),
        ("noise", "doubt", "repeatability", "equal runs differ in `speed` by"),
        ("single precision", "doubt", "precision", "single precision"),
        ("no input", "doubt", "inputs", "no output moves with `force`"),
        ("nan", "broken", "a run", "`speed` is not finite at sample"),
    ],
)
def test_what_is_wrong_is_said(fault: str, grade: str, what: str, text: str) -> None:
    found = fdiag.check(odd(fault), samples=60)
    worst = [finding for finding in found.doubts if finding.what == what]
    assert found.is_broken == (grade == "broken") and worst, str(found)
    assert worst[0].grade == grade and text in worst[0].text


def test_an_exception_arrives_with_its_cause() -> None:
    with pytest.raises(fdiag.SimulatorError, match="failed in `step`") as caught:
        fdiag.check(odd("raises"), samples=20)
    assert isinstance(caught.value.__cause__, KeyError)


def test_a_log_in_another_unit_or_without_a_column(short: dict[str, np.ndarray]) -> None:
    found = fdiag.check(Cart(), {**short, "speed [m/s]": 1000.0 * short["speed [m/s]"]})
    assert any(f.what == "log" and "unit" in f.text for f in found.doubts), str(found)
    with pytest.raises(fdiag.InputError, match="speed"):
        fdiag.check(Cart(), {name: short[name] for name in ("time [s]", "force [N]")})
    with pytest.raises(fdiag.InputError, match="samples: expected at least 2, found 1"):
        fdiag.check(Cart(), samples=1)


def test_whole_runs_are_checked_without_steps() -> None:
    @fdiag.rollout(inputs=["u"], outputs=["y"], sample_time=0.1, parameters={"k": 2.0})
    def gain(parameters: dict[str, float], x0: dict[str, float], u: np.ndarray) -> np.ndarray:
        return parameters["k"] * u

    found = fdiag.check(gain, samples=50)
    assert np.isnan(found.step_seconds) and found.run_seconds > 0.0
    assert [f.text for f in found.doubts if f.what == "steps"][0].startswith("it makes whole runs only")
