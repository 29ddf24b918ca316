"""What several tests need."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
QUICK = ROOT / "examples" / "gap" / "quick-start"

#: A cart whose rail has a site for forces, as people write it.
CART = (QUICK / "model.toml").read_text(encoding="utf-8")

#: Few effects, so that a diagnosis takes a second.
FEW = ["coulomb-friction", "viscous-friction", "input-delay", "input-gain"]


@pytest.fixture(scope="session")
def quick() -> dict[str, str]:
    """Files of the quick start."""
    return {name: str(QUICK / f"{name}.csv") for name in ("monday", "friday")} | {
        "model": str(QUICK / "model.toml")
    }


def columns(path: str) -> dict[str, np.ndarray]:
    """A CSV of the quick start as a dict of arrays."""
    with open(path, encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    header = [cell.strip() for cell in lines[0].split(",")]
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    return {name: rows[:, i].copy() for i, name in enumerate(header)}


@pytest.fixture(scope="session")
def logs(quick: dict[str, str]) -> list[dict[str, np.ndarray]]:
    """Both logs of the quick start in memory."""
    return [columns(quick["monday"]), columns(quick["friday"])]


@pytest.fixture(scope="session")
def short(logs: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """The beginning of a log, for simulators that step in Python."""
    return {name: values[:400] for name, values in logs[0].items()}


class Cart:
    """The cart of the quick start as an object, exact for inputs that are held."""

    sample_time = 0.01
    inputs = {"force": "N"}
    outputs = {"speed": {"unit": "m/s", "noise": 0.004}}
    parameters = {
        "m": {"value": 1.2, "tolerance": 0.03, "unit": "kg"},
        "d": {"value": 1.5, "tolerance": 0.1, "unit": "N s/m"},
    }
    initial = {"v": {"unit": "m/s"}}
    ports = {"rail": {"unit": "N", "velocity": "speed"}}
    name = "cart"

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        self.m, self.d, self.v = parameters["m"], parameters["d"], x0["v"]

    def measure(self, u: np.ndarray) -> float:
        return self.v

    def step(self, u: np.ndarray, f: np.ndarray) -> float:
        shown = self.v
        aim = (u[0] + f[0]) / self.d
        self.v = aim + (self.v - aim) * float(np.exp(-self.d / self.m * 0.01))
        return shown


@pytest.fixture(scope="session")
def mass(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU that is compiled here, unpacked: a mass on a spring, of the tests of the Rust side."""
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None or platform.system() != "Linux" or platform.machine() != "x86_64":
        pytest.skip("FMUs are compiled on Linux with a C compiler")
    source = ROOT / "crates" / "fd-sim" / "tests" / "suite" / "fmu"
    folder = tmp_path_factory.mktemp("fmu") / "mass"
    library = folder / "binaries" / "linux64" / "mass.so"
    library.parent.mkdir(parents=True)
    shutil.copy(source / "mass.xml", folder / "modelDescription.xml")
    macros = ['-DVERSION="2.0"', "-DFAULT=3"]
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, *macros, source / "mass.c"], check=True)
    return folder


def binary() -> str | None:
    """The command line, where it is built."""
    named = os.environ.get("FDIAG_BINARY")
    if named:
        return named
    built = ROOT / "target" / "debug" / "fdiag"
    return str(built) if built.exists() else None
