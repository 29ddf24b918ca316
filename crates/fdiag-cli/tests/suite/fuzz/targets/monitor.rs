//! What a monitor reads: streams, messages of brokers, and its own state.

use std::fs;

use fd_watch::{
    Format, InputMap, Learning, Message, Monitor, Plan, Request, Row, RowReader, StateFolder,
};
use fdiag::{core::Snapshot, log::LogMap, model::file::LinearModel};

use super::Target;

const MODEL: &str = "version = 1\nkind = \"state-space\"\nsample_time = 1.0\ninputs = [{ name = \"u\", unit = \"V\" }]\n\
    outputs = [{ name = \"T\", unit = \"K\" }]\nmatrices = { A = [[0.9]], B = [[0.1]], C = [[1.0]], D = [[0.0]] }\n";
const SPEC: &str = "bias.orders = { kind = \"fixed\", na = 1, nb = 1 }\nrule = { raise = 1, out_of = 1, clear = 2 }\n";

fn model() -> LinearModel {
    LinearModel::parse("model.toml", MODEL).unwrap()
}

/// Units learn from forty samples each.
fn plan() -> Plan {
    let spec = SPEC.parse().unwrap();
    let learning = Learning::Stream { samples: 400 };
    Request { spec, most_units: 50, ..Request::new(model(), learning) }.plan().unwrap()
}

/// A line for each of so many samples.
fn lines(samples: u32, line: impl Fn(f64, f64, f64) -> String) -> Vec<u8> {
    let mut x = 0.0;
    let mut text = String::new();
    for k in 0..samples {
        let u = if k / 7 % 2 == 0 { 1.0 } else { -0.4 };
        x = 0.88 * x + 0.12 * u;
        text.push_str(&line(f64::from(k), u, x));
    }
    text.into_bytes()
}

/// Lines as they come over a pipe or from a broker, into a monitor.
fn stream(name: &'static str, format: Format, unit: Option<&'static str>, own: Vec<u8>) -> Target {
    let input = InputMap::new(LogMap::for_model(&model()));
    let input = if unit.is_none() { input.with_units("rig") } else { input };
    let plan_of = plan;
    Target::new(name, vec![own], move |bytes| {
        let mut rows = RowReader::new(format, input.clone());
        let mut monitor = Monitor::new(plan_of());
        let mut said = String::new();
        for line in bytes.split_inclusive(|byte| *byte == b'\n') {
            match rows.read_of(unit, line) {
                Ok(true) => monitor.take(rows.row()).unwrap(),
                Ok(false) => {}
                Err(error) => return error.to_string(),
            }
        }
        for what in rows.take_events() {
            said.push_str(&serde_json::to_value(&what).unwrap()["kind"].to_string());
        }
        for message in monitor.take_messages() {
            // Whatever was in the input, it is said as JSON of one line that is read again.
            let text = message.to_json();
            assert!(!text.contains('\n'), "{text}");
            let again: Message = serde_json::from_str(&text).unwrap();
            assert_eq!(again.to_json(), text);
            said.push_str(
                &serde_json::from_str::<serde_json::Value>(&text).unwrap()["kind"].to_string(),
            );
        }
        said.truncate(150);
        said
    })
}

pub fn streams_of_ndjson() -> Target {
    let line = |t, u, y| format!("{{\"rig\":\"a\",\"time\":{t},\"u\":{u},\"T\":{y}}}\n");
    stream("watch-ndjson", Format::Ndjson, None, lines(60, line))
}

pub fn streams_of_csv() -> Target {
    let line = |t, u, y| format!("a,{t},{u},{y}\n");
    let own = [b"rig,time,u,T [K]\n".to_vec(), lines(60, line)].concat();
    stream("watch-csv", Format::Csv, None, own)
}

pub fn messages_of_brokers() -> Target {
    let line = |t, u, y| format!("{{\"time\":{t},\"u\":{u},\"T\":{y}}}\n");
    stream("mqtt", Format::Ndjson, Some("p/1"), lines(3, line))
}

/// FNV-1a of a line, as the files of a state have it.
fn sum(text: &[u8]) -> String {
    let step = |sum: u64, byte: &u8| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", text.iter().fold(0xcbf2_9ce4_8422_2325, step))
}

/// A state of one unit that has learned, in a folder.
fn state(folder: &std::path::Path) {
    let mut monitor = Monitor::new(plan());
    let (mut state, _) = StateFolder::open(folder, &mut monitor).unwrap();
    let mut x = 0.0;
    for k in 0..500 {
        let u = if k / 7 % 2 == 0 { 1.0 } else { -0.4 };
        x = 0.88 * x + 0.12 * u;
        let y = if k > 450 { x + 3.0 } else { x + 1e-3 * f64::from(k % 5) };
        let row = Row { unit: "a", time: f64::from(k), values: &[u, y] };
        monitor.take(row).unwrap();
        state.keep(row);
    }
    let mut messages = monitor.take_messages();
    assert!(messages.iter().any(|m| matches!(m, Message::Alarm(_))), "{messages:?}");
    state.promise(&mut messages).unwrap();
    state.secure(&monitor).unwrap();
    // Not saved: the samples stay where they are.
    let kept = folder.join("samples/0.ndjson");
    let samples = fs::read(&kept).unwrap();
    state.save(&mut monitor, 1).unwrap();
    fs::write(&kept, samples).unwrap();
}

/// Opens a state of which one file is changed, and goes on with it.
fn resumed(name: &'static str, file: &str, is_sealed: bool) -> Target {
    let folder = tempfile::tempdir().unwrap();
    state(folder.path());
    let path = folder.path().join(file);
    let own = fs::read(&path).unwrap();
    // Behind its sum, which is made right: what forgery and not damage does.
    let inner = if is_sealed { own[17..].to_vec() } else { own.clone() };
    let kept =
        ["samples/0.ndjson", "units/a.unit", "units/a.rows", "journal.ndjson", "outbox.json"]
            .map(|file| (folder.path().join(file), fs::read(folder.path().join(file)).ok()));
    Target::new(name, vec![inner], move |input| {
        for (path, bytes) in &kept {
            match bytes {
                Some(bytes) => fs::write(path, bytes).unwrap(),
                None => drop(fs::remove_file(path)),
            }
        }
        let json = input.strip_suffix(b"\n").unwrap_or(input);
        let sealed = [sum(json).as_bytes(), b"\n", json, b"\n"].concat();
        fs::write(&path, if is_sealed { &sealed } else { input }).unwrap();
        let mut monitor = Monitor::new(plan());
        let (mut state, unsure) = match StateFolder::open(folder.path(), &mut monitor) {
            Ok(opened) => opened,
            Err(error) => {
                return error.to_string().replace(&folder.path().display().to_string(), "");
            }
        };
        let replayed = state.replay(&mut monitor, Monitor::take);
        let replayed = replayed.map_or_else(|e| e.to_string(), |taken| format!("{taken:?}"));
        for k in 500..510 {
            monitor.take(Row { unit: "a", time: f64::from(k), values: &[0.1, 0.2] }).unwrap();
        }
        let heard =
            state.outbox().map(|mut outbox| outbox.next(state.promised(), 10).map(|m| m.len()));
        format!("{} {replayed} {heard:?} {}", unsure.len(), monitor.take_messages().len())
    })
}

pub fn memories_of_units() -> Target {
    resumed("unit", "units/a.unit", true)
}

pub fn learned_rows() -> Target {
    resumed("rows", "units/a.rows", true)
}

pub fn journals() -> Target {
    resumed("journal", "journal.ndjson", false)
}

pub fn kept_samples() -> Target {
    resumed("samples", "samples/0.ndjson", false)
}

pub fn damaged_memories_of_units() -> Target {
    resumed("damaged", "units/a.unit", false)
}

pub fn snapshots() -> Target {
    let mut monitor = Monitor::new(plan());
    let folder = tempfile::tempdir().unwrap();
    state(folder.path());
    let (_state, _) = StateFolder::open(folder.path(), &mut monitor).unwrap();
    let text = fs::read_to_string(folder.path().join("units/a.unit")).unwrap();
    let json: serde_json::Value = serde_json::from_str(text.split_once('\n').unwrap().1).unwrap();
    let own = json["content"]["phase"]["watching"]["pipeline"].to_string();
    assert!(own.contains("checksum"), "{json}");
    Target::new("snapshots", vec![own.into_bytes()], move |input| {
        match serde_json::from_slice::<Snapshot>(input) {
            Ok(snapshot) => {
                let again = serde_json::to_string(&snapshot).unwrap();
                assert_eq!(serde_json::from_str::<Snapshot>(&again).unwrap(), snapshot);
                "read again".to_owned()
            }
            Err(error) => error.to_string(),
        }
    })
}
