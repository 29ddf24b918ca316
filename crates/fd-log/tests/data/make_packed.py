"""Writes the packed logs of this folder with the writers that people have: gzip of Python, zstandard.

    pip install zstandard==0.25.0
    python make_packed.py
"""

import gzip
import json
import math
from pathlib import Path

import zstandard

HERE = Path(__file__).parent
rows = [(k / 10, math.sin(k / 10), 20 + k / 4) for k in range(50)]
csv = "t,u [V],y [degC]\n" + "".join(f"{t!r},{u!r},{y!r}\n" for t, u, y in rows)
ndjson = "".join(json.dumps({"t": t, "u [V]": u, "y [degC]": y}) + "\n" for t, u, y in rows)

# Two members one after the other, as `cat a.gz b.gz` makes them.
half = csv.index("\n2.5,") + 1
members = [gzip.compress(part.encode(), mtime=0) for part in (csv[:half], csv[half:])]
(HERE / "run.csv.gz").write_bytes(b"".join(members))

# A frame with a checksum, one to be skipped, and one without.
checked = zstandard.ZstdCompressor(level=19, write_checksum=True).compress(ndjson[:1200].encode())
skipped = b"\x50\x2a\x4d\x18" + (5).to_bytes(4, "little") + b"notes"
plain = zstandard.ZstdCompressor(level=1).compress(ndjson[1200:].encode())
(HERE / "run.ndjson.zst").write_bytes(checked + skipped + plain)
