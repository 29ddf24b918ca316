"""Writes the recordings in SQLite of this folder with the writer of rosbags.

    pip install rosbags==0.11.9
    python make_bag.py

`robot.db3` has definitions of its messages in it, as of ROS 2 Iron and later. From `humble.db3` their table was taken by
SQLite, since earlier ones have none. Long lists of numbers do not fit a page of SQLite.
"""

import shutil
import sqlite3
import tempfile
from pathlib import Path

import numpy as np
from make_mcap import START, TOPICS, ROS, T
from rosbags.rosbag2 import StoragePlugin, Writer

HERE = Path(__file__).parent


def long_list(k, _):
    layout = T["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return T["std_msgs/msg/Float64MultiArray"](layout=layout, data=k + np.arange(700.0))


ALL = {**TOPICS, "/long": ("std_msgs/msg/Float64MultiArray", long_list, 100)}


def write(name, version, topics):
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with Writer(bag, version=version, storage_plugin=StoragePlugin.SQLITE3) as writer:
            of = {t: writer.add_connection(t, topics[t][0], typestore=ROS) for t in topics}
            for ms in range(0, 400):
                for topic, (kind, make, step) in topics.items():
                    late = 3 if topic == "/command" else 0
                    if ms >= late and (ms - late) % step == 0:
                        ns = START + ms * 1_000_000
                        data = ROS.serialize_cdr(make((ms - late) // step, ns - 1_000_000), kind)
                        writer.write(of[topic], ns, data)
        (made,) = bag.glob("*.db3")
        shutil.copy(made, HERE / name)


write("robot.db3", 9, ALL)
write("humble.db3", 8, {t: ALL[t] for t in ("/joint_states", "/command", "/imu", "/cmd_vel", "/wrench", "/odom")})
with sqlite3.connect(HERE / "humble.db3") as humble:
    humble.execute("DROP TABLE message_definitions")
humble.execute("VACUUM")
