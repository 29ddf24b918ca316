"""Measures recursive least squares and balanced truncation of Python packages.

One JSON object per line: name, what is measured, nanoseconds of the fastest and the median
repetition. Packages that cannot be imported are named on standard error.
"""

import importlib.metadata
import json
import statistics
import sys
import time

QUICK = "--quick" in sys.argv
N, SAMPLES, LAMBDA, PRIOR = 5, 256, 0.999, 100.0


def emit(name, what, times, count, **more):
    times = [t / count * 1e9 for t in times]
    row = {"name": name, "what": what, "fastest": min(times), "median": statistics.median(times)}
    print(json.dumps({**row, **more}), flush=True)


def repeat(work, seconds):
    work()
    times, end = [], time.perf_counter() + (0.2 if QUICK else seconds)
    while time.perf_counter() < end or len(times) < 5:
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return times


def padasip():
    import padasip as pa

    rls = pa.filters.FilterRLS(N, mu=LAMBDA, eps=1 / PRIOR)

    def work():
        for x, d in zip(PHI, TARGET):
            rls.adapt(d, x)

    return work


def numpy_form_b():
    state = [np.zeros(N), np.eye(N) * PRIOR]

    def work():
        theta, p = state
        for x, d in zip(PHI, TARGET):
            px = p @ x
            gain = px / (LAMBDA + x @ px)
            theta = theta + gain * (d - x @ theta)
            p = (p - np.outer(px, px) / (LAMBDA + x @ px)) / LAMBDA
        state[:] = theta, p

    return work


def numba_loop():
    import numba

    @numba.njit(fastmath=False)
    def block(phi, target, theta, p, v, lam):
        n = theta.shape[0]
        for k in range(target.shape[0]):
            energy, error = lam, target[k]
            for i in range(n):
                s = 0.0
                for j in range(n):
                    s += p[i, j] * phi[k, j]
                v[i] = s
                energy += s * phi[k, i]
                error -= theta[i] * phi[k, i]
            c = 1.0 / energy
            for i in range(n):
                theta[i] += v[i] * c * error
                for j in range(n):
                    p[i, j] = (p[i, j] - (v[i] * v[j]) * c) / lam

    theta, p, v = np.zeros(N), np.eye(N) * PRIOR, np.zeros(N)
    return lambda: block(PHI, TARGET, theta, p, v, LAMBDA)


def filterpy():
    from filterpy.kalman import KalmanFilter

    f = KalmanFilter(dim_x=N, dim_z=1)
    f.P *= PRIOR

    def work():
        for x, d in zip(PHI, TARGET):
            f.predict()
            f.update(d, H=x[None, :])

    return work


def slycot_ab09ad():
    import slycot

    for n in (17, 100) if QUICK else (17, 100, 500, 1000):
        rng = np.random.default_rng(1)
        a = rng.uniform(-1, 1, (n, n))
        a *= 0.95 / max(abs(np.linalg.eigvals(a)))
        b, c = rng.uniform(-1, 1, (n, 2)), rng.uniform(-1, 1, (3, n))

        def work():
            args = ("D", "B", "N", n, 2, 3, a.copy(), b.copy(), c.copy())
            slycot.ab09ad(*args, nr=5, tol=0.0)

        emit("slycot AB09AD", f"balanced truncation, n = {n}", repeat(work, 2), 1,
             version=slycot.__version__)


try:
    import numpy as np
except ImportError as error:
    sys.exit(f"peers in Python: {error}")

RNG = np.random.default_rng(N)
PHI, TARGET = RNG.uniform(-1, 1, (SAMPLES, N)), RNG.uniform(-1, 1, SAMPLES)

for name, peer in [("padasip", padasip), ("numpy", numpy_form_b), ("numba", numba_loop),
                   ("filterpy", filterpy)]:
    try:
        work = peer()
        emit(name, "rls update, n = 5", repeat(work, 1.5), SAMPLES, scalar="f64",
             version=importlib.metadata.version(name))
    except Exception as error:  # a peer that fails is a note, not the end
        print(f"{name}: {error}", file=sys.stderr)
try:
    slycot_ab09ad()
except Exception as error:
    print(f"slycot: {error}", file=sys.stderr)
