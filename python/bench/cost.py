"""What the Python side costs, in processor time, so that other work on the machine counts little.

    python python/bench/cost.py memory --diagnoses 100
    python python/bench/cost.py steps
    python python/bench/cost.py ray --tasks 400
    python python/bench/cost.py spread
    python python/bench/cost.py wait --seconds 1

`memory`: resident memory of one process after every tenth diagnosis, which alternate between a model file and an object
of Python. `steps`: a sample of a run through `fdiag`, less what the object, or `mj_step`, takes by itself. `ray`: tasks
that do nothing, and how long until all answers are in their files, in one process and by two workers of Ray. `spread`:
runs, and a diagnosis, of a simulator in this process, and of the same one spread over actors of Ray. `wait`: diagnoses of
simulators that wait in each run, which takes no processor, by 1, 2, 4 and 8 actors.
"""

from __future__ import annotations

import argparse
import gc
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import fdiag
import fdiag.ray
from fdiag import jobs

QUICK = Path(__file__).resolve().parents[2] / "examples" / "gap" / "quick-start"
FEW = ["coulomb-friction", "viscous-friction", "input-delay", "input-gain"]


class Lag:
    """As little as an object can do: one state, no port that matters."""

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        self.x = 0.0

    def measure(self, u: np.ndarray) -> float:
        return self.x

    def step(self, u: np.ndarray, f: np.ndarray) -> float:
        shown = self.x
        self.x += 0.1 * (u[0] + f[0] - shown)
        return shown


def lag() -> fdiag.Steps:
    return fdiag.Steps(
        Lag,
        sample_time=0.01,
        inputs={"u": "N"},
        outputs={"y": {"unit": "m/s", "noise": 0.01}},
        ports={"rail": {"unit": "N", "velocity": "y"}},
    )


def resident() -> float:
    """MiB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def memory(diagnoses: int) -> None:
    random = np.random.default_rng(20261124)
    u = np.repeat(random.uniform(-3.0, 3.0, 20), 20)
    shown = lag().simulate(0.9 * u).ravel() + 0.01 * random.standard_normal(400)
    object_log = {"time": 0.01 * np.arange(400), "u": u, "y": shown}
    print("| diagnoses | resident memory, MiB |\n|---|---|")
    seen = []
    for done in range(diagnoses + 1):
        if done % 10 == 0:
            gc.collect()
            seen.append(resident())
            print(f"| {done} | {seen[-1]:.1f} |", flush=True)
        if done == diagnoses:
            break
        if done % 2:
            fdiag.gap(lag(), object_log, only=FEW, most=1)
        else:
            fdiag.gap(str(QUICK / "model.toml"), str(QUICK / "monday.csv"), only=FEW, most=1)
    half = len(seen) // 2
    slope = np.polyfit(10.0 * np.arange(len(seen) - half), seen[half:], 1)[0]
    print(f"\nSlope over the second half: {1024 * slope:.1f} KiB per diagnosis.")


def per_step(call: Callable[[float], object], steps: int, repeats: int = 9) -> float:
    """Microseconds of processor time, the median of several. Every call is another run: one that was made before is
    remembered."""
    call(1.0)
    found = []
    for repeat in range(1, repeats + 1):
        begun = time.process_time()
        call(1.0 + 1e-9 * repeat)
        found.append((time.process_time() - begun) / steps * 1e6)
    return statistics.median(found)


def steps() -> None:
    n = 20_000
    u = np.sin(0.01 * np.arange(n))
    row, force, own, simulator = u[:, None], np.zeros(1), Lag(), lag()

    def alone(factor: float) -> None:
        own.reset({}, {})
        for k in range(n):
            own.step(row[k], force)

    print("| simulator | through fdiag, us | by itself, us | overhead, us |\n|---|---|---|---|")
    through, itself = per_step(lambda factor: simulator.simulate(factor * u), n), per_step(alone, n)
    print(f"| a Python object of one state | {through:.2f} | {itself:.2f} | {through - itself:.2f} |")
    try:
        import mujoco
        from robots import SCENES
    except ImportError:
        print("mujoco is not installed")
        return
    for scene in SCENES:
        try:
            simulator, model = scene.simulator(), scene.spec().compile()
        except SystemExit as missing:
            print(missing)
            continue
        substeps, count = round(scene.sample_time / model.opt.timestep), 2_000
        home = scene.home(model) if scene.is_servo else np.zeros(len(scene.inputs))
        command = np.tile(home, (count, 1))
        data = mujoco.MjData(model)

        def bare(factor: float) -> None:
            if scene.keyframe is None:
                mujoco.mj_resetData(model, data)
            else:
                mujoco.mj_resetDataKeyframe(model, data, model.key(scene.keyframe).id)
            data.ctrl[:] = factor * (command[0] + 1e-3)
            mujoco.mj_step(model, data, substeps * count)

        through = per_step(lambda factor: simulator.simulate(factor * (command + 1e-3)), count)
        itself = per_step(bare, count)
        what = f"{scene.name}, a sample of {substeps} `mj_step`"
        print(f"| {what} | {through:.2f} | {itself:.2f} | {through - itself:.2f} |", flush=True)


def nothing(x: int) -> int:
    return x


def busy(x: int) -> float:
    """A tenth of a second of processor time."""
    end, total = time.process_time() + 0.1, 0.0
    while time.process_time() < end:
        total += float(np.sin(x))
    return total


def tasks(count: int) -> None:
    import ray

    asked = {f"job {i}": {"x": i} for i in range(count)}
    begun = time.perf_counter()
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    print(f"Start of Ray: {time.perf_counter() - begun:.1f} s.\n")
    print("| task | where | tasks | s | ms per task |\n|---|---|---|---|---|")
    for function, many in ((nothing, count), (busy, count // 10)):
        some = dict(list(asked.items())[:many])
        for where, run in (("one process", jobs.run), ("Ray, two workers", fdiag.ray.map)):
            with tempfile.TemporaryDirectory() as folder:
                begun = time.perf_counter()
                found = run(function, some, folder=folder)
                seconds = time.perf_counter() - begun
            assert all(outcome.is_ok for outcome in found)
            figures = f"{many} | {seconds:.2f} | {1e3 * seconds / many:.1f}"
            print(f"| {function.__name__} | {where} | {figures} |", flush=True)
    ray.shutdown()


def slow(seconds: float = 0.1) -> fdiag.Rollout:
    """A function whose runs wait: for a licence, a disk, a device. It takes no processor."""

    @fdiag.rollout(inputs=["u"], outputs=["y"], sample_time=0.1, parameters={"k": fdiag.Uncertain(1.0, 0.05)})
    def waits(parameters: dict[str, float], x0: dict[str, float], u: np.ndarray) -> np.ndarray:
        time.sleep(seconds)
        y, shown = np.empty((len(u), 1)), 0.0
        for k, value in enumerate(u[:, 0]):
            y[k, 0], shown = shown, shown + 0.1 * (parameters["k"] * value - shown)
        return y

    return waits


def wide(seconds: float = 0.1) -> fdiag.Rollout:
    """The same with many parameters: a filter of so many coefficients."""
    taps = {f"b{i}": fdiag.Uncertain(float(0.2 * 0.9**i), 0.05) for i in range(24)}

    @fdiag.rollout(inputs=["u"], outputs=["y"], sample_time=0.1, parameters=taps)
    def waits(parameters: dict[str, float], x0: dict[str, float], u: np.ndarray) -> np.ndarray:
        time.sleep(seconds)
        b = np.array(list(parameters.values()))
        return np.convolve(u[:, 0], b)[: len(u), None]

    return waits


class Waiting(Lag):
    """An object whose runs take so long to begin."""

    def __init__(self, seconds: float):
        self._seconds = seconds

    def reset(self, parameters: dict[str, float], x0: dict[str, float]) -> None:
        time.sleep(self._seconds)
        self.x = 0.0


def waiting(seconds: float) -> fdiag.Steps:
    return fdiag.Steps(
        lambda: Waiting(seconds),
        sample_time=0.01,
        inputs={"u": "N"},
        outputs={"y": {"unit": "m/s", "noise": 0.01}},
        ports={"rail": {"unit": "N", "velocity": "y"}},
    )


def wait(seconds: float) -> None:
    """Every actor has a thousandth of a processor, for it needs none."""
    import ray

    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    random = np.random.default_rng(20261126)
    u = np.repeat(random.uniform(-3.0, 3.0, 20), 20)
    late = np.concatenate([np.zeros(3), u[:-3]])
    noise = 0.01 * random.standard_normal(400)
    print("| what | actors | s | runs | s per run | gain |\n|---|---|---|---|---|---|")
    for what, make, real, ts in (
        ("whole runs", slow, slow(0.0).simulate(late).ravel(), 0.1),
        ("whole runs, 24 parameters", wide, wide(0.0).simulate(late).ravel(), 0.1),
        ("an object that steps", waiting, waiting(0.0).simulate(late).ravel(), 0.01),
    ):
        log, answers, first = {"time": ts * np.arange(400), "u": u, "y": real + noise}, [], 0.0
        for actors in (1, 2, 4, 8):
            simulator = fdiag.ray.Spread(lambda: make(seconds), actors=actors, cpus=0.001)
            # All of them are there before the clock runs.
            simulator.simulate([0.0])
            begun = time.perf_counter()
            result = fdiag.gap(simulator, log, most=1, noise={"y": 0.01})
            took, runs = time.perf_counter() - begun, result.work.made if result.work else 1
            first = first or took
            print(f"| {what} | {actors} | {took:.1f} | {runs} | {took / runs:.2f} | {first / took:.2f} |", flush=True)
            answers.append({key: value for key, value in result.to_dict().items() if key != "timing"})
        assert answers == 4 * answers[:1]
    ray.shutdown()


def spread() -> None:
    import ray

    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    n, u = 1000, np.sin(0.01 * np.arange(1000))
    print("| what | where | s | ms per run |\n|---|---|---|---|")

    def told(what: str, where: str, seconds: float, runs: int) -> None:
        print(f"| {what} | {where} | {seconds:.2f} | {1e3 * seconds / runs:.2f} |", flush=True)

    places: list[tuple[str, Callable[[Callable[[], fdiag.Simulator]], fdiag.Simulator]]] = [
        ("this process", lambda make: make())
    ]
    for actors in (1, 2, 4):
        s = "" if actors == 1 else "s"
        places.append((f"{actors} actor{s}", lambda make, a=actors: fdiag.ray.Spread(make, actors=a, cpus=0.25)))  # type: ignore[misc]
    for where, made in places[:2]:
        simulator = made(lag)
        simulator.simulate(u)
        begun = time.perf_counter()
        for repeat in range(50):
            simulator.simulate(u * (1.0 + 1e-9 * (repeat + 1)))
        told(f"runs of {n} samples", where, time.perf_counter() - begun, 50)
    random = np.random.default_rng(20261125)
    short = np.repeat(random.uniform(-3.0, 3.0, 20), 20)
    # An object with a port: half of what is asked are steps.
    shown = lag().simulate(0.9 * short).ravel() + 0.01 * random.standard_normal(400)
    stepped = {"time": 0.01 * np.arange(400), "u": short, "y": shown}
    late = np.concatenate([np.zeros(3), short[:-3]])
    whole = {"time": 0.1 * np.arange(400), "u": short, "y": slow().simulate(late).ravel()}
    whole["y"] = whole["y"] + 0.01 * random.standard_normal(400)
    answers = []
    for what, make, log, only in (
        ("diagnosis of an object that steps", lag, stepped, FEW),
        ("diagnosis of runs that wait 100 ms", slow, whole, ["input-delay", "input-gain", "sensor-delay"]),
    ):
        for where, made in places:
            simulator = made(make)
            simulator.simulate([0.0])
            begun = time.perf_counter()
            result = fdiag.gap(simulator, log, only=only, most=1, noise={"y": 0.01}, threads=4)
            told(what, where, time.perf_counter() - begun, result.work.made if result.work else 1)
            answers.append({key: value for key, value in result.to_dict().items() if key != "timing"})
    assert answers[:4] == 4 * answers[:1] and answers[4:] == 4 * answers[4:5]
    ray.shutdown()


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("what", choices=("memory", "steps", "ray", "spread", "wait"))
    asked.add_argument("--diagnoses", type=int, default=100)
    asked.add_argument("--tasks", type=int, default=400)
    asked.add_argument("--seconds", type=float, default=1.0, help="how long a run waits")
    arguments = asked.parse_args()
    if arguments.what == "memory":
        memory(arguments.diagnoses)
    elif arguments.what == "steps":
        steps()
    elif arguments.what == "spread":
        spread()
    elif arguments.what == "wait":
        wait(arguments.seconds)
    else:
        tasks(arguments.tasks)


if __name__ == "__main__":
    main()
