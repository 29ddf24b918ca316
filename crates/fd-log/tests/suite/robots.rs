//! Recordings of ROS 2 and of PX4, as their own writers wrote them, and as nobody should.

#![cfg(all(feature = "mcap", feature = "rosbag", feature = "ulog"))]
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]
#![allow(clippy::float_cmp, reason = "what is compared so was written exactly")]

use std::path::PathBuf;

use fd_log::{LogError, LogMap, read_log};

fn data(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")).join(name)
}

fn map(text: &str) -> LogMap {
    toml::from_str(text).unwrap()
}

/// One output, from this column.
fn output(column: &str) -> LogMap {
    map(&format!("outputs = [{{ name = 'y', column = '{column}' }}]"))
}

#[test]
fn messages_of_ros_2_are_columns() {
    for name in ["robot.mcap", "robot.lz4.mcap"] {
        let read = |column: &str| {
            let record = read_log(data(name), &output(column)).unwrap().record;
            (record.len(), record.ts().seconds(), record.output(0).collect::<Vec<_>>())
        };
        let (rows, step, elbow) = read("/joint_states.position[elbow]");
        assert_eq!(rows, 100);
        // Nanoseconds times 1e-9.
        assert!((step - 0.01).abs() < 1e-12, "{step}");
        for (k, elbow) in elbow.iter().enumerate() {
            assert!(
                (elbow - (k as f64 / 10.0).sin()).abs() < 1e-15,
                "the order of joints changes: {k}"
            );
        }
        let at_4 = |column: &str| read(column).2[4];
        assert_eq!(at_4("/joint_states.position[wrist]"), 0.5);
        assert_eq!(at_4("/command.data[0]"), 1.0);
        assert_eq!(at_4("/imu.angular_velocity.x"), 4.0);
        assert_eq!(at_4("/imu.linear_acceleration.z"), 9.75);
        assert_eq!(at_4("/imu.linear_acceleration_covariance[8]"), 8.0);
        assert_eq!(at_4("/cmd_vel.angular.z"), -4.0);
        assert_eq!(at_4("/wrench.wrench.torque.z"), 5.0);
        assert_eq!(at_4("/odom.pose.pose.position.x"), 2.0);
        assert_eq!(at_4("/odom.twist.covariance[35]"), 35.0);
        // Taken a millisecond before it was logged, 80 ms after the first message.
        assert!((at_4("/imu.header.stamp") - 0.079).abs() < 1e-12);
    }
}

#[test]
fn topics_with_clocks_of_their_own_are_merged_only_as_stated() {
    let both = "inputs = [{ name = 'u', column = '/command.data[0]' }]\n\
                outputs = [{ name = 'y', column = '/joint_states.position[wrist]' }]\n";
    let read = |more: &str| read_log(data("robot.mcap"), &map(&format!("{both}{more}")));
    let said = read("").unwrap_err().to_string();
    for part in [
        "/command (40 rows, 0.025000 s apart)",
        "/joint_states (100 rows, 0.010000 s apart)",
        "max_age_s",
    ] {
        assert!(said.contains(part), "{said}");
    }
    assert!(matches!(
        read("merge = { clock = '/joint_states' }"),
        Err(LogError::SeveralClocks { .. })
    ));
    let unknown = read("merge = { clock = '/joint', max_age_s = 1 }").unwrap_err().to_string();
    assert!(unknown.contains("no topic `/joint`") && unknown.contains("\"/imu\""), "{unknown}");
    assert!(matches!(
        read("merge = { clock = '/command', max_age_s = -1 }"),
        Err(LogError::Age { .. })
    ));

    // Commands come at 3, 28, 53... ms; joints at 0, 10, 20... ms.
    let record = read("merge = { clock = '/joint_states', max_age_s = 0.02 }").unwrap().record;
    assert_eq!(record.len(), 100);
    for (row, k) in (0..100_i32).enumerate() {
        let (u, y) = (record.u(row)[0], record.y(row)[0]);
        assert_eq!(y, f64::from(k) / 8.0);
        let last = (10 * k - 3).div_euclid(25);
        let age = 10 * k - 3 - 25 * last;
        if last < 0 || age > 20 {
            assert!(u.is_nan(), "{k}: a command of {age} ms ago is too old");
        } else {
            assert_eq!(u, f64::from(last) / 4.0, "{k}");
        }
    }
    // The other clock: joints of up to 10 ms ago.
    let record = read("merge = { clock = '/command', max_age_s = 0.0101 }").unwrap().record;
    assert_eq!((record.len(), record.u(3), record.y(3)), (40, &[0.75][..], &[7.0 / 8.0][..]));
}

#[test]
fn what_is_no_column_says_why() {
    let said =
        |column: &str| read_log(data("robot.mcap"), &output(column)).unwrap_err().to_string();
    assert!(said("/say").ends_with("found messages without numbers"), "{}", said("/say"));
    assert!(said("/imu.angular_velocity.w").contains("did you mean `/imu.angular_velocity."));
}

#[test]
fn flights_are_read() {
    let read = |column: &str| read_log(data("flight.ulg"), &output(column)).unwrap().record;
    let record = read("attitude.q[1]");
    assert_eq!((record.len(), record.y(3)), (50, &[0.75][..]));
    // Microseconds times 1e-6.
    assert!((record.ts().seconds() - 0.02).abs() < 1e-12 && record.time(0).abs() < 1e-12);
    assert!((read("accel.parts[0].y").time(0) - 1e-3).abs() < 1e-12);
    for (column, value) in [
        ("accel.temperature", 21.5),
        ("accel.parts[0].y", -3.0),
        ("accel.parts[1].x", 0.0),
        ("accel_1.parts[1].x", 1.0),
        ("accel_1.parts[1].y", 300.0),
        ("accel_1.clipped", 1.0),
    ] {
        assert_eq!(read(column).y(3), [value], "{column}");
    }
    let said = read_log(data("flight.ulg"), &output("accel.tag[0]")).unwrap_err();
    assert!(matches!(said, LogError::MissingColumn { .. }));
}

#[test]
fn rubbish_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, bytes: &[u8], column: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        read_log(&path, &output(column))
    };
    for (name, column, steps) in [
        ("robot.mcap", "/cmd_vel.linear.x", 211),
        ("robot.lz4.mcap", "/cmd_vel.linear.x", 211),
        ("flight.ulg", "accel.temperature", 29),
        ("humble.db3", "/cmd_vel.linear.x", 397),
    ] {
        let whole = std::fs::read(data(name)).unwrap();
        assert!(matches!(read(name, b"", column), Err(LogError::Empty { .. })));
        assert!(matches!(read(name, b"t,u\n0,1\n", column), Err(LogError::Damaged { .. })));
        let mut cut = 0;
        for length in (16..whole.len()).step_by(steps) {
            // A log of PX4 may end behind any message, one of MCAP behind the end of its data.
            cut += usize::from(read(name, &whole[..length], column).is_err());
        }
        assert!(cut * steps * 3 > whole.len(), "{name}: {cut}");
        assert!(
            matches!(read(name, &whole[..whole.len() / 2], column), Err(LogError::Damaged { .. })),
            "{name}"
        );
        // Any byte changed: an error or other numbers, but no panic.
        for place in (0..whole.len()).step_by(steps) {
            let mut changed = whole.clone();
            changed[place] ^= 0xff;
            drop(read(name, &changed, column));
        }
    }
}

#[test]
fn claims_of_size_are_not_believed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.mcap");
    for length in [1_u64 << 29, 1 << 40, u64::MAX] {
        let bytes = [b"\x89MCAP0\r\n\x01".as_slice(), &length.to_le_bytes(), b"few"].concat();
        std::fs::write(&path, bytes).unwrap();
        let error = read_log(&path, &output("/a.b")).unwrap_err();
        assert!(matches!(error, LogError::Damaged { .. }), "{error}");
    }
}

#[test]
fn recordings_in_sqlite_are_those_in_mcap() {
    for name in ["robot.db3", "humble.db3"] {
        let read = |file: &str, column: &str| {
            let record = read_log(data(file), &output(column)).unwrap().record;
            (record.ts().seconds(), record.output(0).collect::<Vec<_>>())
        };
        for column in [
            "/joint_states.position[elbow]",
            "/joint_states.position[wrist]",
            "/command.data[0]",
            "/imu.angular_velocity.x",
            "/imu.linear_acceleration_covariance[8]",
            "/cmd_vel.angular.z",
            "/wrench.wrench.torque.z",
            "/odom.pose.pose.position.x",
            "/odom.twist.covariance[35]",
            "/imu.header.stamp",
        ] {
            // The same second was recorded, of which this file has the beginning.
            let ((step, found), (other, all)) = (read(name, column), read("robot.mcap", column));
            assert!(found.len() > 7 && found.len() < all.len(), "{name}: {column}");
            assert_eq!(found[..], all[..found.len()], "{name}: {column}");
            assert!((step - other).abs() < 1e-12);
        }
    }
    // Rows of 5600 bytes are on pages of their own.
    let long = read_log(data("robot.db3"), &output("/long.data[699]")).unwrap().record;
    assert_eq!(long.output(0).collect::<Vec<_>>(), [699.0, 700.0, 701.0, 702.0]);
    let said =
        |file: &str, column: &str| read_log(data(file), &output(column)).unwrap_err().to_string();
    assert!(said("robot.db3", "/say").ends_with("found messages without numbers"));
    assert!(said("humble.db3", "/imu.angular_velocity.w").contains("did you mean"));
}

#[test]
fn a_recording_whose_end_is_elsewhere_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.db3");
    std::fs::copy(data("robot.db3"), &path).unwrap();
    std::fs::write(folder.path().join("robot.db3-wal"), b"").unwrap();
    assert!(read_log(&path, &output("/cmd_vel.linear.x")).is_ok());
    std::fs::write(folder.path().join("robot.db3-wal"), b"more").unwrap();
    let said = read_log(&path, &output("/cmd_vel.linear.x")).unwrap_err().to_string();
    assert!(said.contains("robot.db3-wal") && said.contains("open it once with SQLite"), "{said}");
}
