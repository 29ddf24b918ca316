"""Writes docs/results/throughput.md from what criterion and the peers have measured.

Usage: report.py CRITERION_HOME PEERS.jsonl NOTES.txt [--quick] OUTPUT
"""

import datetime
import json
import os
import pathlib
import platform
import subprocess
import sys

criterion_home, peers_file, notes_file, *options, output = sys.argv[1:]
QUICK = "--quick" in options
SCALARS = ("f64", "f32")


def command(*words):
    try:
        return subprocess.run(words, capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


def criterion():
    """Nanoseconds per element of the fastest and the median sample, by group and name."""
    found = {}
    for file in pathlib.Path(criterion_home).glob("*/*/new/benchmark.json"):
        about = json.loads(file.read_text())
        sample = json.loads(file.with_name("sample.json").read_text())
        elements = (about.get("throughput") or {}).get("Elements", 1)
        times = sorted(t / n / elements for t, n in zip(sample["times"], sample["iters"]))
        found[about["group_id"], about["function_id"] or ""] = (times[0], times[len(times) // 2])
    return found


ours = criterion()
peers = [json.loads(line) for line in open(peers_file) if line.startswith("{")]
notes = [line.strip() for line in open(notes_file) if line.strip()]
lines = []
say = lines.append


def get(group, name):
    """The fastest sample, or nothing."""
    return ours.get((group, name), (None, None))[0]


def rate(ns):
    return f"{1e9 / ns:.2e}" if ns else "–"


def duration(ns):
    for unit, size in [("s", 1e9), ("ms", 1e6), ("µs", 1e3)]:
        if ns >= size:
            return f"{ns / size:.3g} {unit}"
    return f"{ns:.3g} ns"


def ratio(a, b):
    return a / b if a and b else None


def times(a, b):
    return f"{a / b:.2f}" if a and b else "–"


def share(a, b):
    return f"{a / b:.0%}" if a and b else "–"


def table(head, *body):
    for row in [head, ["---"] * len(head), *body]:
        say("| " + " | ".join(str(cell) for cell in row) + " |")
    say("")


def operations(n):
    """Products, fused multiply-adds and divisions of one update on U D Uᵀ: see `batch/kernel.rs`.

    Uᵀφ, the columns of U and Pφ: n(n−1)/2 each. Per parameter: its part of the error, of the energy
    and of the innovation variance, the product with D, the factor of a column of U, three products
    for D, one step of the estimate, and a division. The bound on the trace and the gain: one each;
    the first column of U has no factor.
    """
    return 3 * n * (n - 1) // 2 + 9 * n + 1 + n


UD = operations(5)

fma = {s: get("fused multiply-adds", s) for s in SCALARS}
limit = {s: UD * fma[s] if fma[s] else None for s in SCALARS}
singles = {name: ns[0] for (group, name), ns in ours.items() if group == "rls update, n = 5"}
in_rust = {n: v for n, v in singles.items() if n.startswith(("oxictl", "dsmc"))}
own = {n: v for n, v in singles.items() if n not in in_rust}
elsewhere = {f"{p['name']} {p['version']} {p['scalar']}": p["fastest"]
             for p in peers if p["what"] == "rls update, n = 5"}
all_peers = {**in_rust, **elsewhere}
fastest_peer = min(all_peers.values(), default=None)
peer_of = {s: min((v for n, v in all_peers.items() if n.endswith(s)), default=None) for s in SCALARS}
alone = {s: get("rls update, n = 5", f"UD fixed {s}") for s in SCALARS}
batch = {s: min((ns[0] for (group, name), ns in ours.items()
                 if group == "rls batch, n = 5" and name.startswith(s)), default=None) for s in SCALARS}
made = {s: get("rls batch of equations, n = 5", s) for s in SCALARS}
MANY, FLEET = "rls batch of 4096, n = 5", "rls fleet of 1000000, n = 5"
reductions = {p["what"]: p["fastest"] for p in peers if p["what"].startswith("balanced truncation")}
monte_carlo = [p for p in peers if p["what"] == "Monte Carlo"]


def heading():
    model = command("sh", "-c", "lscpu 2>/dev/null | sed -n 's/^Model name: *//p'")
    caches = command("sh", "-c", "lscpu 2>/dev/null | sed -n 's/^\\(L[0-9]d\\?\\) cache: */\\1 /p'")
    versions = sorted({f"{p['name']} {p['version']}" for p in peers if p.get("version")})
    locked = pathlib.Path("Cargo.lock").read_text().split("[[package]]")
    for crate in ("oxictl", "dsmc"):
        for entry in locked:
            if f'name = "{crate}"' in entry:
                versions.append(f"{crate} {entry.split('version = ')[1].split(chr(34))[1]}")
    say("# Throughput")
    say("")
    say("Written by `benches/peers/run`; all figures are from one run on one machine. A figure is the")
    say("fastest sample of criterion, or the fastest repetition of a peer: what others do on the machine")
    say("only ever adds time. Rust code is built for the baseline of the architecture, and finds wide")
    say("registers at run time; peers in C and C++ are built for this very machine.")
    say("")
    if QUICK:
        say("**These figures are from a short run (`--quick`) and only show that the script works.**")
        say("")
    load = os.getloadavg()
    # One core measures, both build: more than that was somebody else.
    if load[2] > (os.cpu_count() or 1) + 0.5:
        say(f"**The machine was not quiet: load average {load[2]:.1f} over the last quarter of an hour.**")
        say("")
    table(["what", "value"],
          ["machine", f"{model or platform.processor()}, {os.cpu_count()} processors, "
                      f"{platform.system()} {platform.machine()}"],
          ["caches", caches.replace("\n", "; ") or "–"],
          ["date", datetime.date.today()],
          ["load average at the end", " ".join(f"{value:.1f}" for value in load)],
          ["compiler", command("rustc", "--version")],
          ["fdiag", command("git", "describe", "--always", "--dirty")],
          ["peers", ", ".join(versions) or "–"])


def demands():
    """What issue 5 asks for, as ratios."""
    rows = []

    def demand(text, found, least):
        verdict = "not measured" if found is None else "met" if found >= least else "**missed**"
        rows.append([text, f"{least:g}", "–" if found is None else f"{found:.2f}", verdict])

    for s in SCALARS:
        demand(f"one stream {s}, times the fastest peer of {s}", ratio(peer_of[s], alone[s]), 1.3)
    for s, least in zip(SCALARS, (6, 12)):
        demand(f"batch {s}, times the fastest peer's single stream", ratio(fastest_peer, batch[s]), least)
    for s in SCALARS:
        demand(f"batch {s} in cache, share of the limit of the arithmetic", ratio(limit[s], batch[s]), 0.75)
    for s in SCALARS:
        demand(f"fleet of 10⁶ {s}, share of the rate in cache",
               ratio(made[s], get(FLEET, f"{s} made, one core")), 0.7)
    for s in SCALARS:
        demand(f"two cores, times one, batch of 4096 {s}",
               ratio(get(MANY, f"{s}, one core"), get(MANY, f"{s}, two cores")), 1.9)
        demand(f"two cores, times one, fleet {s}",
               ratio(get(FLEET, f"{s} made, one core"), get(FLEET, f"{s} made, two cores")), 1.9)
    for n in (100, 500, 1000):
        what = f"n = {n}"
        demand(f"balanced truncation, {what}, time of slycot AB09AD over ours",
               ratio(reductions.get(f"balanced truncation, {what}"), get("balanced truncation", what)), 1)
    say("## What was asked for, n = 5 parameters, one core unless said")
    say("")
    table(["ratio", "at least", "found", ""], *rows)


def single_stream():
    say("## Recursive least squares, n = 5, one stream")
    say("")
    everything = {**{f"**fdiag** {n}": v for n, v in own.items()}, **all_peers}
    table(["what", "ns per update", "updates/s", "times the fastest peer", "of the same scalar"],
          *[[name, f"{ns:.1f}", rate(ns), times(fastest_peer, ns), times(peer_of.get(name[-3:]), ns)]
            for name, ns in sorted(everything.items(), key=lambda item: item[1])])


def many_streams():
    say("## Side by side and in a fleet, n = 5")
    say("")
    say(f"**The limit of the arithmetic.** An update on `U D Uᵀ` of 5 parameters is {UD - 5} products and")
    say(f"fused multiply-adds and 5 divisions. Each counts as one operation, {UD} in all, at the rate of")
    say("fused multiply-adds of the widest registers that this run has measured: "
        + ", ".join(f"{s} {rate(ns)}/s, hence {rate(limit[s])} updates/s"
                    for s, ns in fma.items() if ns) + ".")
    say("Sums, comparisons, loads and stores count nothing. A division takes longer than a multiply-add,")
    say("so the whole limit is out of reach. The limit of 3.6e8 updates/s at 3.65 GHz and eight lanes, which")
    say("was stated for the conventional form, comes to the same 81 operations per update.")
    say("")
    say("Regressors are `given` (6 numbers per sample) or `made` in the lanes from one input and the bias")
    say("(2 numbers). A fleet goes through a block of 16 (given) or 64 (made) samples of each estimator:")
    say("it is the numbers per update that have to come from memory, so only `made` can be compared with")
    say("the rate in cache; 64 estimators with 64 samples each fit.")
    say("")
    rows = []
    groups = ("rls batch, n = 5", "rls batch of equations, n = 5", "rls batch, directional, n = 5",
              MANY, FLEET)
    for (group, name), (ns, _) in sorted(ours.items()):
        if group in groups:
            label = f"{group.removeprefix('rls ').removesuffix(', n = 5')}: {name}"
            both = 2 if ", two " in name else 1
            bound = limit[name[:3]]
            rows.append([label, f"{ns:.2f}", rate(ns), times(fastest_peer, ns),
                         share(bound and bound / both, ns)])
    table(["what", "ns per update", "updates/s", "times the fastest peer's single stream",
           "share of the limit"], *rows)


def sizes():
    columns = [2, 5, 10, 20]
    names = sorted({(g.split(", n =")[0], n) for (g, n) in ours
                    if g.startswith(("rls update, n", "rls batch, n"))})
    say("## By number of parameters, updates/s")
    say("")
    rows = []
    for group, name in names:
        label = {"rls update": "", "rls batch": "batch, "}[group] + name
        rows.append([label, *[rate(get(f"{group}, n = {n}", name)) for n in columns]])
    table(["what", *[f"n = {n}" for n in columns]], *rows)


def truncations():
    rows = []
    for n in (17, 100, 500, 1000):
        mine = get("balanced truncation", f"n = {n}")
        theirs = reductions.get(f"balanced truncation, n = {n}")
        if mine or theirs:
            rows.append([n, duration(mine) if mine else "–", duration(theirs) if theirs else "–",
                         times(theirs, mine)])
    if rows:
        say("## Balanced truncation to 5 states, one core")
        say("")
        table(["states", "fdiag", "slycot AB09AD", "slycot / fdiag"], *rows)


def others():
    for title, prefix in [("Order search", "order selection"), ("Pipeline, per sample", "sample,"),
                          ("The engine's equations", "engine17"), ("Runs of the engine", "run of"),
                          ("Simulations of models written as equations", "simulations of")]:
        found = [(g, n, ns) for (g, n), ns in sorted(ours.items()) if g.startswith(prefix)]
        if found:
            say(f"## {title}")
            say("")
            table(["what", "fastest", "median", "per second"],
                  *[[f"{g}: {n}", duration(ns[0]), duration(ns[1]), rate(ns[0])] for g, n, ns in found])
    if monte_carlo:
        say("## Monte Carlo of the engine: `fdiag-lab engine --seeds N`")
        say("")
        table(["seeds", "by the clock", "processor time", "largest memory"],
              *[[p["seeds"], f"{p['seconds']:.1f} s", f"{p['processor']:.1f} s", f"{p['memory']:.0f} MiB"]
                for p in monte_carlo])


heading()
demands()
if own or all_peers:
    single_stream()
if any(fma.values()):
    many_streams()
    sizes()
truncations()
others()
if notes:
    say("## Left out")
    say("")
    lines += [f"* {line}" for line in notes]
pathlib.Path(output).write_text("\n".join(lines).rstrip() + "\n")
