"""Whether a simulator is fit for a diagnosis, and what that will cost."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from . import _fdiag, _settings
from ._logs import Log, native
from .errors import InputError
from .simulators import Simulator, as_simulator

__all__ = ["Check", "Checked", "Cost", "check"]


@dataclass(frozen=True)
class Checked:
    """Something that was looked at."""

    what: str
    """What was looked at."""
    grade: str
    """`fine`, `doubt` (a diagnosis will run, but its user should know) or `broken` (it would go wrong)."""
    text: str
    """What was found."""


@dataclass(frozen=True)
class Cost:
    """What a diagnosis will cost, with logs as long as the run that was made."""

    what: str
    """Which one."""
    runs: int | None
    """Runs through the logs; `None` for equations."""
    seconds: float
    """Time, in s: with all workers at work, or on one thread."""


@dataclass(frozen=True)
class Check:
    """What was found out about a simulator. In a notebook it shows itself."""

    findings: tuple[Checked, ...]
    """Findings in the order in which they were made."""
    samples: int
    """Samples of a run."""
    run_seconds: float
    """Time of a whole run in one call, in s; NaN where no run goes through."""
    step_seconds: float
    """Time of a step, in s; NaN where it does not step."""
    precision: float
    """Relative precision of the outputs: about 1e-16 for double and 1e-7 for single precision."""
    costs: tuple[Cost, ...]
    """What a diagnosis will cost."""

    @property
    def grade(self) -> str:
        """The worst of all findings."""
        grades = [finding.grade for finding in self.findings]
        return next((grade for grade in ("broken", "doubt") if grade in grades), "fine")

    @property
    def is_broken(self) -> bool:
        """Whether a diagnosis would go wrong."""
        return self.grade == "broken"

    @property
    def doubts(self) -> tuple[Checked, ...]:
        """Findings that are not fine, the worst first."""
        return tuple(f for grade in ("broken", "doubt") for f in self.findings if f.grade == grade)

    def __str__(self) -> str:
        lines = [f"{f.grade:6}  {f.what}: {f.text}" for f in self.findings]
        lines += [self._time()] + [f"  {_time(c.seconds)}{_runs(c)} ({c.what})" for c in self.costs]
        return "\n".join(lines)

    def _time(self) -> str:
        text = f"A run of {self.samples} samples takes {_time(self.run_seconds)}"
        return text + ("; a diagnosis with such a log takes about" if self.costs else "")

    def _repr_html_(self) -> str:
        rows = "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in (f.grade, f.what, f.text)) + "</tr>"
            for f in self.findings
        )
        costs = "".join(f"<li>{_time(c.seconds)}{_runs(c)} ({html.escape(c.what)})</li>" for c in self.costs)
        return f"<table>{rows}</table><p>{self._time()}</p><ul>{costs}</ul>"


def _runs(cost: Cost) -> str:
    return "" if cost.runs is None else f" for {cost.runs} runs"


def _time(seconds: float) -> str:
    """A time in the unit that suits it.

    >>> _time(0.0123), _time(90.0), _time(9000.0)
    ('12.3 ms', '90 s', '2.5 h')
    """
    for limit, unit, size in ((1.0, "ms", 1e-3), (120.0, "s", 1.0), (7200.0, "min", 60.0)):
        if seconds < limit:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 3600.0:.3g} h"


def check(
    simulator: Any,
    log: Log | None = None,
    *,
    samples: int = 500,
    amplitude: float = 1.0,
    columns: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    sample_time: float | None = None,
) -> Check:
    """Runs a simulator and says what is wrong with it, next to a log or alone, and what a diagnosis will cost.

    Looked at are: whether runs are finite and repeatable and nothing is left of the run before; whether whole runs,
    steps and measurements agree; how precise outputs are; whether each parameter, initial state, input and port moves
    some output; units; and in the log whatever speaks against it. Of a patched simulator it is what lies beneath that
    is run.

    Parameters
    ----------
    simulator
        As `gap` takes it.
    log
        A log, as `gap` takes it: its inputs drive the simulator. Without it they are steps of random height.
    samples
        Samples of a run without a log.
    amplitude
        Inputs without a log are between minus and plus this, in their units.
    columns
        A column map: a TOML file, or a dict of the same keys.
    sample_time
        Time between the rows of arrays without a column of time, in s.

    Examples
    --------
    >>> found = check(CART, MONDAY)
    >>> found.grade, found.samples
    ('fine', 1000)
    """
    model = as_simulator(simulator)
    if int(samples) < 2:
        raise InputError(f"samples: expected at least 2, found {samples}")
    if not 0.0 < float(amplitude) < float("inf"):
        raise InputError(f"amplitude: expected a size above 0, found {amplitude}")
    mapped = _settings.columns(columns)
    logs = native(log, "log", sample_time, lambda: _settings.needed(model, mapped))
    settings = json.dumps({"columns": mapped})
    found = json.loads(
        _fdiag.check(model._native, logs, settings, int(samples), float(amplitude))
    )
    return _check(found)


def _check(found: dict[str, Any]) -> Check:
    findings = [Checked(*each) for each in found["findings"]]
    if found["trouble"] is not None:
        findings.append(Checked("trouble", "broken", found["trouble"]))
    elif found["note"] is not None and found["run"] is None:
        findings.append(Checked("trouble", "broken", found["note"]))
    run, steps, precision = (float("nan") if found[k] is None else found[k] for k in ("run", "steps", "precision"))
    return Check(
        findings=tuple(findings),
        samples=found["samples"],
        run_seconds=run,
        step_seconds=steps / found["samples"],
        precision=precision,
        costs=tuple(Cost(*each) for each in found["costs"]),
    )
