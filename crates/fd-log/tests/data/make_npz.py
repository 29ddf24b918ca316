"""Writes the arrays of this folder with numpy.

    pip install numpy==2.4.6
    python make_npz.py
"""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
k = np.arange(40)
q = np.stack([k / 4, -k / 8], axis=1)
arrays = {
    "t": k / 20,
    "u": (k % 7).astype("<i2"),
    "q": q,
    "q_fortran": np.asfortranarray(q),
    "half": (k / 4).astype("<f2"),
    "big": (k * 1e6).astype(">f4"),
    "on": k % 2 == 0,
    "stamp": np.datetime64("2026-11-23T12:00:00.000000001", "ns") + k * np.timedelta64(50, "ms"),
    "slow": np.arange(5.0),
    "dt": np.float64(0.05),
    "name": np.array(["run"] * 40),
    "cube": np.zeros((40, 2, 2)),
    "events": np.array([(i, i / 2) for i in range(3)], dtype=[("code", "u1"), ("at_s", "<f8")]),
}
np.savez(HERE / "arrays.npz", **arrays)
np.savez_compressed(HERE / "packed.npz", **arrays)
np.save(HERE / "matrix.npy", q)
