"""Measures `fdiag-lab engine` with 100 and 1000 seeds: time by the clock, processor time, memory."""

import json
import os
import subprocess
import sys
import tempfile
import time

binary = "target/release/fdiag"
if not os.path.exists(binary):
    sys.exit("fdiag-lab engine: not built")
for seeds in (10, 20) if "--quick" in sys.argv else (100, 1000):
    with tempfile.TemporaryDirectory() as room:
        start = time.perf_counter()
        child = subprocess.Popen(
            [os.path.abspath(binary), "engine", "--seeds", str(seeds)], cwd=room,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        error = child.stderr.read().decode()
        _, status, usage = os.wait4(child.pid, 0)
        seconds = time.perf_counter() - start
    if status:
        sys.exit(f"fdiag-lab engine: {error.strip()}")
    print(json.dumps({"name": "fdiag-lab engine", "what": "Monte Carlo", "seeds": seeds,
                      "seconds": seconds, "processor": usage.ru_utime + usage.ru_stime,
                      "memory": usage.ru_maxrss / 1024}))
