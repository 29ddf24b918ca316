"""What people do today: fit all uncertain numbers of the scene, and all that lie dormant in it, at once, and see which
has moved most. By CMA-ES (Hansen 2001; package `cma`), and by the least squares of `mujoco.sysid`, where these are
installed, on the same rows and with the same weights as the diagnosis."""

from __future__ import annotations

import contextlib
import io
import time
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

from fdiag._natives import effects
from fdiag._parts import Part, parameter_path
from robots import Scene
from withheld import Array, Truth

METHODS = ("cma", "sysid")
#: Kinds of change that a number of the scene can express.
EXPRESSED = ("friction", "damping", "armature", "spring", "payload", "gain")


class Fit:
    """The misfit of a log as a function of all numbers of a scene that may be off, each in units of its size."""

    def __init__(self, scene: Scene, log: dict[str, Array]):
        self.model = scene.spec().compile()
        self.pristine = scene.spec().compile()
        self.data = mujoco.MjData(self.model)
        if scene.keyframe is not None:
            mujoco.mj_resetDataKeyframe(self.model, self.data, self.model.key(scene.keyframe).id)
        size = mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self.start = np.empty(size)
        mujoco.mj_getState(self.model, self.data, self.start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self.parts: list[Part] = []
        self.names: list[str] = []
        self.neutral, self.size, low, high = [], [], [], []
        known = set()
        for text, tolerance in scene.uncertain.items():
            path = parameter_path(self.model, text)
            value = float(path.array(self.model)[path.index])
            known.add((path.kind, path.name, path.field))
            self._add(path, f"{path.kind}/{path.name}.{path.field}", value, tolerance * value)
            # Ten tolerances: what is fitted here is also what is looked for.
            low.append(max(0.01 * value, value * (1.0 - 10.0 * tolerance)))
            high.append(value * (1.0 + 10.0 * tolerance))
        joints = {joint: int(self.model.joint(joint).dofadr[0]) for joint in scene.joints}
        for part, entry in effects(self.model, joints, {j: j for j in joints}, scene.inputs, {}, known, "all"):
            self._add(part, f"{entry['label']}@{entry['place']}", entry["value"], entry["size"])
            low.append(entry["bounds"][0])
            high.append(entry["bounds"][1])
        neutral, unit = np.array(self.neutral), np.array(self.size)
        self.bounds = (np.array(low) - neutral) / unit, (np.array(high) - neutral) / unit
        self.substeps = round(scene.sample_time / self.model.opt.timestep)
        u = np.column_stack([log[name] for name in scene.inputs])
        self.control = np.repeat(u, self.substeps, axis=0)
        self.y = np.column_stack([log[name] for name in scene.outputs])
        self.noise = np.array([output.noise for output in scene.outputs.values()])
        self.places = [_sensor(self.model, name) for name in scene.outputs]
        self.fitted = 2 * len(u) // 3
        self.runs = 0

    def _add(self, part: Part, name: str, value: float, size: float) -> None:
        self.parts.append(part)
        self.names.append(name)
        self.neutral.append(value)
        self.size.append(size)

    def residuals(self, x: Array) -> Array:
        """Weighted errors of all rows; large where the run diverges."""
        self.runs += 1
        values = np.array(self.neutral) + np.array(self.size) * np.clip(x, *self.bounds)
        for part, value in zip(self.parts, values):
            part.set(self.model, float(value), self.pristine)
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))
        _, sensed = rollout.rollout(self.model, self.data, self.start, self.control)
        shown = sensed[0, :: self.substeps, self.places].T
        left = (shown - self.y) / self.noise
        return np.where(np.isfinite(left), np.clip(left, -1e4, 1e4), 1e4)

    def relative(self, x: Array) -> Array:
        """How far each number has moved, relative to its value; where that is zero, as it is of what lies dormant, to
        the size that is noticed."""
        moved = np.array(self.size) * np.abs(np.clip(x, *self.bounds))
        own = np.abs(np.array(self.neutral))
        return moved / np.where(own > 0.0, own, self.size)

    def misfit(self, x: Array) -> float:
        return float(np.mean(self.residuals(x)[: self.fitted] ** 2))


def _sensor(model: Any, name: str) -> int:
    sensor, _, number = name.rstrip("]").partition("[")
    return int(model.sensor(sensor).adr[0]) + int(number or 0)


def fitted(scene: Scene, truth: Truth, log: dict[str, Array], evaluations: int, seed: int) -> dict[str, Any]:
    """What each baseline finds: the number that moved most, and the error on the rows that it has not seen."""
    found: dict[str, Any] = {}
    for method, fit in (("cma", by_cma), ("sysid", by_sysid)):
        task = Fit(scene, log)
        begun = time.perf_counter()
        x = fit(task, evaluations, seed)
        if x is None:
            continue
        runs, seconds = task.runs, time.perf_counter() - begun
        left = task.residuals(x)[task.fitted :]
        most = task.names[int(np.argmax(task.relative(x)))]
        found[method] = {
            "most": most,
            "judged": "right" if most in truth.names | _parameters(truth) else "wrong",
            "held": float(np.sqrt(np.mean(left**2))),
            "runs": runs,
            "seconds": seconds,
            "numbers": len(x),
        }
    return found


def _parameters(truth: Truth) -> set[str]:
    """A damping that is uncertain is a parameter of the joint, not a dormant number."""
    prefix = "viscous-friction@"
    return {f"joint/{name.removeprefix(prefix)}.damping" for name in truth.names if name.startswith(prefix)}


def by_cma(task: Fit, evaluations: int, seed: int) -> Array | None:
    try:
        import cma
    except ImportError:
        return None
    bounds = [end.tolist() for end in task.bounds]
    options = {"maxfevals": evaluations, "seed": seed % 2**31 + 1, "verbose": -9, "bounds": bounds}
    x, _ = cma.fmin2(task.misfit, np.zeros(len(task.parts)), 0.3, options)
    return np.asarray(x)


def by_sysid(task: Fit, evaluations: int, seed: int) -> Array | None:
    from mujoco import sysid

    if not hasattr(sysid, "optimize"):
        return None
    names = [f"{i}" for i in range(len(task.parts))]
    low, high = task.bounds
    start = sysid.ParameterDict(
        {name: sysid.Parameter(name, 0.0, float(low[i]), float(high[i])) for i, name in enumerate(names)}
    )

    # What lies dormant is at its bound, where it says that it may stall: off it by a tenth of a size, for the ranges
    # are of a hundred sizes.
    start.move_off_bounds(fraction=1e-3)

    def residual(x: Array, _: Any) -> tuple[list[Array], None, None]:
        # One column per point: it asks for finite differences all at once.
        points = np.atleast_2d(x.T) if x.ndim == 2 else x[None]
        columns = [task.residuals(point)[: task.fitted].ravel() for point in points]
        return [np.column_stack(columns) if x.ndim == 2 else columns[0]], None, None

    # An iteration costs a run per number and a few more.
    most = max(3, evaluations // (len(names) + 2))
    # It tells of every iteration, whatever it is told.
    with contextlib.redirect_stdout(io.StringIO()):
        best, _ = sysid.optimize(start, residual, optimizer="mujoco", verbose=False, max_iters=most)
    return best.as_vector()
