"""Environments of gymnasium as simulators."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._names import nearest
from ._stated import Entries, Uncertain
from ._vector_env import VectorSteps, endless_autoreset, number
from .errors import Diverged, Error, InputError
from .simulators import Opener, Simulator, lent, rooms_of

__all__ = ["Gymnasium"]

Array = npt.NDArray[np.float64]
#: Sets the states of an environment: called with the environment and `initial` by name.
SetState = Callable[[Any, dict[str, float]], object]


class Gymnasium(Simulator):
    """An environment of gymnasium, by its id, as an object, or a function that makes one.

    Inputs are the entries of the action, outputs those of the observation, both as wrappers show them; names are given
    in their order (`"action"`, or `"action_1"` and so on, without). An output named `None` is not measured. An action
    of a `Discrete` space is one input, rounded.

    `uncertain` names attributes of the environment beneath all wrappers, with how well they are known, relative to the
    values that they have. `initial` names its states, in the order of its attribute `state` (classic control) or of
    positions and then velocities (MuJoCo); with `set_state(env, x0)` you say yourself how a start is set. Without
    `initial` each run begins where `reset(seed=seed)` puts it: the noise of a reset is the same in all runs.

    A vector of environments (`gymnasium.vector.SyncVectorEnv` and others, or one that is vectorised itself) makes as many
    runs at once as it has environments: each step of all of them is one call. All must be alike. `set_state` then gets
    arrays with an entry per environment, and returns the observations, if they are others then.

    Time limits are taken away. A run ends where the environment says `terminated`, unless `ignore_terminated`.
    `sample_time` is that of the environment (`dt`, `tau`) where it says one.
    """

    def __init__(
        self,
        env: Any,
        *,
        sample_time: float | None = None,
        inputs: Entries = None,
        outputs: Mapping[str, Any] | Sequence[str | None] | None = None,
        uncertain: Mapping[str, float | Uncertain] | None = None,
        initial: Entries = None,
        set_state: SetState | None = None,
        seed: int = 0,
        ignore_terminated: bool = False,
        name: str | None = None,
        workers: int = 1,
    ):
        made = _maker(env)
        if workers != 1 and not (isinstance(env, str) or _is_maker(env)):
            raise InputError("workers: expected 1 for a single environment, or a function that makes environments")
        first = _without_limit(made())
        lanes = int(getattr(first, "num_envs", 0))
        single = _single(first) if lanes else first
        base = single.unwrapped
        actions = _width("action", first.single_action_space if lanes else first.action_space)
        width = _width("observation", first.single_observation_space if lanes else first.observation_space)
        inputs = _default_names("action", actions) if inputs is None else inputs
        kept, shown = _shown(outputs, width)
        known = _parameters(first if lanes else base, uncertain or {})
        rooms = rooms_of(inputs, shown, known, initial, None)
        if len(rooms["inputs"]) != actions:
            found = len(rooms["inputs"])
            raise InputError(f"inputs: expected {actions} names, one per entry of the action, found {found}")
        ts = _sample_time(base) if sample_time is None else float(sample_time)
        states = [entry["name"] for entry in rooms["states"]]
        if lanes:
            setter = _vector_setter(first, single, states, set_state)
            if ignore_terminated:
                endless_autoreset(first)
        else:
            setter = _setter(base, states, set_state)
        parts = (kept, setter, int(seed), ignore_terminated)
        waiting = [first]
        steps: Any = VectorSteps if lanes else _Steps

        def opened() -> Any:
            # The one that was looked at is the first that runs.
            return steps(waiting.pop() if waiting else _without_limit(made()), *parts)

        native = lent(
            Opener(opened if workers != 1 or _is_maker(env) else lambda: steps(first, *parts)),
            {"step": True, "measure": True, "lanes": max(lanes, 1)},
            stacked=lanes or None,
            name=name or _title(first),
            sample_time=ts,
            rooms=rooms,
            takes_forces=False,
            workers=workers,
        )
        super().__init__(native)
        self._is_single = workers == 1 and not _is_maker(env)


class _Steps:
    """An environment as the native half asks for it."""

    def __init__(self, env: Any, kept: list[int], setter: SetState | None, seed: int, endless: bool):
        self._env, self._kept, self._setter = env, kept, setter
        self._seed, self._endless = seed, endless
        self._space = env.action_space
        self._seen: Array = np.zeros(len(kept))
        self._is_over = False

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        for name, value in parameters.items():
            setattr(self._env.unwrapped, name, value)
        # The same seed: whatever is drawn in a run is drawn the same way in each.
        seen, _ = self._env.reset(seed=self._seed)
        if x0 and self._setter is not None:
            self._setter(self._env, x0)
            seen = _observed(self._env)
        self._is_over = False
        self._see(seen)

    def measure(self, u: Array) -> Array:
        if self._is_over:
            raise Diverged("the environment has terminated")
        return self._seen

    def step(self, u: Array) -> Array:
        shown = self.measure(u)
        seen, _, terminated, _, _ = self._env.step(_action(self._space, u))
        self._is_over = bool(terminated) and not self._endless
        self._see(seen)
        return shown

    def _see(self, seen: Any) -> None:
        self._seen = _flat(seen)[self._kept]


def _flat(seen: Any) -> Array:
    return np.asarray(seen, dtype=np.float64).reshape(-1)


def _action(space: Any, u: Array) -> Any:
    if hasattr(space, "n"):
        action = int(np.rint(u[0])) - int(space.start)
        return int(space.start) + min(max(action, 0), int(space.n) - 1)
    return np.asarray(u, dtype=space.dtype).reshape(space.shape)


def _observed(env: Any) -> Any:
    """What the environment shows of the state that it is in, through its wrappers."""
    base = env.unwrapped
    look = getattr(base, "_get_obs", None)
    seen = look() if callable(look) else np.asarray(base.state, dtype=np.float64)
    layers = []
    while env is not base:
        layers.append(env)
        env = env.env
    for layer in reversed(layers):
        shown = getattr(layer, "observation", None)
        seen = shown(seen) if callable(shown) else seen
    return seen


def _setter(base: Any, states: list[str], said: SetState | None) -> SetState | None:
    if said is not None or not states:
        return said
    if callable(getattr(base, "set_state", None)) and hasattr(base, "init_qpos"):
        nq, nv = len(base.init_qpos), len(base.init_qvel)
        _count(states, nq + nv, f"{nq} positions and {nv} velocities of the scene")
        return lambda env, x0: env.unwrapped.set_state(
            np.array(list(x0.values())[:nq]), np.array(list(x0.values())[nq:])
        )
    base.reset(seed=0)
    state = getattr(base, "state", None)
    if state is None:
        raise InputError(
            f"initial: `{type(base).__name__}` has no attribute `state`: expected `set_state`, a function of the "
            "environment and a dict of its initial states"
        )
    _count(states, len(_flat(state)), "numbers of the attribute `state`")

    def set_array(env: Any, x0: dict[str, float]) -> None:
        env.unwrapped.state = np.array(list(x0.values()))

    return set_array


def _count(states: list[str], expected: int, what: str) -> None:
    if len(states) != expected:
        raise InputError(f"initial: expected {expected} names, the {what}, found {len(states)}")


def _parameters(base: Any, uncertain: Mapping[str, float | Uncertain]) -> dict[str, Uncertain]:
    all_of: dict[str, Uncertain] = {}
    for name, known in uncertain.items():
        value = number(base, name) if hasattr(base, "num_envs") else getattr(base, name, None)
        if not isinstance(value, (int, float, np.floating)) or isinstance(value, bool):
            numbers = [
                key
                for key, other in vars(base).items()
                if isinstance(other, (int, float, np.floating)) and not isinstance(other, bool) and key[0] != "_"
            ]
            raise InputError(
                f"uncertain: the environment has no number `{name}`{nearest(name, numbers)}"
            )
        all_of[name] = known if isinstance(known, Uncertain) else Uncertain(float(value), float(known))
    return all_of


def _shown(said: Mapping[str, Any] | Sequence[str | None] | None, width: int) -> tuple[list[int], Entries]:
    """Which entries of the observation are outputs, and their names."""
    if said is None:
        return list(range(width)), _default_names("observation", width)
    if isinstance(said, str):
        raise InputError(f"outputs: expected a list of names or a dict, found the text `{said}`")
    names: list[Any] = list(said)
    if len(names) != width:
        raise InputError(
            f"outputs: expected {width} names, one per entry of the observation (`None` for those that are "
            f"not measured), found {len(names)}"
        )
    kept = [i for i, name in enumerate(names) if name is not None]
    if isinstance(said, Mapping):
        return kept, said
    return kept, [names[i] for i in kept]


def _default_names(what: str, count: int) -> list[str]:
    return [what if count == 1 else f"{what}_{i + 1}" for i in range(count)]


def _width(what: str, space: Any) -> int:
    if hasattr(space, "n") and what == "action":
        return 1
    shape = getattr(space, "shape", None)
    if shape is None or type(space).__name__ != "Box":
        raise InputError(
            f"env: expected a space of numbers (`Box`) for the {what}, found `{type(space).__name__}`: "
            "flatten it with a wrapper"
        )
    return int(np.prod(shape))


def _sample_time(base: Any) -> float:
    for name in ("dt", "tau"):
        value = getattr(base, name, None)
        if isinstance(value, (int, float)) and value > 0.0:
            return float(value)
    raise InputError(
        f"sample_time: `{type(base).__name__}` has no attribute `dt` or `tau`: expected the seconds of a step"
    )


def _maker(env: Any) -> Callable[[], Any]:
    if isinstance(env, str):
        try:
            gym = importlib.import_module("gymnasium")
        except ImportError as error:
            raise Error("env: expected gymnasium to be installed: pip install gymnasium") from error
        try:
            gym.spec(env)
        except gym.error.Error as error:
            raise InputError(f"env: expected the id of an environment, found `{env}`: {error}") from error
        return lambda: gym.make(env, disable_env_checker=True)
    if _is_maker(env):
        return env  # type: ignore[no-any-return]
    if hasattr(env, "step") and hasattr(env, "reset") and hasattr(env, "unwrapped"):
        return lambda: env
    raise InputError(
        "env: expected an id, an environment, or a function that makes one, found a value of type "
        f"`{type(env).__name__}`"
    )


def _is_maker(env: Any) -> bool:
    return callable(env) and (isinstance(env, type) or not hasattr(env, "step"))


def _single(env: Any) -> Any:
    """One of a vector of environments, or the vector where it is vectorised itself."""
    envs = getattr(env, "envs", None)
    return envs[0] if envs else env


def _vector_setter(env: Any, single: Any, states: list[str], said: SetState | None) -> SetState | None:
    if said is not None or not states:
        return said
    if not getattr(env, "envs", None):
        raise InputError(
            f"initial: the environments in `{type(env).__name__}` cannot be reached: expected `set_state`, a function of "
            "it and a dict of arrays of initial states, which returns the observations"
        )
    setter = _setter(single.unwrapped, states, None)

    def set_each(env: Any, x0: dict[str, Any]) -> Any:
        for i, each in enumerate(env.envs):
            if setter is not None:
                setter(each, {name: float(column[i]) for name, column in x0.items()})
        return np.stack([_flat(_observed(each)) for each in env.envs])

    return set_each


def _without_limit(env: Any) -> Any:
    """The environment without the wrapper that ends it after some steps: logs are as long as they are."""
    if getattr(env, "envs", None):
        env.envs = type(env.envs)(_without_limit(each) for each in env.envs)
        return env
    return env.env if type(env).__name__ == "TimeLimit" else env


def _title(env: Any) -> str:
    spec = getattr(env, "spec", None)
    return str(spec.name if spec is not None else type(env.unwrapped).__name__)
