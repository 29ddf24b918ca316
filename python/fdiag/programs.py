"""Programs and FMUs as simulators."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from . import _fdiag, _stated
from ._stated import Entries, Uncertain
from .simulators import Simulator, rooms_of

__all__ = ["Fmu", "Process", "forbid_programs"]


# The command line of this package, wherever it is; not what is in the folder that a script runs in.
_COMMAND = f"""
import sys
sys.path = [path for path in sys.path if path] + [{str(Path(__file__).resolve().parent.parent)!r}]
from fdiag._command import main
main()
"""


def _host_fmus() -> None:
    """Each instance of an FMU is a process of its own, of the interpreter that runs this; in one without, none is."""
    if sys.executable:
        _fdiag.host_fmus([sys.executable, "-c", _COMMAND, "simulator", "serve"])


_host_fmus()


def forbid_programs() -> None:
    """Start no program and load no library that a model names, from now on and in this process.

    `Process`, `Fmu` and model files of these kinds end in `InputError` then, whoever wrote them. There is no way back.
    Objects and functions of Python are simulators as before: they are code of this program already.
    """
    _fdiag.forbid_programs()


class Process(Simulator):
    """A program that speaks the process protocol on its standard input and output.

    `inputs`, `outputs`, `parameters`, `states`, `ports` and `native_effects` may be left out where the program says them;
    `workers` run at once, and each answer may take `timeout` seconds.
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        name: str | None = None,
        directory: str | os.PathLike[str] = ".",
        workers: int = 1,
        timeout: float = 30.0,
        sample_time: float | None = None,
        inputs: Entries = None,
        outputs: Entries = None,
        parameters: Entries = None,
        states: Entries = None,
        ports: Entries = None,
        native_effects: Entries = None,
    ):
        head = {
            "version": 1,
            "kind": "process",
            "name": name,
            "command": [str(part) for part in command],
            "workers": int(workers),
            "timeout": float(timeout),
            "sample_time": None if sample_time is None else float(sample_time),
        }
        rooms = rooms_of(inputs, outputs, parameters, states, ports, native_effects)
        _of_file(self, _stated.toml(head, rooms), directory, name or Path(str(command[0])).stem)


class Fmu(Simulator):
    """An FMU for co-simulation (FMI 2.0 or 3.0).

    `uncertain` maps parameters to how well they are known, relative to their start values; `ports` are inputs at
    which forces may be added. Without `inputs` and `outputs` all real ones are meant. Each of `workers` instances is a
    process of its own, of `sys.executable`, and each of its answers may take `timeout` seconds, 600 if not given. With
    `in_process` it is loaded into this process, which ends when it crashes: where `sys.executable` is no Python.
    """

    def __init__(
        self,
        file: str | os.PathLike[str],
        *,
        uncertain: Mapping[str, float | Uncertain | Mapping[str, Any]] | None = None,
        inputs: Entries = None,
        outputs: Entries = None,
        states: Entries = None,
        ports: Entries = None,
        native_effects: Entries = None,
        sample_time: float | None = None,
        workers: int = 1,
        timeout: float | None = None,
        in_process: bool = False,
    ):
        path = Path(os.fspath(file)).resolve()
        head = {
            "version": 1,
            "kind": "fmu",
            "fmu": str(path),
            "workers": int(workers),
            "timeout": None if timeout is None else float(timeout),
            "in_process": bool(in_process),
            "sample_time": None if sample_time is None else float(sample_time),
        }
        parameters = {
            name: {"tolerance": float(known)} if isinstance(known, (int, float)) else known
            for name, known in (uncertain or {}).items()
        }
        rooms = rooms_of(inputs, outputs, parameters, states, ports, native_effects)
        _of_file(self, _stated.toml(head, rooms), path.parent, path.stem)


def _of_file(
    simulator: Simulator, text: str, directory: str | os.PathLike[str], name: str
) -> None:
    path = Path(directory).resolve() / f"{name}.toml"
    Simulator.__init__(simulator, _fdiag.Simulator.from_text(text, str(path)))
