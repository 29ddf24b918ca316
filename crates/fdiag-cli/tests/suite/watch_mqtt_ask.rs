//! A broker between a monitor that asks and whoever answers: nothing is lost while either is away.
#![cfg(feature = "mqtt")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use std::{
    io::{Read, Write},
    path::Path,
    process::{Child, Command},
    sync::{Arc, Mutex},
    time::Duration,
};

use crate::watching::broker::{Broker, PASSWORD, wait};
use crate::watching::{Plant, text};

const LONG: Duration = Duration::from_secs(60);

/// A monitor, and what it says.
struct Running {
    child: Child,
    said: Arc<Mutex<Vec<u8>>>,
}

impl Running {
    fn start(plant: &Plant, line: &str) -> Self {
        let mut child = plant.spawn(line);
        let said = Arc::new(Mutex::new(Vec::new()));
        let (mut out, ears) = (child.stdout.take().unwrap(), Arc::clone(&said));
        std::thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(read @ 1..) = out.read(&mut buffer) {
                ears.lock().unwrap().extend_from_slice(&buffer[..read]);
            }
        });
        Self { child, said }
    }

    fn says(&self, word: &str) -> bool {
        wait(LONG, || text(&self.said.lock().unwrap()).contains(word))
    }

    fn said(&self) -> String {
        text(&self.said.lock().unwrap())
    }

    /// Samples of a unit whose input leaves the trained range at the 200th.
    fn feed(&mut self, from: u32, to: u32) {
        let stdin = self.child.stdin.as_mut().unwrap();
        for k in from..to {
            let (time, u) = (0.1 * f64::from(k), if k < 200 { 0.0 } else { 10.0 });
            let values = format!("\"time\":{time},\"fuel\":{u},\"speed\":0,\"temperature\":0");
            writeln!(stdin, "{{\"rig\":\"a/b\",{values}}}").unwrap();
        }
        stdin.flush().unwrap();
    }

    fn end(mut self) {
        Command::new("kill").arg(self.child.id().to_string()).status().unwrap();
        assert!(self.child.wait().unwrap().success());
    }
}

#[test]
#[ignore = "needs mosquitto"]
fn through_mosquitto_whoever_is_asked_can_answer() {
    let plant = Plant::new();
    let more =
        "compensation.operating_point = { policy = { kind = \"retrain\" }, time_constant = 20 }\n";
    std::fs::write(plant.path("spec.toml"), more.to_owned() + crate::watching::SPEC).unwrap();
    let broker = Broker::new();
    let line = format!(
        "watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig --state state --ask \
         --mqtt 127.0.0.1:{} --mqtt-out fdiag",
        broker.port
    );
    let topic = "fdiag/a%2Fb/wish".to_owned();
    let heard = broker.listen("listener", "fdiag/+/wish");

    // A question that an earlier monitor has left behind, of a unit that asks nothing now.
    let mut publish = broker.publisher();
    broker.retain("fdiag/gone/wish", "{\"id\":\"gone/retraining/1\"}");
    let mut first = Running::start(&plant, &line);
    first.feed(0, 400);
    assert!(first.says("retraining-wanted"));
    let id =
        first.said().split("\"kind\":\"retraining-wanted\",\"id\":\"").nth(1).unwrap().to_owned();
    let id = id.split('"').next().unwrap().to_owned();
    let asked = format!("{{\"answers\":[\"confirm\",\"refuse\"],\"id\":\"{id}\"}}");
    assert!(wait(LONG, || heard.by_topic().get(&topic).is_some_and(|all| all.contains(&asked))));
    let is_gone = || {
        heard.by_topic().get("fdiag/gone/wish").is_some_and(|all| all.last().unwrap().is_empty())
    };
    assert!(wait(LONG, is_gone), "{:?}", heard.by_topic());
    first.end();

    // What is said while the monitor is away waits at the broker: rubbish, an answer to nothing, the answer of another
    // unit, the answer itself.
    let said = |id: &str| format!("{{\"id\":\"{id}\",\"answer\":\"confirm\"}}");
    let messages = [
        ("fdiag/a%2Fb/answer", "yes".to_owned()),
        ("fdiag/a%2Fb/answer", said("a/b/retraining/0")),
        ("fdiag/other/answer", said(&id)),
        ("fdiag/a%2Fb/answer", said(&id)),
    ];
    publish(&messages.map(|(topic, text)| (topic.to_owned(), text)));
    let mut second = Running::start(&plant, &line);
    assert!(
        second
            .says(&format!("\"kind\":\"retraining-answered\",\"id\":\"{id}\",\"confirmed\":true"))
    );
    assert_eq!(
        second.said().matches("\"kind\":\"answer-refused\"").count(),
        3,
        "{}",
        second.said()
    );
    // It is on the disk before the broker may forget it, and nobody is asked any more.
    assert!(wait(LONG, || heard.by_topic()[&topic].last().unwrap().is_empty()));
    // The receipt follows at once.
    std::thread::sleep(Duration::from_millis(500));
    second.child.kill().unwrap();
    second.child.wait().unwrap();
    let kept = std::fs::read_dir(plant.path("state/units")).unwrap().next().unwrap().unwrap();
    assert!(std::fs::read_to_string(kept.path()).unwrap().contains("\"wish\":null"));

    let mut third = Running::start(&plant, &line);
    third.feed(400, 420);
    assert!(third.says("training-started"), "{}", third.said());
    assert!(!third.said().contains("answer-refused"), "it was acknowledged: {}", third.said());
    third.end();
    let late = broker.listen("late", "fdiag/+/wish");
    std::thread::sleep(Duration::from_millis(500));
    assert!(late.by_topic().is_empty(), "{:?}", late.by_topic());
}

/// What `examples/watch/mosquitto.acl` forbids does not come, and what comes without the token is refused.
#[test]
#[ignore = "needs mosquitto"]
fn through_mosquitto_only_whoever_may_and_has_the_token_answers() {
    let plant = Plant::new();
    let more =
        "compensation.operating_point = { policy = { kind = \"retrain\" }, time_constant = 20 }\n";
    std::fs::write(plant.path("spec.toml"), more.to_owned() + crate::watching::SPEC).unwrap();
    std::fs::write(plant.path("token"), "0123456789abcdef\n").unwrap();
    std::fs::write(plant.path("login"), format!("monitor\n{PASSWORD}\n")).unwrap();
    let access = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/watch/mosquitto.acl");
    let broker = Broker::guarded(&access, &["monitor", "plant", "operator", "screen"]);
    let line = format!(
        "watch --model model.toml --spec spec.toml --healthy healthy.csv --unit rig --state state --ask \
         --answer-token token --mqtt 127.0.0.1:{} --mqtt-login login --mqtt-in plant/+ --mqtt-out fdiag",
        broker.port
    );
    let heard = broker.listen("operator-ears", "fdiag/+/wish");
    let alarms = broker.listen("screen", "fdiag/+/state");
    let running = Running::start(&plant, &line);
    assert!(running.says("\"kind\":\"connected\""), "{}", running.said());
    let mut samples = broker.publisher_named("plant");
    let row = |k: u32| {
        let (time, u) = (0.1 * f64::from(k), if k < 200 { 0.0 } else { 10.0 });
        let values = format!("\"time\":{time},\"fuel\":{u},\"speed\":0,\"temperature\":0");
        format!("{{\"rig\":\"a\",{values}}}\n")
    };
    let rows: String = (0..400).map(row).collect();
    samples(&[("plant/a".to_owned(), rows)]);
    assert!(running.says("retraining-wanted"), "{}", running.said());
    assert!(wait(LONG, || heard.by_topic().contains_key("fdiag/a/wish")));
    let text_of = heard.by_topic()["fdiag/a/wish"].last().unwrap().clone();
    let id = text_of.split("\"id\":\"").nth(1).unwrap().split('"').next().unwrap().to_owned();

    let said = |more: &str| format!("{{\"id\":\"{id}\",\"answer\":\"confirm\"{more}}}");
    let whole = said(",\"token\":\"0123456789abcdef\"");
    let answer = |text: String| ("fdiag/a/answer".to_owned(), text);
    // Whoever sends samples or looks: the broker lets nobody hear it.
    for user in ["plant", "screen"] {
        broker.try_publish(user, "fdiag/a/answer", &whole);
        broker.try_publish(user, "fdiag/a/state", "{\"state\":\"normal\"}");
    }
    let mut people = broker.publisher_named("operator");
    people(&[answer(said("")), answer(said(",\"token\":\"0123456789abcdeF\""))]);
    let refused = || running.said().matches("expected the `token`").count() == 2;
    assert!(wait(LONG, refused), "{}", running.said());
    assert!(!running.said().contains("retraining-answered"), "{}", running.said());
    people(&[answer(whole)]);
    assert!(running.says("\"kind\":\"retraining-answered\""));
    assert_eq!(running.said().matches("answer-refused").count(), 2, "{}", running.said());
    assert!(!alarms.lines("state").contains("\"normal\""), "{:?}", alarms.by_topic());
    running.end();
}

/// A question needs somebody who could hear it.
#[test]
fn a_monitor_that_could_ask_nobody_is_refused() {
    let plant = Plant::new();
    let output = plant.run("watch --model model.toml --healthy healthy.csv --ask", "");
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("--mqtt-out"), "{output:?}");
}
