"""Logs of the Tennessee Eastman process (Downs and Vogel 1993), made in one command.

    pip install tep-studio==0.2.0
    python examples/tennessee/make_logs.py LOGS [--healthy 8] [--runs 3] [--workers 2]

The simulator is the revised model of Bathelt, Ricker and Jelali (2015) under Ricker's decentralised control
(1996) in mode 1; see its own licence (BSD 3-clause). A log has 48 h in samples of 3 min: 41 measurements
(`xmeas_*`) and 11 manipulated variables (`xmv_*`; the twelfth, the agitator, never moves). A disturbance begins
after 8 h. Every run has a seed of its own. Logs that exist already are kept; a run that trips ends there.
"""

import argparse
import concurrent.futures
import csv
import pathlib

import numpy as np
from tep_studio import ClosedLoopSimulation

STEP_H = 0.0005
SAMPLE_H = 0.05
HORIZON_H = 48.0
ONSET_H = 8.0


def run(path, seed, fault):
    """One run as a CSV file."""

    def disturbances(time_h):
        idv = np.zeros(28)
        if fault and time_h >= ONSET_H - 1e-9:
            idv[fault - 1] = 1.0
        return idv

    simulation = ClosedLoopSimulation(horizon=HORIZON_H, control_interval=STEP_H)
    result = simulation.run(
        seed=seed, disturbance_schedule=disturbances, record_every=round(SAMPLE_H / STEP_H)
    )
    header = ["time_s"] + [f"xmeas_{i}" for i in range(1, 42)] + [f"xmv_{i}" for i in range(1, 12)]
    part = path.with_suffix(".part")
    with part.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(header)
        for k, row in enumerate(result.results):
            # A trip adds a last sample off the time base.
            if k and row.shutdown_status["terminated"]:
                break
            values = [*row.measurements, *row.implemented_action[:11]]
            rows.writerow([k * 180.0] + [f"{value:.9g}" for value in values])
    part.rename(path)
    return path.name, len(result.results), result.terminated


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--healthy", type=int, default=8, help="runs to learn from, as many for limits and for rates")
    parser.add_argument("--runs", type=int, default=3, help="runs of each disturbance")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    jobs = []
    for part, name in enumerate(("train", "limit", "healthy")):
        jobs += [(f"{name}_{i:02}.csv", 1000 * (part + 1) + i, 0) for i in range(1, given.healthy + 1)]
    for i in range(1, given.runs + 1):
        jobs += [(f"idv_{fault:02}_{i}.csv", 10000 + 100 * fault + i, fault) for fault in range(1, 21)]
    with concurrent.futures.ProcessPoolExecutor(given.workers) as pool:
        waiting = [
            pool.submit(run, given.folder / name, seed, fault)
            for name, seed, fault in jobs
            if not (given.folder / name).exists()
        ]
        for done in concurrent.futures.as_completed(waiting):
            name, samples, tripped = done.result()
            print(f"{name}: {samples} samples{', tripped' if tripped else ''}", flush=True)


if __name__ == "__main__":
    main()
