//! What monitors say, while they say it, and what of it was promised.

use std::{
    collections::BTreeMap,
    io::Read,
    process::Child,
    sync::{Arc, Mutex},
};

use super::{promised, text};

/// The standard output of a monitor so far.
pub struct Ears(Arc<Mutex<Vec<u8>>>);

impl Ears {
    /// Starts to listen.
    pub fn on(child: &mut Child) -> Self {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let (mut out, said) = (child.stdout.take().unwrap(), Arc::clone(&heard));
        std::thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(read @ 1..) = out.read(&mut buffer) {
                said.lock().unwrap().extend_from_slice(&buffer[..read]);
            }
        });
        Self(heard)
    }

    pub fn said(&self) -> String {
        text(&self.0.lock().unwrap())
    }
}

/// What was promised in texts, one message one text.
pub fn union(texts: &[String]) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    for text in texts {
        promised(text, &mut all)
            .unwrap_or_else(|two| panic!("one message says two things:\n{two}"));
    }
    all
}

/// One message per sample, to a topic of its unit.
pub fn messages(stream: &str) -> Vec<(String, String)> {
    let unit = |line: &str| line.split('"').nth(3).unwrap().to_owned();
    stream.lines().map(|line| (format!("plant/{}", unit(line)), line.to_owned())).collect()
}
