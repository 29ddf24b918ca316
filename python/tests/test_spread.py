"""One diagnosis by actors, in place of which are objects of this process: what is asked of them and what they answer,
without Ray. test_ray.py asks the same of actors in processes of their own."""

from __future__ import annotations

import sys
import types
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import spreads
from conftest import Cart

import fdiag
import fdiag.ray
from fdiag import _spread


class Lost(Exception):
    """As an actor that is gone is told."""


class Late(Exception):
    """As an actor that does not come is told."""


class Method:
    def __init__(self, method: Callable[..., Any]):
        self.remote = method


class Actor:
    """An object whose methods are asked as those of an actor are."""

    def __init__(self, host: type, arguments: tuple[Any, ...]):
        self._host = host(*arguments)

    def __getattr__(self, name: str) -> Method:
        return Method(getattr(self._host, name))


class Class:
    def __init__(self, host: type, made: list[Actor]):
        self._host, self._made = host, made

    def remote(self, *arguments: Any) -> Actor:
        self._made.append(Actor(self._host, arguments))
        return self._made[-1]


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[Actor]:
    """The actors that there are."""
    made: list[Actor] = []
    stand_in = types.SimpleNamespace(
        put=lambda value: value,
        get=lambda value, timeout=None: value,
        remote=lambda **options: lambda host: Class(host, made),
        exceptions=types.SimpleNamespace(RayActorError=Lost, GetTimeoutError=Late),
    )
    monkeypatch.setattr("fdiag._spread.started", lambda: stand_in)
    return made


@pytest.mark.parametrize("kind", spreads.KINDS)
def test_each_kind_of_simulator(kind: str, request: pytest.FixtureRequest, made: list[Actor]) -> None:
    spreads.is_the_same(kind, request)
    # Both did some of it.
    assert len(made) == 2


def test_an_object_that_says_what_it_is(made: list[Actor]) -> None:
    u = np.ones(20)
    spread = fdiag.ray.Spread(Cart, actors=3)
    assert np.array_equal(spread.simulate(u), fdiag.simulators.as_simulator(Cart()).simulate(u))
    assert len(made) == 1


class Node:
    """The package `ray`, whose node gives up so many times before it starts."""

    def __init__(self, failures: int, error: Exception):
        self.failures, self.error = failures, error
        self.settings: list[dict[str, Any]] = []

    def is_initialized(self) -> bool:
        return len(self.settings) > self.failures

    def init(self, **settings: Any) -> None:
        self.settings.append(settings)
        if len(self.settings) <= self.failures:
            raise self.error

    def shutdown(self) -> None:
        pass


def test_a_node_that_gives_up_is_started_again(monkeypatch: pytest.MonkeyPatch) -> None:
    late = Exception("The current node timed out during startup.")
    node = Node(2, late)
    monkeypatch.setitem(sys.modules, "ray", node)
    assert _spread.started(num_cpus=2) is node
    assert node.settings == [{"include_dashboard": False, "log_to_driver": False, "num_cpus": 2}] * 3
    # One that runs is not started again.
    assert _spread.started() is node and len(node.settings) == 3
    monkeypatch.setitem(sys.modules, "ray", Node(3, late))
    with pytest.raises(fdiag.Error, match="found 3 times: The current node timed out .* RAY_ADDRESS"):
        _spread.started()
    wrong = Node(1, ConnectionError("no cluster"))
    monkeypatch.setitem(sys.modules, "ray", wrong)
    with pytest.raises(ConnectionError):
        _spread.started()
    assert len(wrong.settings) == 1
