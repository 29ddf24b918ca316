"""Writes the files of HDF5 and MATLAB of this folder with h5py and scipy.

    pip install h5py==3.16.0 scipy==1.17.1 numpy==2.4.6
    python make_hdf5.py

`matlab73.mat` is put together as MATLAB puts it: 512 bytes of text before the superblock, matrices transposed, the class
of each in the attribute `MATLAB_class`, structs as groups.
"""

from pathlib import Path

import h5py
import numpy as np
from scipy.io import savemat

HERE = Path(__file__).parent
k = np.arange(40)
q = np.stack([k / 4, -k / 8], axis=1)


def hdf5() -> None:
    with h5py.File(HERE / "run.h5", "w") as file:
        file["time"] = k / 20
        file["time"].attrs["units"] = "seconds since 2026-11-23 12:00:00"
        run = file.create_group("run")
        run.create_dataset("q", data=q.astype("<f4"), chunks=(16, 2), compression="gzip", shuffle=True, fletcher32=True)
        run["q"].attrs["units"] = "rad"
        run["u"] = (k % 7).astype(">i2")
        run["on"] = k % 2 == 0
        run["half"] = (k / 4).astype("<f2")
        run["record"] = np.array([(i, i / 2) for i in k], dtype=[("code", "u1"), ("at", "<f8")])
        run["again"] = file["run"]  # a link that leads back
        file["slow"] = np.arange(5.0)
        file["dt"] = 0.05
        file["name"] = ["run"] * 40
        file["cube"] = np.zeros((4, 2, 2))
    with h5py.File(HERE / "latest.h5", "w", libver="latest") as file:
        file.create_dataset("time", data=k / 20, chunks=(8,), maxshape=(None,))
        file.create_dataset("y", data=k / 4, chunks=(8,), maxshape=(None,), compression="gzip")


def matlab73() -> None:
    path = HERE / "matlab73.mat"
    with h5py.File(path, "w", userblock_size=512) as file:

        def put(where: h5py.Group, name: str, matrix: np.ndarray, kind: str = "double") -> None:
            where[name] = np.atleast_2d(matrix).T
            where[name].attrs["MATLAB_class"] = np.bytes_(kind)

        put(file, "t", (k / 20)[:, None])
        log = file.create_group("log")
        log.attrs["MATLAB_class"] = np.bytes_("struct")
        put(log, "u", (k % 7)[None, :].astype("i2"), "int16")
        put(log, "q", q)
        put(file, "dt", np.array([[0.05]]))
        file.create_group("#refs#")["a"] = np.zeros((40, 1))
    with open(path, "r+b") as file:
        head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Nov 23 12:00:00 2026 HDF5 schema 1.00 ."
        file.write(head.ljust(116) + b"\0" * 8 + b"\x00\x02IM")


def matlab5() -> None:
    held = {
        "t": k / 20,
        "log": {"u": (k % 7).astype("i2"), "deep": {"q": q}},
        "on": k % 2 == 0,
        "dt": 0.05,
        "name": "run",
        "z": k * 1j,
        "cells": np.array([1.0, "a"], dtype=object),
        "slow": np.arange(5.0),
    }
    savemat(HERE / "plain.mat", held, oned_as="column")
    savemat(HERE / "packed.mat", held, oned_as="row", do_compression=True)


hdf5()
matlab73()
matlab5()
