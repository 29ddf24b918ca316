//! Definitions of usual messages of ROS 2 (`common_interfaces`, `geometry2`), for recordings that have none.

use super::super::message::{Definitions, definition};

/// As MCAP has them; the same in all distributions from Foxy to Jazzy.
const TEXT: &str = "\
int32 sec
uint32 nanosec
=====
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
=====
MSG: std_msgs/Bool
bool data
=====
MSG: std_msgs/Int32
int32 data
=====
MSG: std_msgs/Int64
int64 data
=====
MSG: std_msgs/Float32
float32 data
=====
MSG: std_msgs/Float64
float64 data
=====
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
=====
MSG: std_msgs/MultiArrayLayout
MultiArrayDimension[] dim
uint32 data_offset
=====
MSG: std_msgs/Float32MultiArray
MultiArrayLayout layout
float32[] data
=====
MSG: std_msgs/Float64MultiArray
MultiArrayLayout layout
float64[] data
=====
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
=====
MSG: geometry_msgs/Vector3Stamped
std_msgs/Header header
Vector3 vector
=====
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
=====
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
=====
MSG: geometry_msgs/Pose
Point position
Quaternion orientation
=====
MSG: geometry_msgs/PoseStamped
std_msgs/Header header
Pose pose
=====
MSG: geometry_msgs/PoseWithCovariance
Pose pose
float64[36] covariance
=====
MSG: geometry_msgs/Twist
Vector3 linear
Vector3 angular
=====
MSG: geometry_msgs/TwistStamped
std_msgs/Header header
Twist twist
=====
MSG: geometry_msgs/TwistWithCovariance
Twist twist
float64[36] covariance
=====
MSG: geometry_msgs/Wrench
Vector3 force
Vector3 torque
=====
MSG: geometry_msgs/WrenchStamped
std_msgs/Header header
Wrench wrench
=====
MSG: geometry_msgs/Transform
Vector3 translation
Quaternion rotation
=====
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
Transform transform
=====
MSG: tf2_msgs/TFMessage
geometry_msgs/TransformStamped[] transforms
=====
MSG: nav_msgs/Odometry
std_msgs/Header header
string child_frame_id
geometry_msgs/PoseWithCovariance pose
geometry_msgs/TwistWithCovariance twist
=====
MSG: sensor_msgs/Imu
std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
=====
MSG: sensor_msgs/JointState
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
";

/// All of them.
pub(super) fn definitions() -> Definitions {
    definition::parse("builtin_interfaces/Time", TEXT).unwrap_or_default()
}
