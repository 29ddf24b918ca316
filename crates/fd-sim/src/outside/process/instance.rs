//! One running process.

use std::time::{Duration, Instant};

use super::{
    super::{
        contract::Contract,
        error::OutsideError,
        source::{Instance, Lost, Start, by_steps},
    },
    Process,
    child::Child,
    frame::{self, HEAD, LANES, Op, REFUSED, begin, put},
    hello::hello,
};

/// How long a process may take to hear that it is over.
const GOODBYE: Duration = Duration::from_millis(100);

/// A process that has said hello.
#[derive(Debug)]
pub(super) struct ProcessInstance {
    child: Child,
    /// Whether whole runs can be asked for.
    rolls_out: bool,
    bytes: Vec<u8>,
}

impl ProcessInstance {
    /// Starts a process and says hello.
    pub(super) fn open(process: &Process) -> Result<(Self, Contract), OutsideError> {
        let mut child = Child::start(process)?;
        let contract = hello(&mut child, process)?;
        let rolls_out = contract.powers.rollout;
        Ok((Self { child, rolls_out, bytes: Vec::new() }, contract))
    }

    /// Sends a frame of these parts and takes an answer that fills those.
    fn ask(&mut self, op: Op, parts: &[&[f64]], answer: [&mut [f64]; 2]) -> Result<(), Lost> {
        let (what, deadline) = (op.name(), self.child.deadline());
        let count: usize = parts.iter().map(|part| part.len()).sum();
        let count = u32::try_from(count).map_err(|_| {
            let (expected, found) = ("at most 2^32 - 1 values", format!("a call with {count}"));
            Lost::Broken(Box::new(self.child.protocol(what, expected.to_owned(), found)))
        })?;
        begin(&mut self.bytes, op, count);
        for part in parts {
            put(&mut self.bytes, part);
        }
        self.child.send(&self.bytes, what, deadline).map_err(gone)?;

        let mut head = [0; HEAD];
        self.child.receive(&mut head, what, deadline).map_err(gone)?;
        let [y, x] = answer;
        let expected = y.len() + x.len();
        match frame::head(&head) {
            [REFUSED, _, 0] => return Err(Lost::Refused),
            [found, LANES, count] if found == op as u32 && count as usize == expected => {}
            [found, lanes, count] => {
                let wanted = format!("op {}, 1 lane and {expected} values", op as u32);
                let found = format!("op {found}, {lanes} lanes and {count} values");
                return Err(Lost::Broken(Box::new(self.child.protocol(what, wanted, found))));
            }
        }
        self.bytes.resize(8 * expected, 0);
        self.child.receive(&mut self.bytes, what, deadline).map_err(gone)?;
        let (front, back) = self.bytes.split_at(8 * y.len());
        frame::get(front, y);
        frame::get(back, x);
        Ok(())
    }
}

impl Instance for ProcessInstance {
    fn reset(&mut self, start: Start<'_>) -> Result<(), Lost> {
        let first = [start.first as f64];
        self.ask(Op::Reset, &[&first, start.theta, start.x0], [&mut [], &mut []])
    }

    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.ask(Op::Measure, &[u], [y, &mut []])
    }

    fn step(&mut self, row: &[f64], y: &mut [f64], x: &mut [f64]) -> Result<(), Lost> {
        self.ask(Op::Step, &[row], [y, x])
    }

    fn rollout(
        &mut self,
        start: Start<'_>,
        rows: &[f64],
        samples: usize,
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        if self.rolls_out {
            let head = [start.first as f64, samples as f64];
            return self.ask(Op::Rollout, &[&head, start.theta, start.x0, rows], [y, x]);
        }
        by_steps(self, start, rows, samples, y, x)
    }
}

impl Drop for ProcessInstance {
    fn drop(&mut self) {
        begin(&mut self.bytes, Op::Bye, 0);
        let deadline = self.child.deadline().min(Instant::now() + GOODBYE);
        // Who is no more does not hear it.
        if self.child.send(&self.bytes, Op::Bye.name(), deadline).is_ok() {
            self.child.farewell();
        }
    }
}

fn gone(error: OutsideError) -> Lost {
    Lost::Gone(Box::new(error))
}
