"""Every example of the documentation and of the doc strings runs; stubs are those of the module."""

from __future__ import annotations

import doctest
import importlib
import importlib.util
import pkgutil
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import CART, ROOT, columns

import fdiag

FLAGS = doctest.ELLIPSIS

LAG = """
version = 1
kind = "equations"
name = "lag"
sample_time = 0.1
inputs = { u = { unit = "N" } }
states = { x = { unit = "m", initial = 0.0, derivative = "u - x" } }
outputs = { y = { unit = "m", value = "x" } }
"""


def modules() -> list[str]:
    names = [name for _, name, _ in pkgutil.iter_modules(fdiag.__path__) if name != "_fdiag"]
    if importlib.util.find_spec("sklearn") is None:
        names.remove("sklearn")
    return ["fdiag", *(f"fdiag.{name}" for name in names)]


@pytest.mark.parametrize("name", modules())
def test_doc_strings(name: str, quick: dict[str, str]) -> None:
    known = {"CART": CART, "LAG": LAG, "MONDAY": quick["monday"], "FRIDAY": quick["friday"]}
    result = doctest.testmod(importlib.import_module(name), extraglobs=known, optionflags=FLAGS)
    assert result.failed == 0


def test_some_doc_strings_have_examples() -> None:
    finder = doctest.DocTestFinder()
    found = [t for m in modules() for t in finder.find(importlib.import_module(m)) if t.examples]
    assert len(found) >= 7


def test_every_public_name_is_documented() -> None:
    missing = []
    for name in fdiag.__all__:
        item = getattr(fdiag, name)
        if not isinstance(item, str) and not (item.__doc__ or "").strip():
            missing.append(name)
        for member in vars(item) if isinstance(item, type) else ():
            part = getattr(item, member)
            if not member.startswith("_") and callable(part) and not (part.__doc__ or "").strip():
                missing.append(f"{name}.{member}")
    assert not missing


def test_the_guide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    guide = ROOT / "docs" / "python.md"
    # A fence ends an example.
    text = guide.read_text(encoding="utf-8").replace("```", "\n")
    test = doctest.DocTestParser().get_doctest(text, {}, "python.md", str(guide), 0)
    assert len(test.examples) > 20
    result = doctest.DocTestRunner(optionflags=FLAGS).run(test)
    assert result.failed == 0


def test_the_example_names_its_cause(capsys: pytest.CaptureFixture[str]) -> None:
    result = runpy.run_path(str(ROOT / "examples" / "python" / "pendulum.py"))["main"]()
    assert result.causes[0].name == "input-delay@torque", result.headline
    delay = result.causes[0].parameters[0]
    assert delay.unit == "s" and abs(delay.value - 0.06) < 0.005
    assert result.headline in capsys.readouterr().out


@pytest.mark.parametrize(
    "command", [["mypy.stubtest", "fdiag._fdiag"], ["mypy", "fdiag"]], ids=lambda c: c[0]
)
def test_types(command: list[str], tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    settings = ["--config-file", str(ROOT / "python" / "pyproject.toml")]
    # Sources are checked where they are written, stubs against the module that is installed.
    folder = ROOT / "python"
    if command[0] == "mypy.stubtest":
        settings, folder = ["--mypy-config-file", settings[1]], tmp_path
    else:
        settings += ["--cache-dir", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-m", *command, *settings], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_columns_of_the_quick_start_are_read_right(quick: dict[str, str]) -> None:
    assert len(columns(quick["monday"])["speed [m/s]"]) == 1000


def test_the_command_comes_with_the_package() -> None:
    """`fdiag` runs in the process of Python, with the exit codes of the program."""

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        line = [sys.executable, "-m", "fdiag._command", *arguments]
        return subprocess.run(line, capture_output=True, text=True, check=False)

    assert run("--version").stdout.startswith("fdiag ")
    wrong = run("gap", "--modle", "cart.toml")
    assert wrong.returncode == 2 and "--model" in wrong.stderr, wrong
    missing = run("gap", "--model", "gone.toml", "--log", "gone.csv")
    assert missing.returncode == 3 and "gone.toml" in missing.stderr, missing
