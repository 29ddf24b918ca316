"""Writes the recordings of this folder with the writers of MCAP and rosbags, whose CDR is not ours.

    pip install mcap==1.6.0 mcap-ros2-support==0.6.0 rosbags==0.11.9
    python make_mcap.py
"""

import math
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
ROS = get_typestore(Stores.ROS2_HUMBLE)
T = ROS.types
START = 1_763_899_200_123_456_789


def stamp(ns):
    return T["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)


def header(ns):
    return T["std_msgs/msg/Header"](stamp=stamp(ns), frame_id="base")


def vector(x, y, z):
    return T["geometry_msgs/msg/Vector3"](x=float(x), y=float(y), z=float(z))


def joints(k, ns):
    names, q = ["elbow", "wrist"], [math.sin(k / 10), k / 8]
    if k % 2:  # the order of joints is not promised
        names, q = names[::-1], q[::-1]
    return T["sensor_msgs/msg/JointState"](
        header=header(ns), name=names, position=np.array(q), velocity=np.array([]), effort=np.array([])
    )


def command(k, _):
    dim = T["std_msgs/msg/MultiArrayDimension"](label="odd", size=1, stride=1)
    layout = T["std_msgs/msg/MultiArrayLayout"](dim=[dim], data_offset=0)
    return T["std_msgs/msg/Float64MultiArray"](layout=layout, data=np.array([k / 4.0]))


def imu(k, ns):
    zeros = np.zeros(9)
    turn = T["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    return T["sensor_msgs/msg/Imu"](
        header=header(ns), orientation=turn, orientation_covariance=zeros,
        angular_velocity=vector(k, 2, 3), angular_velocity_covariance=zeros,
        linear_acceleration=vector(0, 0, 9.75), linear_acceleration_covariance=np.arange(9.0),
    )  # fmt: skip


def twist(k, _=None):
    return T["geometry_msgs/msg/Twist"](linear=vector(k, 0, 0), angular=vector(0, 0, -k))


def wrench(k, ns):
    inner = T["geometry_msgs/msg/Wrench"](force=vector(k, 1, 2), torque=vector(3, 4, 5))
    return T["geometry_msgs/msg/WrenchStamped"](header=header(ns), wrench=inner)


def odometry(k, ns):
    pose = T["geometry_msgs/msg/Pose"](
        position=T["geometry_msgs/msg/Point"](x=k / 2.0, y=0.0, z=0.0),
        orientation=T["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
    )
    return T["nav_msgs/msg/Odometry"](
        header=header(ns), child_frame_id="odd one",
        pose=T["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
        twist=T["geometry_msgs/msg/TwistWithCovariance"](twist=twist(k), covariance=np.arange(36.0)),
    )  # fmt: skip


TOPICS = {
    "/joint_states": ("sensor_msgs/msg/JointState", joints, 10),
    "/command": ("std_msgs/msg/Float64MultiArray", command, 25),
    "/imu": ("sensor_msgs/msg/Imu", imu, 20),
    "/cmd_vel": ("geometry_msgs/msg/Twist", twist, 50),
    "/wrench": ("geometry_msgs/msg/WrenchStamped", wrench, 50),
    "/odom": ("nav_msgs/msg/Odometry", odometry, 50),
    "/say": ("std_msgs/msg/String", lambda k, _: T["std_msgs/msg/String"](data=f"line {k}"), 100),
}


def write(path, compression):
    with open(path, "wb") as out:
        writer = Writer(out, compression=compression, chunk_size=4000)
        writer.start(profile="ros2", library="test")
        channels = {}
        for topic, (kind, _, _) in TOPICS.items():
            text, _ = ROS.generate_msgdef(kind, ros_version=2)
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        note = writer.register_schema("Note", "jsonschema", b"{}")
        notes = writer.register_channel("/note", "json", note)
        writer.add_message(notes, log_time=START, publish_time=START, data=b'{"a": 1}')
        # Milliseconds; the command comes 3 ms after the joints.
        for ms in range(0, 1000):
            for topic, (kind, make, step) in TOPICS.items():
                late = 3 if topic == "/command" else 0
                if ms >= late and (ms - late) % step == 0:
                    ns = START + ms * 1_000_000
                    # A stamp is taken a millisecond before it is logged.
                    data = ROS.serialize_cdr(make((ms - late) // step, ns - 1_000_000), kind)
                    writer.add_message(channels[topic], log_time=ns, publish_time=ns, data=bytes(data))
        writer.finish()


write(HERE / "robot.mcap", CompressionType.ZSTD)
write(HERE / "robot.lz4.mcap", CompressionType.LZ4)
