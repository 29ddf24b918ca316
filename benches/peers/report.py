"""Writes docs/results/throughput.md from what criterion and the peers have measured.

Usage: report.py PEERS.jsonl NOTES.txt [--quick] OUTPUT
"""

import datetime
import json
import pathlib
import platform
import subprocess
import sys

peers_file, notes_file, *options, output = sys.argv[1:]
QUICK = "--quick" in options
CRITERION = pathlib.Path("target/criterion")


def command(*words):
    try:
        return subprocess.run(words, capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


def criterion():
    """Nanoseconds per element of the fastest and the median sample, by group and name."""
    found = {}
    for file in CRITERION.glob("*/*/new/benchmark.json"):
        about = json.loads(file.read_text())
        sample = json.loads(file.with_name("sample.json").read_text())
        elements = (about.get("throughput") or {}).get("Elements", 1)
        times = sorted(t / n / elements for t, n in zip(sample["times"], sample["iters"]))
        found[about["group_id"], about["function_id"] or ""] = (times[0], times[len(times) // 2])
    return found


ours = criterion()
peers = [json.loads(line) for line in open(peers_file) if line.startswith("{")]
notes = [line.strip() for line in open(notes_file) if line.strip() and "Warning" not in line]
lines = []
say = lines.append


def rate(ns):
    return f"{1e9 / ns:.2e}" if ns else "–"


def duration(ns):
    for unit, size in [("s", 1e9), ("ms", 1e6), ("µs", 1e3)]:
        if ns >= size:
            return f"{ns / size:.3g} {unit}"
    return f"{ns:.3g} ns"


def table(*rows):
    head, *body = rows
    for row in [head, ["---"] * len(head), *body]:
        say("| " + " | ".join(str(cell) for cell in row) + " |")
    say("")


def operations(n):
    """Products, fused multiply-adds and divisions of one update on U D Uᵀ."""
    return 3 * n * (n - 1) // 2 + 8 * n + 2 + n


def get(group, name):
    return ours.get((group, name), (None, None))[0]


model = command("sh", "-c", "lscpu 2>/dev/null | sed -n 's/^Model name: *//p'") or platform.processor()
load = " ".join(map(str, __import__("os").getloadavg()))
say("# Throughput")
say("")
say("Written by `benches/peers/run`; every figure of a table is from one run on one machine.")
say("")
if QUICK:
    say("**These figures are from a short run (`--quick`) and only show that the script works.**")
    say("")
table(["what", "value"],
      ["machine", f"{model}, {__import__('os').cpu_count()} processors, {platform.system()} {platform.machine()}"],
      ["date", datetime.date.today()],
      ["load average at the end", load],
      ["compiler", command("rustc", "--version")],
      ["fdiag", command("git", "describe", "--always", "--dirty")])
say("A figure is the fastest sample of criterion, or the fastest repetition of a peer: what others")
say("do on the machine only ever adds time. All Rust code is built for the baseline of the")
say("architecture; wide registers are found at run time.")
say("")

fma = {s: get("fused multiply-adds", s) for s in ("f64", "f32")}
singles = {name: ns[0] for (group, name), ns in ours.items() if group == "rls update, n = 5"}
others = {f"{p['name']} {p.get('version', '')}".strip(): p["fastest"]
          for p in peers if p["what"] == "rls update, n = 5"}
rust_peers = {n: v for n, v in singles.items() if n.startswith(("oxictl", "dsmc"))}
own = {n: v for n, v in singles.items() if n not in rust_peers}
all_peers = {**rust_peers, **others}
best_peer = min(all_peers.values(), default=None)

if own:
    say("## Recursive least squares, n = 5, one stream")
    say("")
    rows = [["what", "ns per update", "updates/s", "times the fastest peer"]]
    everything = {**{f"**fdiag** {n}": v for n, v in own.items()}, **all_peers}
    for name, ns in sorted(everything.items(), key=lambda item: item[1]):
        ratio = f"{best_peer / ns:.2f}" if best_peer else "–"
        rows.append([name, f"{ns:.1f}", rate(ns), ratio])
    table(*rows)

    say("## Side by side and in a fleet, n = 5, one core unless said")
    say("")
    say(f"The limit of the arithmetic is {operations(5)} products, multiply-adds and divisions per")
    say("update on `U D Uᵀ` (the conventional form needs 81) at the rate of fused multiply-adds measured in")
    say("this run" + "".join(f", {s}: {rate(ns)}/s" for s, ns in fma.items() if ns) + ".")
    say("")
    rows = [["what", "ns per update", "updates/s", "times the fastest peer's single stream",
             "share of the limit", "share of the conventional form's"]]
    for (group, name), (ns, _) in sorted(ours.items()):
        if group in ("rls batch, n = 5", "rls fleet of 1000000, n = 5", "rls batch of 4096, n = 5"):
            peak = fma[name[:3]]
            share = lambda ops: f"{ops * peak / ns:.0%}" if peak else "–"
            rows.append([f"{group.removeprefix('rls ').removesuffix(', n = 5')}, {name}", f"{ns:.2f}",
                         rate(ns), f"{best_peer / ns:.1f}" if best_peer else "–",
                         share(operations(5)), share(81)])
    table(*rows)
    checks = [["demand", "found"]]

    def demand(text, value, least):
        checks.append([text, f"{value:.2f} ({'met' if value >= least else 'not met'})"
                       if value is not None else "not measured"])

    ratio = lambda a, b: a / b if a and b else None
    single = min((v for n, v in own.items() if n.startswith("UD")), default=None)
    widest = {s: min((ns[0] for (g, n), ns in ours.items()
                      if g == "rls batch, n = 5" and n.startswith(s)), default=None) for s in fma}
    fleet = lambda s, cores: get("rls fleet of 1000000, n = 5", f"{s}, {cores}")
    demand("single stream ≥ 1.3 × the fastest peer", ratio(best_peer, single), 1.3)
    demand("batch f64 ≥ 6 ×", ratio(best_peer, widest["f64"]), 6)
    demand("batch f32 ≥ 12 ×", ratio(best_peer, widest["f32"]), 12)
    for s in fma:
        limit = fma[s] * operations(5) if fma[s] else None
        demand(f"batch {s} ≥ 0.75 of the limit of the arithmetic", ratio(limit, widest[s]), 0.75)
        conventional = fma[s] * 81 if fma[s] else None
        demand(f"batch {s} ≥ 0.75 of the conventional form's limit", ratio(conventional, widest[s]), 0.75)
        demand(f"fleet {s} ≥ 0.7 of the batch", ratio(widest[s], fleet(s, "one core")), 0.7)
        demand(f"two cores ≥ 1.9 × one, fleet {s}",
               ratio(fleet(s, "one core"), fleet(s, "two cores")), 1.9)
    demand("two cores ≥ 1.9 × one, batch of 4096",
           ratio(get("rls batch of 4096, n = 5", "f64, threads: 1"),
                 get("rls batch of 4096, n = 5", "f64, threads: 2")), 1.9)
    table(*checks)

    say("## By number of parameters, updates/s")
    say("")
    sizes = [2, 5, 10, 20]
    names = sorted({n for (g, n) in ours if g.startswith(("rls update, n", "rls batch, n"))})
    rows = [["what", *(f"n = {n}" for n in sizes)]]
    for prefix, label in [("rls update", ""), ("rls batch", "batch, ")]:
        for name in names:
            cells = [get(f"{prefix}, n = {n}", name) for n in sizes]
            if any(cells):
                rows.append([label + name, *map(rate, cells)])
    table(*rows)

reductions = {p["what"]: p["fastest"] for p in peers if p["what"].startswith("balanced truncation")}
rows = [["states", "fdiag", "slycot AB09AD", "slycot / fdiag"]]
for n in (17, 100, 500, 1000):
    mine, theirs = get("balanced truncation", f"n = {n}"), reductions.get(f"balanced truncation, n = {n}")
    if mine:
        rows.append([n, duration(mine), duration(theirs) if theirs else "–",
                     f"{theirs / mine:.2f}" if theirs else "–"])
if len(rows) > 1:
    say("## Balanced truncation to 5 states")
    say("")
    table(*rows)

for title, prefix in [("Order search", "order selection"), ("Pipeline, per sample", "sample,"),
                      ("The engine's equations", "engine17"), ("Runs of the engine", "run of"),
                      ("Simulations of models written as equations", "simulations of")]:
    found = [(g, n, ns) for (g, n), ns in sorted(ours.items()) if g.startswith(prefix)]
    if found:
        say(f"## {title}")
        say("")
        table(["what", "fastest", "median", "per second"],
              *[[f"{g}: {n}", duration(ns[0]), duration(ns[1]), rate(ns[0])] for g, n, ns in found])

runs = [p for p in peers if p["what"] == "Monte Carlo"]
if runs:
    say("## Monte Carlo of the engine: `fdiag engine --seeds N`")
    say("")
    table(["seeds", "by the clock", "processor time", "largest memory"],
          *[[p["seeds"], f"{p['seconds']:.1f} s", f"{p['processor']:.1f} s", f"{p['memory']:.0f} MiB"]
            for p in runs])

if notes:
    say("## Left out")
    say("")
    for line in notes:
        say(f"* {line}")
    say("")
pathlib.Path(output).write_text("\n".join(lines).rstrip() + "\n")
