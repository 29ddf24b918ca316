"""A pendulum of one's own in Python: which effect does it lack?

    pip install ./python
    python examples/python/pendulum.py
"""

import math

import numpy as np

import fdiag

TS = 0.02


class Pendulum:
    """The simulator: a rod with viscous friction, in five steps of Euler's symplectic rule per sample."""

    sample_time = TS
    inputs = {"torque": "N m"}
    outputs = {
        "angle": {"unit": "rad", "noise": 0.002},
        "rate": {"unit": "rad/s", "noise": 0.01},
    }
    parameters = {
        "J": fdiag.Uncertain(0.09, 0.03, "kg m^2"),
        "G": fdiag.Uncertain(2.5, 0.03, "N m"),
        "d": fdiag.Uncertain(0.06, 0.1, "N m s"),
    }
    initial = {"q": fdiag.Initial(0.0, 0.01, "rad"), "w": fdiag.Initial(0.0, 0.02, "rad/s")}
    ports = {"pivot": fdiag.Port("N m", position="angle", velocity="rate")}

    def reset(self, parameters, x0):
        self.J, self.G, self.d = parameters["J"], parameters["G"], parameters["d"]
        self.q, self.w = x0["q"], x0["w"]

    def measure(self, u):
        return self.q, self.w

    def step(self, u, f):
        shown, torque = (self.q, self.w), u[0] + f[0]
        for _ in range(5):
            self.w += TS / 5 * (torque - self.G * math.sin(self.q) - self.d * self.w) / self.J
            self.q += TS / 5 * self.w
        return shown


def log(seed: int, samples: int = 200) -> dict:
    """The real pendulum: its drive follows 60 ms late. An integration of its own, a hundred times finer."""
    random = np.random.default_rng(seed)
    torque = np.repeat(random.uniform(-1.2, 1.2, samples // 15 + 1), 15)[:samples]
    q = w = 0.0
    rows = np.empty((samples, 2))
    for k in range(samples):
        rows[k] = q, w
        late = torque[max(k - 3, 0)]
        for _ in range(100):
            w += TS / 100 * (late - 2.54 * math.sin(q) - 0.058 * w) / 0.0912
            q += TS / 100 * w
    rows += random.standard_normal(rows.shape) * [0.002, 0.01]
    return {"t": np.arange(samples) * TS, "torque": torque, "angle": rows[:, 0], "rate": rows[:, 1]}


def main() -> fdiag.Result:
    # All are tried if none is named; these take seconds.
    effects = ["input-delay", "input-lag", "input-gain"]
    result = fdiag.gap(Pendulum(), log(1), held_out=log(2), only=effects, most=1)
    print(result.headline)
    for cause in result.causes[:3]:
        print(f"{cause.name}: {cause.probability:.3f}")
    return result


if __name__ == "__main__":
    main()
