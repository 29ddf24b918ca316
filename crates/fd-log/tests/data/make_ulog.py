"""Writes the flight log of this folder with pyulog: its writer wants a log that it has read, which is made here first.

    pip install numpy==2.4.6 pyulog==1.3.0
    python make_ulog.py
"""

import io
import math
import struct
import tempfile
from pathlib import Path

from pyulog import ULog

HERE = Path(__file__).parent
START = 5_000_000  # microseconds since boot


def message(kind, content):
    return struct.pack("<HB", len(content), ord(kind)) + content


raw = io.BytesIO()
raw.write(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", START))
raw.write(message("B", bytes(40)))
raw.write(message("F", b"attitude:uint64_t timestamp;float[4] q;uint8_t[4] _padding0;"))
raw.write(message("F", b"inner:float x;int16_t y;uint8_t[2] _padding0;"))
accel = b"uint64_t timestamp;double temperature;inner[2] parts;bool clipped;char[3] tag;uint8_t[4] _padding0;"
raw.write(message("F", b"accel:" + accel))
key = b"char[4] ver_hw"
raw.write(message("I", bytes([len(key)]) + key + b"TEST"))
raw.write(message("A", struct.pack("<BH", 0, 0) + b"attitude"))
raw.write(message("A", struct.pack("<BH", 0, 1) + b"accel"))
raw.write(message("A", struct.pack("<BH", 1, 2) + b"accel"))
for k in range(50):
    at = START + 20_000 * k
    raw.write(message("D", struct.pack("<HQ4f", 0, at, math.cos(k / 8), k / 4, 0, -1)))  # padding may be left out
    for instance in range(2):
        late = at + 1_000 + instance
        parts = struct.pack("<fh2xfh2x", k, -k, instance, 300)
        head = struct.pack("<HQd", 1 + instance, late, 20 + k / 2)
        raw.write(message("D", head + parts + struct.pack("<?3s", k % 2, b"abc")))
raw.write(message("O", struct.pack("<H", 15)))
with tempfile.NamedTemporaryFile(suffix=".ulg") as file:
    file.write(raw.getvalue())
    file.flush()
    ULog(file.name).write_ulog(str(HERE / "flight.ulg"))
