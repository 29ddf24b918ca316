"""Programs that a model names, where they are forbidden."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import fdiag

SCRIPT = """
import sys, fdiag
marker = sys.argv[1]
command = ["sh", "-c", f"touch {marker}; sleep 1"]
fdiag.forbid_programs()
for make in (
    lambda: fdiag.Process(command, sample_time=0.1, inputs={"u": "1"}, outputs={"y": "1"}).text(),
    lambda: fdiag.check(fdiag.Process(command)),
    lambda: fdiag.Fmu("gone.fmu", outputs={"y": "1"}).text(),
    lambda: fdiag.Model(sys.argv[2]).text(),
):
    try:
        make()
    except fdiag.InputError as error:
        print(error)
    else:
        sys.exit("not refused")
"""


def test_programs_can_be_forbidden(tmp_path: Path) -> None:
    """In a process of its own: there is no way back."""
    marker, model = tmp_path / "marker", tmp_path / "model.toml"
    model.write_text(f'version = 1\nkind = "process"\ncommand = ["touch", "{marker}"]\n')
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(marker), str(model)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    said = done.stdout.splitlines()
    assert len(said) == 4, said
    assert all("would be executed, and programs are forbidden here" in line for line in said)
    assert all("forbid_programs" in line for line in said)
    assert not marker.exists()


def test_an_fmu_has_a_process_of_its_own(mass: Path) -> None:
    """It makes the runs of one in this process."""

    def make(**how: bool) -> fdiag.Fmu:
        return fdiag.Fmu(mass, outputs={"place": "m"}, uncertain={"d": 0.1}, sample_time=0.02, **how)

    u = [[0.5, 0.0]] * 50
    assert (make().simulate(u) == make(in_process=True).simulate(u)).all()
    # The interpreter that serves it is another one.
    script = f"""
import os, fdiag
fdiag.Fmu({str(mass)!r}, outputs={{"place": "m"}}, sample_time=0.02).simulate([[0.0, 0.0]] * 3)
print(any("mass.so" in line for line in open("/proc/self/maps")))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.stdout == "False\n", done.stderr
