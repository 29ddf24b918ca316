"""Vector environments of gymnasium: many runs, stepped in one call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import InputError

Array = npt.NDArray[np.float64]


class VectorSteps:
    """A vector environment as the native half asks for it: everything has an axis of runs in front."""

    def __init__(
        self,
        env: Any,
        kept: list[int],
        setter: Callable[[Any, dict[str, Any]], object] | None,
        seed: int,
        endless: bool,
    ):
        self._env, self._kept, self._setter = env, kept, setter
        self._seed, self._endless = seed, endless
        self._runs = 0
        self._seen: Array = np.zeros((env.num_envs, len(kept)))
        self._is_over = np.zeros(env.num_envs, dtype=bool)

    def reset(self, parameters: dict[str, Array], x0: dict[str, Array], runs: int) -> None:
        self._runs = runs
        for name, column in parameters.items():
            set_number(self._env, name, self._padded(column))
        # The same seed for all: whatever is drawn in a run is drawn the same way in each.
        seen, _ = self._env.reset(seed=[self._seed] * self._env.num_envs)
        if x0 and self._setter is not None:
            shown = self._setter(self._env, {name: self._padded(column) for name, column in x0.items()})
            seen = seen if shown is None else shown
        self._is_over[:] = False
        self._see(seen)

    def measure(self, u: Array) -> Array:
        shown: Array = self._seen[: self._runs].copy()
        shown[self._is_over[: self._runs]] = np.nan
        return shown

    def step(self, u: Array) -> Array:
        shown = self.measure(u)
        space = self._env.action_space
        if hasattr(space, "nvec"):
            low = np.asarray(getattr(space, "start", 0)).reshape(-1)
            most = low + np.asarray(space.nvec).reshape(-1) - 1
            actions = np.clip(np.rint(self._padded(u)[:, 0]), low, most).astype(space.dtype)
        else:
            actions = self._padded(u).astype(space.dtype).reshape(space.shape)
        seen, _, terminated, truncated, _ = self._env.step(actions)
        if np.any(np.asarray(truncated)[: self._runs] & ~self._is_over[: self._runs]):
            raise InputError("env: expected no time limit in a vector of environments, found that it cuts a run off")
        if not self._endless:
            self._is_over |= np.asarray(terminated, dtype=bool)
        self._see(seen)
        return shown

    def _padded(self, values: Array) -> Array:
        """The values of the runs, the last one again for environments that are not needed."""
        return np.concatenate([values, np.repeat(values[-1:], self._env.num_envs - len(values), axis=0)])

    def _see(self, seen: Any) -> None:
        seen = np.asarray(seen, dtype=np.float64).reshape(self._env.num_envs, -1)
        self._seen = seen[:, self._kept]


def number(env: Any, name: str) -> Any:
    """An attribute of the environments, of the first where each has its own."""
    if callable(getattr(env, "get_attr", None)):
        try:
            return env.get_attr(name)[0]
        except AttributeError:
            return None
    return getattr(env.unwrapped, name, None)


def set_number(env: Any, name: str, column: Array) -> None:
    """Sets an attribute of each environment; of one that is vectorised itself, to an array."""
    if callable(getattr(env, "set_attr", None)):
        env.set_attr(name, [float(value) for value in column])
    else:
        setattr(env.unwrapped, name, column)


def endless_autoreset(env: Any) -> None:
    """Refuses environments that begin anew by themselves where runs are to go on after their end."""
    mode = getattr(env, "metadata", {}).get("autoreset_mode")
    if getattr(mode, "name", None) != "DISABLED":
        raise InputError(
            "ignore_terminated: expected a vector of environments with `autoreset_mode=AutoresetMode.DISABLED`, "
            f"found {mode}: runs would begin anew"
        )
