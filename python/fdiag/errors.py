"""Exceptions. A message says what, where, expected and found."""

from __future__ import annotations

__all__ = ["AnalysisError", "Diverged", "Error", "InputError", "SimulatorError"]


class Error(Exception):
    """Anything that `fdiag` says no to."""


class InputError(Error, ValueError):
    """A model, a log or a setting is missing or wrong."""


class AnalysisError(Error, ValueError):
    """The data or the model do not allow what was asked."""


class SimulatorError(Error, RuntimeError):
    """A simulator of yours has raised an exception (its `__cause__`), or does not do what it should."""


class Diverged(ArithmeticError):
    """Raised by a simulator: at these parameters there are no numbers from here on.

    A diagnosis then looks elsewhere. So it does for every `ArithmeticError` (a division by zero, an overflow) and
    for outputs that are not finite. After a `ConnectionError` another simulator makes the run again; any other exception
    ends the diagnosis.
    """
