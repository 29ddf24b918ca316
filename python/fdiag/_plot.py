"""Pictures with matplotlib."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from ._names import nearest
from .errors import Error, InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .result import Result


def _shown() -> type[Figure]:
    """A figure that a notebook shows, whether or not pyplot is there."""
    from matplotlib.figure import Figure

    class Shown(Figure):
        def _repr_png_(self) -> bytes:
            picture = io.BytesIO()
            self.savefig(picture, format="png")
            return picture.getvalue()

    return Shown


def plot(result: Result, output: str | int | None) -> Figure:
    """Each output, or the one that is named: measured, before, after."""
    try:
        kind = _shown()
    except ImportError as error:
        raise Error("plot: expected matplotlib to be installed: pip install matplotlib") from error
    trace = result.trace
    if trace is None:
        raise Error("plot: this diagnosis has no signals to show")
    chosen = list(trace.outputs)
    if isinstance(output, int):
        if not -len(chosen) <= output < len(chosen):
            raise InputError(f"plot: expected one of {len(chosen)} outputs, found {output}")
        chosen = [chosen[output]]
    elif output is not None:
        names = [signals.name for signals in chosen]
        if output not in names:
            raise InputError(f"plot: there is no output `{output}`{nearest(output, names)}")
        chosen = [chosen[names.index(output)]]
    figure = kind(figsize=(8, 2.6 * len(chosen) + 0.6), layout="constrained")
    axes = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for axis, signals in zip(axes, chosen):
        axis.plot(trace.time, signals.measured, label="measured", color="black", linewidth=1.0)
        axis.plot(trace.time, signals.before, label="simulated before", linewidth=1.0)
        axis.plot(trace.time, signals.after, label="simulated after", linewidth=1.0)
        axis.set_ylabel(f"{signals.name} [{signals.unit}]")
    axes[0].legend(loc="upper right")
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(result.headline, fontsize="small", wrap=True)
    return figure
