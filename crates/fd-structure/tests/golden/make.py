"""Makes toolbox.json: what the Fault Diagnosis Toolbox says about its own examples and 50 random structures.

    python3 -m venv venv && venv/bin/pip install faultdiagnosistoolbox==0.12.5
    venv/bin/python make.py > toolbox.json

Structures are rows of digits, as in the toolbox: 0 not in the equation, 1 in it, 2 a state and 3 its rate in a
differential constraint. `f` holds the equation of each fault. Isolability has a 1 where the fault of the row
can *not* be isolated from that of the column.
"""

import contextlib
import io
import json
import random
import sys

import faultdiagnosistoolbox as fdt
import numpy as np
from faultdiagnosistoolbox import models

# For so many minimal overdetermined sets of each structure the causality of residuals is compared.
SWEPT = 6


def random_structure(seed):
    """A structure with states, redundancy 1 to 4, and no unknown that nothing determines for want of equations."""
    draw = random.Random(seed)
    states, others = draw.randint(0, 3), draw.randint(3, 7)
    unknowns = 2 * states + others
    algebraic = states + others + draw.randint(1, 4)
    rows = []
    for _ in range(algebraic):
        row = [0] * unknowns
        for x in draw.sample(range(unknowns), min(unknowns, draw.choice([1, 1, 2, 2, 3, 3, 4]))):
            row[x] = 1
        rows.append(row)
    for state in range(states):
        row = [0] * unknowns
        row[2 * state], row[2 * state + 1] = 2, 3
        rows.append(row)
    draw.shuffle(rows)
    plain = [i for i, row in enumerate(rows) if 2 not in row]
    # One fault per equation, which is what the toolbox expects.
    faults = sorted(draw.sample(plain, min(len(plain), draw.randint(2, 6))))
    return rows, faults


def judged(name, rows, faults):
    F = np.zeros((len(rows), len(faults)), dtype=np.int64)
    for column, row in enumerate(faults):
        F[row, column] = 1
    definition = {"type": "MatrixStruc", "X": np.array(rows), "F": F, "Z": []}
    model = fdt.DiagnosisModel(definition, name=name)
    sets = lambda found: sorted(sorted(int(e) for e in s) for s in found)
    result = {
        "name": name,
        "x": ["".join(str(int(v)) for v in row) for row in rows],
        "f": faults,
        "redundancy": int(model.Redundancy()),
        "mso": sets(model.MSO()),
        "mtes": sets(model.MTES()),
    }
    # The causality of each residual of the first sets.
    result["sweep"] = [
        " ".join(model.MSOCausalitySweep(np.array(mso), diffres="int")) for mso in result["mso"][:SWEPT]
    ]
    for causality in ["mixed", "int", "der"]:
        isolability = model.IsolabilityAnalysis(causality=causality)
        detected, _ = model.DetectabilityAnalysis(causality=causality)
        result[causality] = {
            "detectable": [int(f in detected) for f in model.f],
            "isolability": ["".join(str(int(v)) for v in row) for row in isolability],
        }
    return result


def example(model):
    faults = []
    for column in range(model.nf()):
        rows = np.flatnonzero(model.F[:, column])
        assert len(rows) == 1
        faults.append(int(rows[0]))
    return judged(model.name, model.X.astype(int).tolist(), faults)


def main():
    found = []
    with contextlib.redirect_stdout(io.StringIO()):
        for model in [models.three_tank, models.electric_motor, models.induction_motor]:
            found.append(example(model))
        for seed in range(50):
            found.append(judged(f"random {seed}", *random_structure(seed)))
    lines = ",\n".join(json.dumps(one) for one in found)
    sys.stdout.write(f"[\n{lines}\n]\n")


main()
