"""What to run next on the real system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ._frames import frame
from .result import Result

__all__ = ["Experiment", "next_experiment"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Experiment:
    """Inputs to run, and what they are for."""

    name: str
    """What kind of input it is, in words."""
    statement: str
    """What it would tell apart, in words."""
    is_enough: bool
    """Whether it would separate all of `between`; if not, it is the one that would tell the most."""
    between: tuple[str, ...]
    """What is to be told apart, the most probable first."""
    distance: float
    """By how many squares of the noise it would separate them, the new log together with the present ones; 9 are
    needed."""
    now: float
    """By how many the present logs do."""
    sensor: str | None
    """A state that is to be measured as well; `None` for none."""
    sample_time: float
    """Time between samples of the inputs, in s."""
    faster: int
    """How many times faster outputs are to be sampled."""
    units: dict[str, str]
    """Units of the inputs."""
    signals: dict[str, Array]
    """`time` in s, and each input in its unit, sample by sample, as `gap` takes a log."""

    def to_frame(self, library: str | None = None) -> Any:
        """The signals as a data frame, one row per sample: of pandas if it is there, else of polars, or of the
        `library` that is named. Units stand behind names, as a log has them."""
        units = {"time": "s", **self.units}
        return frame({f"{name} [{units[name]}]": values for name, values in self.signals.items()}, library)


def next_experiment(result: Result) -> Experiment | None:
    """The inputs to run next, so that causes which the logs cannot tell apart are told apart.

    Each kind of input was simulated with the causes that are left, within the range of the logged inputs (one with
    twice the amplitude), refitted to what each other predicts. `None` where there is nothing to separate: the answer
    is clear, or no known cause explains the logs; `result.next` says what else there is to do.

    >>> from fdiag import gap
    >>> next_experiment(gap(CART, MONDAY, only=["coulomb-friction"], most=1)) is None
    True
    """
    planned = result._study.experiment()
    advice = result._report["advice"]
    if planned is None or advice is None:
        return None
    which, ts, rows = planned
    tried = advice["tried"][which]
    made = tried["experiment"]
    distances = [float("inf") if d is None else float(d) for d in tried["distances"]]
    channels = result._inputs
    time = np.arange(len(rows), dtype=np.float64) * np.float64(ts)
    signals = {name: np.ascontiguousarray(rows[:, i]) for i, (name, _) in enumerate(channels)}
    return Experiment(
        name=made["name"],
        statement=advice["statement"],
        is_enough=advice["best"] is not None,
        between=tuple(advice["names"]),
        distance=min(distances),
        now=float("inf") if advice["now"] is None else float(advice["now"]),
        sensor=made["sensor"] and made["sensor"]["state"],
        sample_time=ts,
        faster=int(made["faster"]),
        units=dict(channels),
        signals={"time": time, **signals},
    )
