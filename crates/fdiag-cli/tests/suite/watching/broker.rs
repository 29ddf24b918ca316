//! A broker of the test's own, somebody who publishes and somebody who listens.

use std::{
    collections::BTreeMap,
    fs,
    net::TcpListener,
    path::Path,
    process::{Child, Command, Stdio},
    sync::{Arc, Mutex},
    time::{Duration, Instant},
};

use rumqttc::{Client, Event, MqttOptions, Packet, QoS};
use tempfile::TempDir;

/// Debian's mosquitto, which keeps its sessions over a restart.
pub struct Broker {
    folder: TempDir,
    pub port: u16,
    child: Option<Child>,
    has_users: bool,
}

/// Password of all users of a broker that has some.
pub const PASSWORD: &str = "word";

impl Broker {
    pub fn new() -> Self {
        Self::with(tempfile::tempdir().unwrap(), "allow_anonymous true", false)
    }

    /// One that lets these users do what a list of access says, and nobody else anything.
    pub fn guarded(access: &Path, users: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let passwords = folder.path().join("passwords");
        fs::write(&passwords, "").unwrap();
        for user in users {
            let mut command = Command::new("mosquitto_passwd");
            let status = command.arg("-b").arg(&passwords).args([user, PASSWORD]).status();
            assert!(status.expect("this test needs mosquitto").success());
        }
        let list = folder.path().join("access");
        fs::copy(access, &list).unwrap();
        let settings = format!(
            "allow_anonymous false\npassword_file {}\nacl_file {}",
            passwords.display(),
            list.display()
        );
        Self::with(folder, &settings, true)
    }

    fn with(folder: TempDir, access: &str, has_users: bool) -> Self {
        // A port that was free a moment ago.
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let place = folder.path().display();
        let settings = format!(
            "listener {port} 127.0.0.1\n{access}\npersistence true\nuser root\n\
             persistence_location {place}/\nmax_queued_messages 0\nlog_dest none\n"
        );
        fs::write(folder.path().join("mosquitto.conf"), settings).unwrap();
        let mut broker = Self { folder, port, child: None, has_users };
        broker.start();
        broker
    }

    pub fn start(&mut self) {
        // Where Debian puts it, which is not on everybody's path.
        let program = ["/usr/sbin/mosquitto", "mosquitto"];
        let program = program.iter().find(|p| Path::new(p).exists()).unwrap_or(&"mosquitto");
        let child = Command::new(program)
            .arg("-c")
            .arg(self.folder.path().join("mosquitto.conf"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        self.child = Some(child.expect("this test needs mosquitto"));
        let begun = Instant::now();
        while std::net::TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            assert!(begun.elapsed() < Duration::from_secs(10), "mosquitto does not answer");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Ends it as an administrator does, so that it writes down its sessions.
    pub fn stop(&mut self) {
        let Some(mut child) = self.child.take() else { return };
        Command::new("kill").arg(child.id().to_string()).status().unwrap();
        child.wait().unwrap();
    }

    fn options(&self, name: &str) -> MqttOptions {
        let mut options = MqttOptions::new(name, "127.0.0.1", self.port);
        options.set_max_packet_size(1 << 24, 1 << 24);
        if self.has_users {
            // What stands behind a hyphen tells clients of one user apart.
            options.set_credentials(name.split('-').next().unwrap(), PASSWORD);
        }
        options
    }

    /// A function that publishes messages and returns when all are the broker's, however often it goes away meanwhile.
    pub fn publisher(&self) -> impl FnMut(&[(String, String)]) + Send + use<> {
        self.publisher_named("publisher")
    }

    /// The same under the name of a user.
    pub fn publisher_named(&self, name: &str) -> impl FnMut(&[(String, String)]) + Send + use<> {
        let options = self.options(name);
        move |messages| {
            'anew: loop {
                let (client, mut connection) = Client::new(options.clone(), messages.len());
                for (topic, text) in messages {
                    client.try_publish(topic, QoS::AtLeastOnce, false, text.as_bytes()).unwrap();
                }
                let mut confirmed = 0;
                for event in connection.iter() {
                    match event {
                        Ok(Event::Incoming(Packet::PubAck(_))) => confirmed += 1,
                        Ok(_) => {}
                        Err(_) => {
                            std::thread::sleep(Duration::from_millis(50));
                            continue 'anew;
                        }
                    }
                    if confirmed == messages.len() {
                        return;
                    }
                }
            }
        }
    }

    /// Publishes something that the broker may refuse, under the name of a user.
    pub fn try_publish(&self, user: &str, topic: &str, text: &str) {
        self.publish_once(user, topic, text, false);
    }

    /// Publishes a text that the broker keeps for whoever comes later.
    pub fn retain(&self, topic: &str, text: &str) {
        self.publish_once("retainer", topic, text, true);
    }

    /// Publishes a message, and waits until the broker has it or refuses it.
    fn publish_once(&self, name: &str, topic: &str, text: &str, is_kept: bool) {
        let (client, mut connection) = Client::new(self.options(name), 2);
        client.try_publish(topic, QoS::AtLeastOnce, is_kept, text.as_bytes()).unwrap();
        for event in connection.iter() {
            if let Ok(Event::Incoming(Packet::PubAck(_))) | Err(_) = event {
                return;
            }
        }
    }

    /// Starts to listen to a topic; what is heard, by topic and in order. `name` is a session that lasts.
    pub fn listen(&self, name: &str, topic: &str) -> Heard {
        let mut options = self.options(name);
        options.set_clean_session(false);
        let (client, mut connection) = Client::new(options, 10);
        let (heard, topic) = (Heard::default(), topic.to_owned());
        let ears = heard.clone();
        std::thread::spawn(move || {
            for event in connection.iter() {
                match event {
                    Ok(Event::Incoming(Packet::ConnAck(_))) => {
                        client.try_subscribe(&topic, QoS::AtLeastOnce).unwrap();
                    }
                    Ok(Event::Incoming(Packet::Publish(message))) => {
                        let text = String::from_utf8(message.payload.to_vec()).unwrap();
                        ears.0.lock().unwrap().entry(message.topic).or_default().push(text);
                    }
                    Ok(_) => {}
                    Err(_) => std::thread::sleep(Duration::from_millis(50)),
                }
            }
        });
        heard
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        self.stop();
    }
}

/// What somebody has heard.
#[derive(Clone, Default)]
pub struct Heard(Arc<Mutex<BTreeMap<String, Vec<String>>>>);

impl Heard {
    pub fn by_topic(&self) -> BTreeMap<String, Vec<String>> {
        self.0.lock().unwrap().clone()
    }

    /// Everything at topics with this end, as lines.
    pub fn lines(&self, end: &str) -> String {
        let heard = self.by_topic().into_iter().filter(|(topic, _)| topic.ends_with(end));
        heard.flat_map(|(_, texts)| texts).map(|text| text + "\n").collect()
    }
}

/// Waits until something is so; false when it is not after so long.
pub fn wait(longest: Duration, mut is_so: impl FnMut() -> bool) -> bool {
    let begun = Instant::now();
    while !is_so() {
        if longest < begun.elapsed() {
            return false;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    true
}
