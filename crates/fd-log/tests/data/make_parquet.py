"""Writes the Parquet file and the LeRobot datasets of this folder with pyarrow.

    pip install numpy==2.4.6 pyarrow==26.0.1
    python make_parquet.py

The datasets have the layout of LeRobot's versions 2.1 (an episode per file) and 3.0 (many in a file), without videos.
"""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

HERE = Path(__file__).parent
k = np.arange(60)
gone = np.where(k == 7, None, k / 3).tolist()
table = pa.table(
    {
        "stamp": pa.array((1_763_899_200_000_000_001 + k * 20_000_000).tolist(), pa.timestamp("ns")),
        "u": pa.array((k % 5).tolist(), pa.uint8()),
        "y": pa.array(gone, pa.float64()),
        "on": pa.array((k % 2 == 0).tolist()),
        "ms": pa.array((k * 20).tolist(), pa.duration("ms")),
        "q": pa.array([[float(i), -float(i)] if i != 3 else [3.0] for i in k], pa.list_(pa.float32())),
        "remark": pa.array([f"row {i}" for i in k]),
    }
)
pq.write_table(table, HERE / "table.parquet", row_group_size=25)
pq.write_table(table, HERE / "table.zstd.parquet", compression="zstd", data_page_version="2.0")

NAMES = ["shoulder_pan", "gripper"]


def episodes(version):
    rows = []
    for episode in range(3):
        for frame in range(20 + episode):
            rows.append((episode, frame, [np.sin(frame / 4) + episode, 0.5], [np.sin((frame - 2) / 4), 0.25]))
    columns = {
        "action": pa.array([r[2] for r in rows], pa.list_(pa.float32(), 2)),
        "observation.state": pa.array([r[3] for r in rows], pa.list_(pa.float32(), 2)),
        "timestamp": pa.array([r[1] / 30 for r in rows], pa.float32()),
        "frame_index": pa.array([r[1] for r in rows], pa.int64()),
        "episode_index": pa.array([r[0] for r in rows], pa.int64()),
    }
    table = pa.table(columns)
    folder = HERE / f"lerobot-{version}"
    data = folder / "data" / "chunk-000"
    data.mkdir(parents=True, exist_ok=True)
    (folder / "meta").mkdir(exist_ok=True)
    if version == "v2.1":
        for episode in range(3):
            part = table.filter(pa.compute.equal(table["episode_index"], episode))
            pq.write_table(part, data / f"episode_{episode:06d}.parquet")
        path, names = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet", {"motors": NAMES}
    else:
        pq.write_table(table, data / "file-000.parquet")
        path, names = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet", NAMES
    feature = {"dtype": "float32", "shape": [2], "names": names}
    plain = {"dtype": "int64", "shape": [1], "names": None}
    info = {
        "codebase_version": version,
        "robot_type": "so100",
        "total_episodes": 3,
        "total_frames": len(rows),
        "fps": 30,
        "data_path": path,
        "features": {"action": feature, "observation.state": feature, "frame_index": plain, "episode_index": plain},
    }
    (folder / "meta" / "info.json").write_text(json.dumps(info, indent=4))


import pyarrow.compute  # noqa: E402

episodes("v2.1")
episodes("v3.0")
