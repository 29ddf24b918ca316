"""How often the cause of a gap of a MuJoCo scene is named; the truth is made by another path than the effects.

    python python/bench/scenes.py run --seed 20261123 --cases 20 --scene arm --out rows.jsonl
    python python/bench/scenes.py baselines --seed 20261123 --cases 20 --scene arm --out fits.jsonl
    python python/bench/scenes.py table rows.jsonl fits.jsonl

A case is a scene (`robots.py`) with one withheld change (`withheld.py`), parameters that are off within their
tolerances and white noise. Nothing of `fdiag` is in that path. Kinds of change take turns; size, place and excitation
are drawn from the seed; nothing was tuned on the seed that is reported. Cases that are in the file already are not run
again. The baselines (`baselines.py`) fit parameters to the same logs.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import baselines
import fdiag
from robots import SCENES, Scene
from withheld import Truth, draw, real

Row = dict[str, Any]


def judged(truth: Truth, result: fdiag.Result) -> str:
    """`right`, `tied` when the right one is among what the log cannot tell apart, `open`, or `wrong`."""
    if not truth.names:
        return "right" if result.verdict == "no-gap" else "wrong"
    first = result.causes[0].name if result.causes else ""
    if result.verdict == "cause":
        return "right" if first in truth.names else "wrong"
    if result.verdict == "tied":
        return "tied" if any(c.name in truth.names for c in result.causes if c.is_tied) else "wrong"
    if result.verdict == "pair":
        half = any(c.name in truth.names for c in result.pairs[0])
        return "half" if half else "wrong"
    return "wrong" if result.verdict == "no-gap" else "open"


def diagnosed(scene: Scene, truth: Truth, log: dict[str, Any], native: str | None, budget: str | None) -> Row:
    """What `fdiag` says of a case, and what it is worth on the last third of the log."""
    begun = time.perf_counter()
    result = fdiag.gap(scene.simulator(native), log, budget=budget, seed=1)
    seconds = time.perf_counter() - begun
    first = result.causes[0] if result.causes else None
    return {
        "verdict": result.verdict,
        "first": first.name if first else None,
        "law": first.law if first else None,
        "p": first.probability if first else None,
        "gap": first.gap if first else None,
        "judged": judged(truth, result),
        "held": held_out(scene, log, result),
        "runs": result.work.made if result.work else None,
        "steps": result.work.steps / scene.samples if result.work else None,
        "seconds": seconds,
        "foretold": result.foretold,
    }


def held_out(scene: Scene, log: dict[str, Any], result: fdiag.Result) -> float | None:
    """What the patched simulator leaves of the last third in a run from the start of the log, in standard deviations
    of the noise."""
    u = np.column_stack([log[name] for name in scene.inputs])
    y = np.column_stack([log[name] for name in scene.outputs])
    try:
        left = (result.patched().simulate(u) - y) / np.array([output.noise for output in scene.outputs.values()])
    except fdiag.Error:
        return None
    return float(np.sqrt(np.mean(left[2 * len(left) // 3 :] ** 2)))


def cases(arguments: argparse.Namespace) -> Any:
    """Those that are asked for and not yet in the file."""
    out = Path(arguments.out)
    done = {(r["scene"], r["case"], r["seed"]) for r in rows_of([out])} if out.exists() else set()
    for number, scene in enumerate(SCENES):
        if scene.name not in arguments.scene:
            continue
        for case in range(arguments.first, arguments.first + arguments.cases):
            if (scene.name, case, arguments.seed) in done:
                continue
            random = np.random.default_rng([arguments.seed, number, case])
            kind = scene.kinds[case % len(scene.kinds)]
            truth = draw(scene, kind, random)
            log = real(scene, truth, random)
            about = {"scene": scene.name, "case": case, "seed": arguments.seed, "kind": kind}
            yield scene, truth, log, {**about, "truth": sorted(truth.names), "size": truth.size}


def rows_of(files: list[Path]) -> list[Row]:
    return [json.loads(line) for file in files for line in file.read_text().splitlines() if line.strip()]


def wilson(right: int, of: int) -> tuple[float, float]:
    """The 95 % interval of a proportion (Wilson 1927)."""
    z, n = 1.96, max(of, 1)
    middle, spread = right / n + z * z / (2 * n), z * np.sqrt(right / n * (1 - right / n) / n + z * z / (4 * n * n))
    return max(0.0, float((middle - spread) / (1 + z * z / n))), min(1.0, float((middle + spread) / (1 + z * z / n)))


def proportion(right: int, of: int) -> str:
    low, high = wilson(right, of)
    return f"{right} of {of} ({low:.2f} to {high:.2f})"


def table(rows: list[Row]) -> None:
    words = ("right", "tied", "half", "open", "wrong")
    heads = ["scene", "kind", "cases", *words[:2], "half of a pair", *words[3:]]
    heads += ["runs' worth of steps, median", "s, median"]
    print(f"| {' | '.join(heads)} |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    keys = list(dict.fromkeys((row["scene"], row["kind"]) for row in rows))
    for scene in dict.fromkeys(row["scene"] for row in rows):
        for kind in [k for s, k in keys if s == scene] + ["all"]:
            of = [r for r in rows if r["scene"] == scene and kind in (r["kind"], "all")]
            counts = [sum(r["judged"] == word for r in of) for word in words]
            middle = [np.median([r[key] or np.nan for r in of]) for key in ("steps", "seconds")]
            cells = [scene, kind, len(of), *counts, f"{middle[0]:.0f}", f"{middle[1]:.1f}"]
            print(f"| {' | '.join(map(str, cells))} |")
    print(f"\nRight: {proportion(sum(r['judged'] == 'right' for r in rows), len(rows))}.")
    sure = [r for r in rows if r["verdict"] == "cause" and r["p"] > 0.9]
    right = sum(r["judged"] == "right" for r in sure)
    print(f"Causes named with p > .9 that are right: {proportion(right, len(sure))}.")
    false = [r for r in rows if r["kind"] == "nothing"]
    print(f"A cause where nothing is changed: {proportion(sum(r['verdict'] == 'cause' for r in false), len(false))}.")


def compared(rows: list[Row], fits: list[Row]) -> None:
    """The diagnosis beside fits of parameters, on the cases that have both."""
    both = {(r["scene"], r["case"], r["seed"]): r for r in rows}
    heads = ["scene", "method", "named, where a number of the scene can express it"]
    print(f"\n| {' | '.join([*heads, 'held-out error, median', '90th percentile', 'runs, median'])} |")
    print("|---|---|---|---|---|---|")
    for scene in dict.fromkeys(f["scene"] for f in fits):
        of = [(both[k], f) for f in fits if f["scene"] == scene and (k := (f["scene"], f["case"], f["seed"])) in both]
        for method in ("fdiag", *baselines.METHODS):
            part = [(r, r if method == "fdiag" else f["fits"].get(method)) for r, f in of]
            part = [(r, g) for r, g in part if g is not None]
            if not part:
                continue
            asked = [(r, g) for r, g in part if r["kind"] in baselines.EXPRESSED]
            named = sum(g["judged"] == "right" for r, g in asked)
            held = [np.inf if g["held"] is None else g["held"] for _, g in part]
            runs = np.median([g["steps"] if method == "fdiag" else g["runs"] for _, g in part])
            error = [f"{np.quantile(held, q, method='nearest'):.2f}" for q in (0.5, 0.9)]
            print(f"| {scene} | {method} | {proportion(named, len(asked))} | {error[0]} | {error[1]} | {runs:.0f} |")


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("what", choices=("run", "baselines", "table"))
    asked.add_argument("files", nargs="*", type=Path, help="for `table`: what the others wrote")
    asked.add_argument("--seed", type=int)
    asked.add_argument("--cases", type=int, default=20, help="cases per scene")
    asked.add_argument("--first", type=int, default=0, help="the number of the first of them")
    asked.add_argument("--scene", nargs="*", choices=[scene.name for scene in SCENES], default=[s.name for s in SCENES])
    asked.add_argument("--native", choices=("all", "none"), default="all")
    asked.add_argument("--budget", help="as `fdiag.gap` takes it")
    asked.add_argument("--evaluations", type=int, default=2000, help="runs that a baseline may make")
    asked.add_argument("--out", help="a file of one line of JSON per case")
    arguments = asked.parse_args()
    if arguments.what == "table":
        rows = rows_of(arguments.files)
        table([row for row in rows if "fits" not in row])
        compared([row for row in rows if "fits" not in row], [row for row in rows if "fits" in row])
        return
    if arguments.seed is None or arguments.out is None:
        asked.error("--seed and --out are needed")
    native = None if arguments.native == "none" else "all"
    for scene, truth, log, about in cases(arguments):
        if arguments.what == "run":
            row = {**about, **diagnosed(scene, truth, log, native, arguments.budget)}
        else:
            row = {**about, "fits": baselines.fitted(scene, truth, log, arguments.evaluations, arguments.seed)}
        line = json.dumps(row)
        print(line, file=sys.stderr, flush=True)
        with open(arguments.out, "a") as file:
            file.write(line + "\n")


if __name__ == "__main__":
    main()
