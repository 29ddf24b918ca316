//! Recordings whose messages are JSON or protocol buffers, and sensors that send in turn on one topic.

#![cfg(feature = "mcap")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "bytes are cut out of small numbers"
)]
#![allow(clippy::float_cmp, reason = "what is compared so was written exactly")]

use fd_log::{LogInfo, LogMap, info, read_log};

/// The first message of a recording, in nanoseconds since 1970.
const START: u64 = 1_700_000_000_000_000_000;

/// A recording that is written here: <https://mcap.dev/spec>.
struct Recording(Vec<u8>);

fn text(text: &[u8]) -> Vec<u8> {
    [&u32::try_from(text.len()).unwrap().to_le_bytes(), text].concat()
}

impl Recording {
    fn new() -> Self {
        Self(b"\x89MCAP0\r\n".to_vec())
    }

    fn record(&mut self, kind: u8, parts: &[&[u8]]) {
        let content = parts.concat();
        self.0.push(kind);
        self.0.extend((content.len() as u64).to_le_bytes());
        self.0.extend(content);
    }

    fn topic(&mut self, id: u16, topic: &str, schema: (&str, &str, &[u8]), encoding: &str) {
        let (name, kind, data) = schema;
        let id = id.to_le_bytes();
        self.record(3, &[&id, &text(name.as_bytes()), &text(kind.as_bytes()), &text(data)]);
        let none = text(b"");
        self.record(4, &[&id, &id, &text(topic.as_bytes()), &text(encoding.as_bytes()), &none]);
    }

    /// A message after so many milliseconds.
    fn message(&mut self, id: u16, ms: u64, data: &[u8]) {
        let time = (START + 1_000_000 * ms).to_le_bytes();
        self.record(5, &[&id.to_le_bytes(), &[0; 4], &time, &time, data]);
    }

    fn written<T>(mut self, read: impl FnOnce(&std::path::Path) -> T) -> T {
        self.record(15, &[&[0; 4]]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        std::fs::write(&path, self.0).unwrap();
        read(&path)
    }
}

fn map(text: &str) -> LogMap {
    toml::from_str(text).unwrap()
}

#[test]
fn messages_in_json_are_columns() {
    let mut recording = Recording::new();
    recording.topic(1, "/state", ("State", "jsonschema", b"{}"), "json");
    for k in 0..20_u64 {
        let x = k as f64 / 4.0;
        let message = format!(
            r#"{{"q": [{x}, 1], "pose": {{"x": {x}}}, "on": true, "note": "a", "name": ["a", "b"], "effort": [0, {k}],
                "stamp": {{"sec": 1700000001, "nsec": 500000000}}}}"#
        );
        recording.message(1, 10 * k, message.as_bytes());
    }
    let record = recording.written(|path| {
        let outputs = ["q[a]", "pose.x", "on", "effort[b]", "stamp"];
        let outputs: Vec<String> = (0..)
            .zip(outputs)
            .map(|(n, column)| format!("{{ name = 'y{n}', column = '/state.{column}' }}"))
            .collect();
        read_log(path, &map(&format!("outputs = [{}]", outputs.join(", ")))).unwrap().record
    });
    assert_eq!((record.len(), record.ts().seconds()), (20, 0.01));
    assert_eq!(record.y(4), [1.0, 1.0, 1.0, 4.0, 1.5]);
}

/// A field of a message of protocol buffers with bytes in it, and one with a number of seven bits a byte.
fn bytes(number: u8, content: &[u8]) -> Vec<u8> {
    assert!(content.len() < 16_384);
    let length = [content.len() as u8 | 0x80, (content.len() >> 7) as u8];
    [&[number << 3 | 2][..], &length, content].concat()
}

fn varint(number: u8, value: u64) -> Vec<u8> {
    let mut out = vec![number << 3];
    let mut rest = value;
    while rest > 0x7f {
        out.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    out.push(rest as u8);
    out
}

/// `FieldDescriptorProto`.
fn field(name: &str, number: u64, label: u64, kind: u64, of: &str) -> Vec<u8> {
    let of = if of.is_empty() { Vec::new() } else { bytes(6, of.as_bytes()) };
    let all = [bytes(1, name.as_bytes()), varint(3, number), varint(4, label), varint(5, kind), of];
    bytes(2, &all.concat())
}

#[test]
fn messages_of_protocol_buffers_are_columns_by_their_schema() {
    let inner = [bytes(1, b"Point"), field("x", 1, 1, 1, ""), field("y", 2, 1, 2, "")].concat();
    let state = [
        bytes(1, b"State"),
        field("at", 1, 1, 11, ".google.protobuf.Timestamp"),
        field("point", 2, 1, 11, ".lab.State.Point"),
        field("q", 3, 3, 1, ""),
        field("count", 4, 1, 17, ""),
        field("on", 5, 1, 8, ""),
        field("label", 6, 1, 9, ""),
        field("small", 7, 1, 5, ""),
        bytes(3, &inner),
    ]
    .concat();
    let stamp =
        [bytes(1, b"Timestamp"), field("seconds", 1, 1, 3, ""), field("nanos", 2, 1, 5, "")];
    let file = |package: &[u8], message: &[u8]| {
        bytes(1, &[bytes(2, package), bytes(4, message), bytes(12, b"proto3")].concat())
    };
    let set = [file(b"google.protobuf", &stamp.concat()), file(b"lab", &state)].concat();
    let mut recording = Recording::new();
    recording.topic(7, "/state", ("lab.State", "protobuf", &set), "protobuf");
    for k in 0..20_u64 {
        let x = k as f64 / 8.0;
        let double = |number: u8, x: f64| [&[number << 3 | 1][..], &x.to_le_bytes()].concat();
        let float = [&[2 << 3 | 5][..], &(x as f32).to_le_bytes()].concat();
        let message = [
            bytes(1, &[varint(1, 1_700_000_000), varint(2, 250_000_000)].concat()),
            bytes(2, &[double(1, x), float].concat()),
            bytes(3, &[x.to_le_bytes(), (-x).to_le_bytes()].concat()),
            // -3 as `sint32`; `on` is false and not written.
            varint(4, 5),
            bytes(6, b"a"),
            varint(7, (-7_i64) as u64),
            // A field that nobody defined is passed over.
            varint(9, 1),
        ];
        recording.message(7, 10 * k, &message.concat());
    }
    let record = recording.written(|path| {
        let outputs = ["at", "point.x", "point.y", "q[1]", "count", "on", "small"];
        let outputs: Vec<String> = (0..)
            .zip(outputs)
            .map(|(n, column)| format!("{{ name = 'y{n}', column = '/state.{column}' }}"))
            .collect();
        read_log(path, &map(&format!("outputs = [{}]", outputs.join(", ")))).unwrap().record
    });
    assert_eq!((record.len(), record.ts().seconds()), (20, 0.01));
    assert_eq!(record.y(8), [0.25, 1.0, 1.0, -1.0, -3.0, 0.0, -7.0]);
}

#[test]
fn messages_that_are_cut_or_flipped_do_not_stop_the_program() {
    let message = [bytes(1, b"State"), field("q", 3, 3, 1, "")].concat();
    let set = bytes(1, &[bytes(4, &message), bytes(12, b"proto3")].concat());
    for length in 0..set.len() {
        let mut recording = Recording::new();
        recording.topic(1, "/s", ("State", "protobuf", &set[..length]), "protobuf");
        recording.message(1, 0, &[0xff, 0xff]);
        recording
            .written(|path| assert!(read_log(path, &map("outputs = [{ name = 'y' }]")).is_err()));
    }
}

#[test]
fn two_sensors_in_turn_on_one_topic_are_two() {
    let mut recording = Recording::new();
    recording.topic(1, "/range", ("Range", "jsonschema", b"{}"), "json");
    for k in 0..40_u64 {
        let side = if k % 2 == 0 { "left" } else { "right" };
        let range = if k % 2 == 0 { k as f64 } else { -1.0 };
        let message = format!(r#"{{"header": {{"frame_id": "{side}"}}, "range": {range}}}"#);
        recording.message(1, 10 * k, message.as_bytes());
    }
    let (found, left, both): (LogInfo, _, _) = recording.written(|path| {
        let read = |column: &str| {
            read_log(path, &map(&format!("outputs = [{{ name = 'y', column = '{column}' }}]")))
        };
        let both = read("/range.range").unwrap_err().to_string();
        (info(path, &LogMap::default()).unwrap(), read("/range[left].range").unwrap().record, both)
    });
    assert_eq!(found.tables.iter().map(|table| table.rows).collect::<Vec<_>>(), [20, 20]);
    assert!(found.left[0].1.contains("/range[left], /range[right]"), "{:?}", found.left);
    assert_eq!((left.len(), left.ts().seconds(), left.y(3)), (20, 0.02, &[6.0][..]));
    assert!(both.contains("/range[left].range"), "{both}");
}
