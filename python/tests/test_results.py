"""What a result shows and makes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import FEW

import fdiag


@pytest.fixture(scope="module")
def answer(quick: dict[str, str]) -> fdiag.Result:
    return fdiag.gap(quick["model"], quick["monday"], held_out=quick["friday"], only=FEW)


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_causes_are_a_frame(answer: fdiag.Result, library: str) -> None:
    pytest.importorskip(library)
    frame = answer.to_frame(library)
    assert frame["cause"][0] == "coulomb-friction@rail" and frame["unit"][0] == "N"
    assert len(frame) == sum(len(cause.parameters) for cause in answer.causes)


def test_a_frame_of_an_unknown_library_is_refused(answer: fdiag.Result) -> None:
    with pytest.raises(fdiag.Error, match="expected nonesuch to be installed"):
        answer.to_frame("nonesuch")


def test_parameters_of_the_simulator_are_told(answer: fdiag.Result) -> None:
    mass = {p.name: p for p in answer.parameters}["m"]
    assert (mass.unit, mass.nominal) == ("kg", 1.2)
    # The cart is a little heavier than its model says, and the logs weigh it to a part of the tolerance.
    assert mass.standing == "found" and 0 < mass.standard_error < 0.1 * 0.03 * 1.2
    assert 5 * mass.standard_error < abs(mass.value - 1.2) < 0.03 * 1.2
    assert mass.tolerances == pytest.approx((mass.value / 1.2 - 1.0) / 0.03)


def test_a_notebook_shows_headline_table_and_picture(answer: fdiag.Result) -> None:
    shown = answer._repr_html_()
    assert "Coulomb friction at rail" in shown and "<table>" in shown and "<svg" in shown
    assert "Coulomb friction" in repr(answer)


def test_a_plot_has_three_lines(answer: fdiag.Result, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    figure = answer.plot("speed")
    assert len(figure.axes) == 1 and len(figure.axes[0].lines) == 3
    assert figure.axes[0].get_ylabel() == "speed [m/s]"
    figure.savefig(tmp_path / "run.png")
    with pytest.raises(fdiag.InputError, match="no output `sped`, did you mean `speed`"):
        answer.plot("sped")


def test_the_trace_is_that_of_the_held_out_log(
    answer: fdiag.Result, logs: list[dict[str, np.ndarray]]
) -> None:
    trace = answer.trace
    assert trace is not None and trace.role == "heldout"
    (speed,) = trace.outputs
    assert np.array_equal(speed.measured, logs[1]["speed [m/s]"])
    errors = [np.sqrt(np.nanmean((s - speed.measured) ** 2)) for s in (speed.before, speed.after)]
    assert errors[1] < 0.1 * errors[0]


def test_the_patched_simulator_is_nearer_to_reality(
    answer: fdiag.Result, quick: dict[str, str], logs: list[dict[str, np.ndarray]]
) -> None:
    nominal, better = fdiag.Model(quick["model"]), answer.patched()
    u, y = logs[1]["force [N]"], logs[1]["speed [m/s]"]
    errors = [np.sqrt(np.mean((s.simulate(u).ravel() - y) ** 2)) for s in (nominal, better)]
    assert errors[1] < 0.1 * errors[0]
    # It is a simulator as any other: nothing is missing in it now.
    again = fdiag.gap(better, logs[1], only=["viscous-friction", "input-gain"], most=1)
    assert again.verdict == "no-gap", again.headline
    with pytest.raises(fdiag.Error, match="expected one of 1 models, found 1"):
        answer.patched(1)


def test_signals_and_parameters_by_name(quick: dict[str, str]) -> None:
    cart = fdiag.Model(quick["model"])
    assert cart.inputs == (fdiag.Channel("force", "N"),)
    assert cart.parameters["m"] == fdiag.Uncertain(1.2, 0.03, "kg")
    a = cart.simulate({"force": [1.0, 1.0]}, {"m": 2.4})
    assert a.shape == (2, 1) and a[1, 0] == pytest.approx(0.01 / 2.4, rel=0.01)
    with pytest.raises(fdiag.InputError, match="no parameter `mm`, did you mean `m`"):
        cart.simulate([1.0], {"mm": 1.0})
    with pytest.raises(fdiag.InputError, match=r"shape \[samples, 1\] for `force`, found \[2, 3\]"):
        cart.simulate(np.ones((2, 3)))
