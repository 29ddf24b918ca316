"""Estimators in the manner of scikit-learn: rows are samples in the order of time, features are inputs.

A prediction is a simulation through the inputs alone, from rest: it depends on the order of the rows, and on those
before.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from . import _fdiag
from ._gap import gap
from .errors import InputError
from .online import Trained, spec
from .result import Result
from .simulators import as_simulator

__all__ = ["CompensatedRegressor", "GapRegressor"]

Array = npt.NDArray[np.float64]


#: Samples that nothing is learned from.
LAST = 2


class CompensatedRegressor(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A linear model, with what it lacks learned as a bias term: Patton and Chen's compensation as a regressor.

    Learned is `bias(k) + a1 bias(k-1) + ... = b0 u(k) + ... + c` for each output; predicted is the model with that
    bias, both simulated from the inputs. Without a `model` the bias is all there is: a linear difference equation.

    Parameters
    ----------
    model
        A linear model file or its text, or `None`. Features are its inputs, targets its outputs, in its order and
        units.
    na, nb
        Past values of the bias, and values of each input, in the equation.
    delay
        Samples by which inputs act late.
    offset
        Whether there is a constant term.
    learning
        `"batch"`, or any other way of learning that a spec knows.
    sample_time
        Time between rows, in s; of a model with a sample time of its own, that.

    Attributes
    ----------
    theta_
        Parameters of the bias model, one list per output after the other, in scaled units.
    n_features_in_
        Number of inputs.
    """

    def __init__(
        self,
        model: str | None = None,
        *,
        na: int = 1,
        nb: int = 2,
        delay: int = 0,
        offset: bool = True,
        learning: str = "batch",
        sample_time: float = 1.0,
    ):
        self.model = model
        self.na = na
        self.nb = nb
        self.delay = delay
        self.offset = offset
        self.learning = learning
        self.sample_time = sample_time

    def fit(self, X: npt.ArrayLike, y: npt.ArrayLike) -> CompensatedRegressor:
        """Learns the bias from a healthy run: inputs `X` `[samples, inputs]`, outputs `y` `[samples]` or
        `[samples, outputs]`."""
        inputs, outputs = validate_data(
            self, X, y, multi_output=True, y_numeric=True, dtype=np.float64, ensure_min_samples=2
        )
        self._is_single = outputs.ndim == 1
        outputs = np.asarray(outputs, dtype=np.float64).reshape(len(inputs), -1)
        self._learned_from = (inputs, outputs)
        self._train()
        return self

    def predict(self, X: npt.ArrayLike) -> Array:
        """Outputs of a run through the inputs `X` from rest, in the units of the model."""
        check_is_fitted(self)
        inputs = validate_data(self, X, reset=False, dtype=np.float64)
        rest = np.zeros((len(inputs), len(self._scale)))
        run = self._trained.pipeline().run(inputs, rest)
        y = rest - run.compensated * self._scale
        return y[:, 0] if self._is_single else y

    def _train(self) -> None:
        inputs, outputs = self._learned_from
        text = _black_box(inputs, outputs, self.sample_time) if self.model is None else str(self.model)
        trained = _trained(text, inputs, outputs, self._spec(), self.sample_time)
        # Residuals are in scaled units.
        one = np.ones((1, outputs.shape[1]))
        u = inputs[:1]
        there, here = (trained.pipeline().run(u, k * one).residual for k in (1.0, 0.0))
        self._scale: Array = 1.0 / (there - here)[0]
        self._trained: Trained = trained
        self.theta_ = trained.theta

    def _spec(self) -> str:
        orders = f'kind = "fixed", na = {int(self.na)}, nb = {int(self.nb)}, delay = {int(self.delay)}'
        offset = "true" if self.offset else "false"
        return f"""
            settle_s = 0.0
            generator = {{ kind = "simulation" }}
            bias.orders = {{ {orders}, offset = {offset} }}
            bias.learning = {{ kind = {json.dumps(self.learning)} }}
            detector = {{ kind = "maximum", margin = 0.1 }}
        """

    def __getstate__(self) -> dict[str, Any]:
        state: dict[str, Any] = dict(super().__getstate__())
        # What is in Rust is learned again from what it was learned from: the same, to the bit.
        state.pop("_trained", None)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        if "_learned_from" in state:
            self._train()


class GapRegressor(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A simulator whose gap to reality is closed by the effect that a diagnosis names.

    Parameters
    ----------
    simulator
        As `fdiag.gap` takes it. Features are its inputs, targets its outputs, in its order and units.
    settings
        Further settings of `fdiag.gap`, such as `{"only": ["coulomb-friction"]}`.

    Attributes
    ----------
    result_
        What the diagnosis says.
    """

    def __init__(self, simulator: Any = None, *, settings: dict[str, Any] | None = None):
        self.simulator = simulator
        self.settings = settings

    def fit(self, X: npt.ArrayLike, y: npt.ArrayLike) -> GapRegressor:
        """Diagnoses a run: inputs `X` `[samples, inputs]`, outputs `y` `[samples]` or `[samples, outputs]`."""
        simulator = as_simulator(self.simulator)
        inputs, outputs = validate_data(self, X, y, multi_output=True, y_numeric=True, dtype=np.float64)
        self._is_single = outputs.ndim == 1
        outputs = np.asarray(outputs, dtype=np.float64).reshape(len(inputs), -1)
        log: dict[str, Array] = {}
        for what, channels, columns in (
            ("X", simulator.inputs, inputs),
            ("y", simulator.outputs, outputs),
        ):
            if len(channels) != columns.shape[1]:
                raise InputError(
                    f"{what}: expected {len(channels)} columns, one per channel of the simulator, found "
                    f"{columns.shape[1]}"
                )
            log |= {channel.name: columns[:, i] for i, channel in enumerate(channels)}
        settings = {"sample_time": simulator.sample_time, **(self.settings or {})}
        self.result_: Result = gap(simulator, log, **settings)
        self._closed = self.result_.patched() if self.result_.verdict != "no-gap" else simulator
        return self

    def predict(self, X: npt.ArrayLike) -> Array:
        """Outputs of a run through the inputs `X` from the nominal start, in the units of the channels."""
        check_is_fitted(self)
        inputs = validate_data(self, X, reset=False, dtype=np.float64)
        y = self._closed.simulate(inputs)
        return y[:, 0] if self._is_single else y


def _trained(text: str, inputs: Array, outputs: Array, description: str, ts: float) -> Trained:
    names = _names(text, inputs.shape[1], outputs.shape[1])
    columns = [*inputs.T, *outputs.T]
    log = {name: np.ascontiguousarray(column) for name, column in zip(names, columns)}
    # A threshold is set by the last samples, and nobody asks for it here.
    share = 1.0 - min(LAST, 0.3 * len(inputs)) / len(inputs)
    return spec(text, log, description, learn_share=share, sample_time=ts)


def _names(text: str, inputs: int, outputs: int) -> list[str]:
    """Names of the channels of a linear model, inputs and then outputs."""
    file = "model.toml"
    if "\n" not in text:
        file, text = text, Path(text).read_text(encoding="utf-8")
    names = _fdiag.linear_channels(text, file)
    for what, found, expected in (("X", inputs, names[0]), ("y", outputs, names[1])):
        if found != len(expected):
            raise InputError(
                f"{what}: expected {len(expected)} columns, one per channel of the model, found {found}"
            )
    return names[0] + names[1]


def _black_box(inputs: Array, outputs: Array, ts: float) -> str:
    """A model that says nothing, about the mean of the run and in parts of its spread."""
    lines = ['version = 1\nkind = "state-space"\nname = "nothing"', f"sample_time = {float(ts)!r}"]
    for room, letter, columns in (("inputs", "u", inputs), ("outputs", "y", outputs)):
        for i, column in enumerate(columns.T):
            spread = float(np.std(column))
            scale = spread if spread > 1e-12 * max(1.0, float(np.max(np.abs(column)))) else 1.0
            lines.append(
                f'[[{room}]]\nname = "{letter}{i + 1}"\noperating_point = {float(np.mean(column))!r}\nscale = {scale!r}'
            )
    nu, ny = inputs.shape[1], outputs.shape[1]
    lines.append('[[states]]\nname = "none"')
    lines.append(f"[matrices]\nA = [[0.0]]\nB = [{[0.0] * nu}]\nC = {[[0.0]] * ny}")
    return "\n".join(lines) + "\n"
