"""`fdiag.gap` of model files and logs of every kind."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CART, FEW, binary

import fdiag


@pytest.fixture(scope="module")
def answer(quick: dict[str, str]) -> fdiag.Result:
    return fdiag.gap(quick["model"], quick["monday"], held_out=quick["friday"], only=FEW)


def untimed(report: dict[str, Any]) -> dict[str, Any]:
    return {**report, "timing": None}


def test_the_cause_is_named_with_units(answer: fdiag.Result) -> None:
    assert answer.verdict == "cause"
    cause = answer.causes[0]
    assert cause.name == "coulomb-friction@rail" and cause.probability > 0.95
    force = next(p for p in cause.parameters if p.is_strength)
    assert force.unit == "N" and abs(force.value - 0.35) < 0.02
    closed = answer.held_out[0].closed
    assert closed is not None and closed.fraction > 0.95
    assert closed.interval[0] <= closed.fraction <= closed.interval[1]


@pytest.mark.skipif(binary() is None, reason="the command line is not built")
def test_the_report_is_that_of_the_command_line_to_the_letter(
    answer: fdiag.Result, quick: dict[str, str], tmp_path: Path
) -> None:
    program = str(binary())
    asked = ["gap", "--model", quick["model"], "--log", quick["monday"], "--held-out", quick["friday"]]
    for label in FEW:
        asked += ["--only", label]
    theirs, ours = tmp_path / "theirs", tmp_path / "ours"
    subprocess.run([program, *asked, "--out", str(theirs)], check=True, capture_output=True)
    assert answer.save(ours) == ours / "report.html"
    assert sorted(p.name for p in theirs.iterdir()) == sorted(p.name for p in ours.iterdir())
    assert (theirs / "patched.toml").read_text() == (ours / "patched.toml").read_text()
    # The command line says at the end of the page which command it was, and when.
    pages = [(folder / "report.html").read_text() for folder in (theirs, ours)]
    assert re.sub("<footer>.*</footer>", "", pages[0], flags=re.DOTALL) == pages[1]
    # The one part that is not the same every time stands at the end.
    texts = [(folder / "report.json").read_text().partition('  "timing"')[0] for folder in (theirs, ours)]
    assert texts[0] == texts[1] and len(texts[0]) > 10_000
    report = json.loads((theirs / "report.json").read_text())
    assert untimed(report) == untimed(answer.to_dict())
    assert list(report["timing"]) == list(answer.to_dict()["timing"])


def test_arrays_give_the_answer_of_the_file(
    answer: fdiag.Result, quick: dict[str, str], logs: list[dict[str, np.ndarray]]
) -> None:
    again = fdiag.gap(quick["model"], logs[0], held_out=logs[1], only=FEW)
    ours, theirs = again.to_dict(), answer.to_dict()
    assert ours["diagnosis"] == theirs["diagnosis"]
    assert [log["file"] for log in ours["inputs"]["logs"]] == ["log", "held-out"]


@pytest.mark.parametrize("library", ["pandas", "polars", "xarray", "structured", "no time"])
def test_frames_are_logs(
    library: str, quick: dict[str, str], logs: list[dict[str, np.ndarray]], answer: fdiag.Result
) -> None:
    log: Any
    settings: dict[str, Any] = {}
    if library == "xarray":
        xarray = pytest.importorskip("xarray")
        signals = {
            name.split(" [")[0]: ("time", values, {"units": name.split("[")[1][:-1]})
            for name, values in logs[0].items()
            if not name.startswith("time")
        }
        log = xarray.Dataset(signals, coords={"time": logs[0]["time [s]"]})
    elif library == "structured":
        log = np.zeros(len(logs[0]["time [s]"]), dtype=[(n.split(" [")[0], float) for n in logs[0]])
        for name, values in logs[0].items():
            log[name.split(" [")[0]] = values
    elif library == "no time":
        log = {name: values for name, values in logs[0].items() if not name.startswith("time")}
        settings["sample_time"] = 0.01
    else:
        log = pytest.importorskip(library).DataFrame(logs[0])
    result = fdiag.gap(quick["model"], log, only=["coulomb-friction"], most=1, **settings)
    assert result.causes[0].name == "coulomb-friction@rail"
    split = fdiag.gap(quick["model"], quick["monday"], only=["coulomb-friction"], most=1)
    if library != "no time":
        assert result.to_dict()["diagnosis"] == split.to_dict()["diagnosis"]


def test_the_text_of_a_model_and_the_settings(quick: dict[str, str]) -> None:
    result = fdiag.gap(
        CART,
        quick["monday"],
        split=0.5,
        only=["friction"],
        tolerance={"m": 0.01},
        noise={"speed": 0.005},
        seed=3,
        most=1,
        threads=1,
    )
    settings = result.to_dict()["settings"]
    assert settings["tolerances"] == ["m=0.01"] and settings["noise"] == ["speed=0.005"]
    assert (settings["seed"], settings["split"], settings["only"]) == (3, 0.5, ["friction"])
    assert result.to_dict()["timing"]["threads"] == 1


def test_columns_are_mapped(quick: dict[str, str], logs: list[dict[str, np.ndarray]], tmp_path: Path) -> None:
    log = dict(zip(("clock", "F", "v"), logs[0].values()))
    columns = {
        "time": {"column": "clock"},
        "inputs": [{"name": "force", "column": "F", "unit": "N"}],
        "outputs": [{"name": "speed", "column": "v", "unit": "m/s"}],
    }
    file = tmp_path / "columns.toml"
    file.write_text(
        'time = { column = "clock" }\ninputs = [{ name = "force", column = "F", unit = "N" }]\n'
        'outputs = [{ name = "speed", column = "v", unit = "m/s" }]\n'
    )
    a, b = (
        fdiag.gap(quick["model"], log, columns=c, only=["coulomb-friction"], most=1)
        for c in (columns, str(file))
    )
    assert a.causes[0].name == "coulomb-friction@rail"
    assert untimed(a.to_dict()) == untimed(b.to_dict())


def test_progress_goes_through_the_stages(quick: dict[str, str]) -> None:
    seen: list[tuple[str, int, int]] = []
    fdiag.gap(quick["model"], quick["monday"], most=1, progress=lambda *now: seen.append(now))
    assert {stage for stage, _, _ in seen} >= {"fitting"}
    assert all(0 <= done and 0 < pieces for _, done, pieces in seen)


def test_what_progress_raises_stops_the_work(quick: dict[str, str]) -> None:
    class Enough(Exception):
        pass

    def stop(stage: str, done: int, pieces: int) -> None:
        raise Enough

    with pytest.raises(Enough):
        fdiag.gap(quick["model"], quick["monday"], progress=stop)
    # And nothing is left of it.
    assert fdiag.gap(quick["model"], quick["monday"], only=["coulomb-friction"], most=1).causes


def test_a_page_of_many_diagnoses_needs_no_more_memory(quick: dict[str, str]) -> None:
    import resource

    def size() -> int:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * resource.getpagesize()

    if not Path("/proc/self/statm").exists():
        pytest.skip("no /proc here")
    log = {"t": np.arange(200) * 0.01, "force": np.ones(200), "speed": np.linspace(0.0, 1.0, 200)}
    log["force"][50:] = -1.0

    def some(count: int) -> None:
        for _ in range(count):
            fdiag.gap(CART, log, only=["input-gain"], most=1, threads=1, as_read=True).to_dict()

    some(5)
    before = size()
    some(20)
    assert size() - before < 20e6
