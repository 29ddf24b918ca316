"""The native half; not for users."""

from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "Hosted",
    "Pipeline",
    "SceneSteps",
    "Simulator",
    "Study",
    "Trained",
    "__version__",
    "calibrate",
    "check",
    "column_map",
    "command",
    "forbid_programs",
    "host_fmus",
    "linear_channels",
    "study",
]
__version__: str

_Array = npt.NDArray[np.float64]
_Log = str | tuple[str, list[tuple[str, _Array]]]

@final
class Simulator:
    @staticmethod
    def from_text(text: str, file: str | PathLike[str]) -> Simulator: ...
    @staticmethod
    def lent(
        stated: str, object: Any, takes_forces: bool, workers: int, stacked: int | None
    ) -> Simulator: ...
    def elsewhere(self, opener: Any, workers: int, lanes: int) -> Simulator: ...
    def hosted(self, more: Callable[[], Simulator] | None) -> Hosted: ...
    def described(self) -> str: ...
    def text(self) -> str: ...
    def handed_on(self) -> tuple[list[float], bool]: ...
    def simulate(
        self, u: _Array, parameters: list[float], initial: list[float], sample_time: float
    ) -> _Array: ...

@final
class Hosted:
    def ask(
        self,
        op: str,
        starts: _Array,
        rows: _Array,
        runs: int,
        samples: int,
        around: tuple[str, float] | None,
    ) -> tuple[_Array, _Array] | None: ...

_Part = tuple[_Array, list[int]]
_Shown = tuple[_Array, list[int], list[int]]

@final
class SceneSteps:
    def __new__(
        cls,
        functions: tuple[Callable[..., Any], Callable[..., Any]],
        model: Any,
        data: Any,
        time_steps: int,
        controls: _Part,
        forces: _Part,
        direct: list[_Shown],
        sensed: list[_Shown],
        warm_start: _Array,
        states: tuple[_Part, _Part],
    ) -> SceneSteps: ...

@final
class Study:
    def json(self) -> str: ...
    def html(self) -> str: ...
    def picture(self, width: int, height: int) -> str | None: ...
    def tables(self) -> list[tuple[str, list[str], list[list[str]]]]: ...
    def models(self) -> list[tuple[str, str]]: ...
    def patched(self, file: str, text: str) -> Simulator: ...
    def trace(self) -> tuple[str, _Array, list[dict[str, Any]]] | None: ...
    def experiment(self) -> tuple[int, float, _Array] | None: ...
    def work(self) -> tuple[tuple[int, int, int, int, int, int], float, str | None] | None: ...

@final
class Trained:
    def __new__(
        cls,
        text: str,
        file: str,
        spec: str,
        healthy: Sequence[_Log],
        learn_share: float,
        columns: str | None,
    ) -> Trained: ...
    def described(self) -> str: ...
    def pipeline(self, compensated: bool) -> Pipeline: ...

@final
class Pipeline:
    def step(
        self, u: _Array, y: _Array
    ) -> tuple[_Array, _Array, float, float, bool, bool, list[str]]: ...
    def run(self, u: _Array, y: _Array) -> dict[str, Any]: ...
    def reset(self) -> None: ...
    def snapshot(self) -> str: ...
    def restore(self, snapshot: str) -> None: ...

def study(
    simulator: Simulator,
    logs: Sequence[_Log],
    held_out: Sequence[_Log],
    settings: str,
    threads: int,
    progress: Callable[[str, int, int], object] | None,
    /,
) -> Study: ...
def calibrate(simulator: Simulator, logs: Sequence[_Log], settings: str, /) -> tuple[str, str]: ...
def check(
    simulator: Simulator,
    logs: Sequence[_Log],
    settings: str,
    samples: int,
    amplitude: float,
    /,
) -> str: ...
def forbid_programs() -> None: ...
def host_fmus(command: list[str]) -> None: ...
def command(arguments: list[str]) -> int: ...
def linear_channels(text: str, file: str, /) -> tuple[list[str], list[str]]: ...
def column_map(file: str | PathLike[str], /) -> str: ...
