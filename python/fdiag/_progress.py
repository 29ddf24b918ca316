"""How far a diagnosis is."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from .errors import Error

#: What can be asked for: nothing, a bar, or a call of one's own with the stage, what is done, and of how much.
Progress = bool | Callable[[str, int, int], object] | None


class Bar:
    """One bar of tqdm per stage."""

    def __init__(self, tqdm: Any):
        self._tqdm = tqdm
        self._bar: Any = None
        self._stage = ""

    def __call__(self, stage: str, done: int, pieces: int) -> None:
        if self._bar is None or stage != self._stage or pieces != self._bar.total:
            self.close()
            self._bar, self._stage = self._tqdm(total=pieces, desc=stage, leave=False), stage
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Takes the bar away."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


def shown(progress: Progress) -> Callable[[str, int, int], object] | None:
    """What is called. Without a wish there is a bar where somebody looks and tqdm is there."""
    if callable(progress):
        return progress
    if progress is False or (progress is None and not sys.stderr.isatty()):
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError as error:
        if progress is None:
            return None
        raise Error("progress: expected tqdm to be installed: pip install tqdm") from error
    return Bar(tqdm)
