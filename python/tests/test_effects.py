"""Effects of one's own, as text."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import fdiag

HEATER = """
version = 1
kind = "equations"
name = "heater"
sample_time = 1.0
inputs = { power = { unit = "W" }, supply = { unit = "V" } }
outputs = { T = { unit = "K", value = "x", noise = 0.02 } }
parameters = { tau = { unit = "s", value = 40.0, tolerance = 0.03 } }
states = { x = { unit = "K", initial = 0.0, derivative = "(0.1*power - x)/tau" } }
"""


def log(seed: int) -> dict[str, np.ndarray]:
    """The real heater gives less when its supply sags below 24 V, by a loop of its own."""
    random = np.random.default_rng(seed)
    power = np.repeat(random.uniform(20.0, 100.0, 30), 20)
    supply = 24.0 + 2.0 * np.sin(np.arange(600) / 17.0) + 0.5 * np.sin(np.arange(600) / 5.0)
    x, y = 0.0, np.empty(600)
    for k in range(600):
        y[k] = x
        real = power[k] * (1.0 - 0.08 * max(24.0 - supply[k], 0.0))
        x = 0.1 * real + (x - 0.1 * real) * np.exp(-1.0 / 40.5)
    return {"time": np.arange(600.0), "power": power, "supply": supply, "T": y + 0.02 * random.standard_normal(600)}


def sag(**more: Any) -> fdiag.Effect:
    said = {"law": "u*(1 - s*max(24 - supply, 0))", "parameters": {"s": {"size": 0.05, "unit": "1/V"}}, "at": "power"}
    return fdiag.Effect("supply-sag", "input", **(said | more))


def test_an_own_effect_is_named_among_those_of_the_library() -> None:
    result = fdiag.gap(fdiag.Model(text=HEATER), log(1), effects=[sag()], most=1)
    assert (result.verdict, result.causes[0].name, result.causes[0].law) == ("cause", "supply-sag@power", "text")
    found = result.causes[0].parameters[0]
    assert abs(found.value - 0.08) < 4.0 * found.standard_error and found.unit == "1/V"
    # The patched model is one of equations like any other.
    later = log(2)
    y = result.patched().simulate({"power": later["power"], "supply": later["supply"]}).ravel()
    assert np.sqrt(np.mean((y - later["T"]) ** 2)) < 0.03
    settings = result.to_dict()["settings"]["effects"]
    assert settings == ["supply-sag at power: u*(1 - s*max(24 - supply, 0))"]


def test_without_it_nothing_explains_the_log() -> None:
    result = fdiag.gap(fdiag.Model(text=HEATER), log(1), only=["input-gain", "input-lag"], most=1)
    assert result.causes[0].gap > 3.0


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        ([sag(law="u*(1 - s*max(24 - suply, 0))")], "`supply-sag`: law: .* did you mean `supply`"),
        ([sag(at=["powr"])], "`supply-sag`: at: .* did you mean `power`"),
        ([sag(law="u*s")], "law: expected `u` where all strengths are 0"),
        ([sag(parameters={"s": {"size": 1.0, "unti": "V"}})], "parameters.s: expected `size`, .* found `unti`"),
        ([sag(parameters={"s": {"unit": "V"}})], "parameters.s: expected a `size`, found none"),
        ([sag(parameters={"s": "1"})], "parameters.s.size: expected a number, found '1'"),
        ([sag(), sag()], "expected every label once"),
        ([{"law": "u"}], "expected a list of fdiag.Effect, found a value of type `dict`"),
        (sag(), "expected a list of fdiag.Effect"),
    ],
)
def test_what_is_wrong_is_said(effects: Any, message: str) -> None:
    with pytest.raises(fdiag.InputError, match=message):
        fdiag.gap(fdiag.Model(text=HEATER), log(1), effects=effects)
