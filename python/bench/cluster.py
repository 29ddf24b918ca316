"""The blind bench and the engines of the Monte Carlo study, a case or an engine per job, in this process or on a cluster.

    fdiag-lab blind make --out cases --seed 7 --single 20
    python python/bench/cluster.py blind cases --folder kept --ray
    fdiag-lab blind score cases --out report
    python python/bench/cluster.py engine --engines 1000 --folder kept --ray

A job runs the command line `fdiag`, which must be found under the same name by every worker; the files of a case go
with it, so workers need no common disk. Answers are those of `fdiag-lab blind run` and `fdiag-lab engine`, to the bit, but for
the seconds. With `--folder` a study that was interrupted goes on where it was.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fdiag.ray
from fdiag import jobs


def called(command: list[str]) -> str:
    """What a program says; an error, with what it says of it, if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{command[0]} {command[1]}: {done.stderr.strip()}")
    return done.stdout


def diagnosed(binary: str, case: str, files: dict[str, str], options: list[str]) -> dict[str, str]:
    """Lines of the answers to a case, by the name of the file."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "cases" / case
        place.mkdir(parents=True)
        for name, text in files.items():
            (place / name).write_text(text, encoding="utf-8")
        called([binary, "blind", "run", folder, "--threads", "1", "--quiet", *options])
        return {path.name: path.read_text(encoding="utf-8") for path in Path(folder).glob("*.jsonl")}


def engine(binary: str, number: int) -> dict[str, Any]:
    """What `fdiag-lab engine` says of one engine."""
    with tempfile.TemporaryDirectory() as folder:
        which = ["--seeds", "1", "--first-seed", str(number)]
        said = called([binary, "engine", *which, "--json", "--out", folder, "--threads", "1", "--quiet"])
    report = json.loads(said)
    return {"trials": report["trials"], "failed": report["failed"]}


def ran(function: Callable[..., Any], asked: dict[str, dict[str, Any]], options: argparse.Namespace) -> list[Any]:
    """Results in the order of the jobs; says how long it took, and ends where one has failed."""
    run = fdiag.ray.map if options.ray else jobs.run
    begun = time.perf_counter()
    found = run(function, asked, folder=options.folder)
    seconds = time.perf_counter() - begun
    new = [outcome for outcome in found if outcome.is_new]
    inside = sum(outcome.seconds for outcome in new)
    print(f"{len(found)} jobs, {len(new)} of them now: {seconds:.1f} s, and {inside:.1f} s in all jobs together")
    failed = [outcome for outcome in found if not outcome.is_ok]
    for outcome in failed:
        print(f"{outcome.name}: {outcome.error}")
    if failed:
        raise SystemExit(1)
    return [outcome.result for outcome in found]


def blind(options: argparse.Namespace) -> None:
    root = Path(options.cases)
    places = sorted(path for path in (root / "cases").iterdir() if path.is_dir())
    asked = {
        place.name: {
            "binary": options.binary,
            "case": place.name,
            "files": {path.name: path.read_text(encoding="utf-8") for path in sorted(place.iterdir())},
            "options": options.options,
        }
        for place in places
    }
    written: dict[str, str] = {}
    for answers in ran(diagnosed, asked, options):
        for name, lines in answers.items():
            written[name] = written.get(name, "") + lines
    for name, lines in written.items():
        draft = root / f".{name}.part"
        draft.write_text(lines, encoding="utf-8")
        draft.replace(root / name)


def engines(options: argparse.Namespace) -> None:
    numbers = range(options.first, options.first + options.engines)
    asked = {f"engine {number}": {"binary": options.binary, "number": number} for number in numbers}
    found = ran(engine, asked, options)
    trials = [trial for result in found for trial in result["trials"]]
    if options.out:
        Path(options.out).write_text(json.dumps(trials), encoding="utf-8")
    print(f"{len(trials)} engines, {sum(len(result['failed']) for result in found)} failed")

    def median(what: str, value: Callable[[dict[str, Any]], dict[str, float]]) -> None:
        ratios = [value(trial)["primary"] / value(trial)["compensated"] for trial in trials]
        print(f"{what}: {statistics.median(ratios):.3g} times smaller (median)")

    median("largest fault-free residual", lambda trial: trial["fault_free"])
    for place, fault in enumerate(trials[0]["faults"]):
        median(f"smallest fault of {fault['sensor']}", lambda trial: trial["faults"][place]["smallest"])


def main() -> None:
    # What is after `--` is for `fdiag-lab blind run`, wherever the options before it stand.
    end = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    every = argparse.ArgumentParser(add_help=False)
    every.add_argument("--binary", default="fdiag-lab", help="the command line `fdiag-lab`")
    every.add_argument("--folder", help="where the answers of jobs are kept")
    every.add_argument("--ray", action="store_true", help="as tasks of Ray, instead of one after the other here")
    what = asked.add_subparsers(dest="what", required=True)
    of_blind = what.add_parser("blind", parents=[every], epilog="after `--`: options of `fdiag-lab blind run`")
    of_blind.add_argument("cases", help="what `fdiag-lab blind make` has made")
    of_engine = what.add_parser("engine", parents=[every])
    of_engine.add_argument("--engines", type=int, default=20)
    of_engine.add_argument("--first", type=int, default=1, help="number of the first engine")
    of_engine.add_argument("--out", help="a file for the figures of every engine, as JSON")
    options = asked.parse_args(sys.argv[1:end])
    options.options = sys.argv[end + 1 :]
    (blind if options.what == "blind" else engines)(options)


if __name__ == "__main__":
    main()
