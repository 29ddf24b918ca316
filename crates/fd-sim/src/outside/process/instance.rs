//! One running process.

use std::time::{Duration, Instant};

use super::{
    super::{
        contract::Contract,
        error::OutsideError,
        source::{Instance, Lane, Lost, Source, Start, by_lanes, by_steps},
    },
    child::Child,
    frame::{self, HEAD, Op, REFUSED, begin, put},
    hello::hello,
    program::Process,
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

    /// Sends a frame of one lane with these parts and takes an answer that fills those.
    fn ask(&mut self, op: Op, parts: &[&[f64]], answer: [&mut [f64]; 2]) -> Result<(), Lost> {
        self.ask_lanes(op, 1, parts, answer)
    }

    /// The same of several lanes, one after the other in parts and answers: outputs and then states of each.
    fn ask_lanes(
        &mut self,
        op: Op,
        lanes: usize,
        parts: &[&[f64]],
        answer: [&mut [f64]; 2],
    ) -> Result<(), Lost> {
        let (what, deadline) = (op.name(), self.child.deadline());
        let count: usize = parts.iter().map(|part| part.len()).sum();
        let too_much = |_| {
            let (expected, found) = ("at most 2^32 - 1 values", format!("a call with {count}"));
            Lost::Broken(Box::new(self.child.protocol(what, expected.to_owned(), found)))
        };
        let lanes = u32::try_from(lanes).map_err(too_much)?;
        let count = u32::try_from(count).map_err(too_much)?;
        begin(&mut self.bytes, op, [lanes, count]);
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
            [found, of, count]
                if found == op as u32 && of == lanes && count as usize == expected => {}
            [found, of, count] => {
                let s = if lanes == 1 { "" } else { "s" };
                let wanted = format!("op {}, {lanes} lane{s} and {expected} values", op as u32);
                let found = format!("op {found}, {of} lanes and {count} values");
                return Err(Lost::Broken(Box::new(self.child.protocol(what, wanted, found))));
            }
        }
        self.bytes.resize(8 * expected, 0);
        self.child.receive(&mut self.bytes, what, deadline).map_err(gone)?;
        // Outputs and states of one lane after those of the other.
        let (ny, nx) = (y.len() / lanes as usize, x.len() / lanes as usize);
        let mut rest = &self.bytes[..];
        for lane in 0..lanes as usize {
            for values in [&mut y[lane * ny..(lane + 1) * ny], &mut x[lane * nx..(lane + 1) * nx]] {
                let (front, back) = rest.split_at(8 * values.len());
                frame::get(front, values);
                rest = back;
            }
        }
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

    fn reset_lanes(&mut self, starts: &[Start<'_>]) -> Result<(), Lost> {
        let firsts: Vec<[f64; 1]> = starts.iter().map(|start| [start.first as f64]).collect();
        let each = starts.iter().zip(&firsts);
        let parts: Vec<&[f64]> = each.flat_map(|(s, first)| [&first[..], s.theta, s.x0]).collect();
        self.ask_lanes(Op::Reset, starts.len(), &parts, [&mut [], &mut []])
    }

    fn measure_lanes(&mut self, lanes: usize, u: &[f64], y: &mut [f64]) -> Result<(), Lost> {
        self.ask_lanes(Op::Measure, lanes, &[u], [y, &mut []])
    }

    fn step_lanes(
        &mut self,
        lanes: usize,
        rows: &[f64],
        y: &mut [f64],
        x: &mut [f64],
    ) -> Result<(), Lost> {
        self.ask_lanes(Op::Step, lanes, &[rows], [y, x])
    }

    fn rollouts(&mut self, samples: usize, lanes: &mut [Lane<'_>]) -> Result<(), Lost> {
        if !self.rolls_out {
            return by_lanes(self, samples, lanes);
        }
        let heads: Vec<[f64; 2]> =
            lanes.iter().map(|lane| [lane.start.first as f64, samples as f64]).collect();
        let each = lanes.iter().zip(&heads);
        let parts: Vec<&[f64]> =
            each.flat_map(|(l, head)| [&head[..], l.start.theta, l.start.x0, l.rows]).collect();
        let mut y = vec![0.0; lanes.iter().map(|lane| lane.y.len()).sum()];
        self.ask_lanes(Op::Rollout, lanes.len(), &parts, [&mut y, &mut []])?;
        let mut rest = &y[..];
        for lane in lanes {
            let (front, back) = rest.split_at(lane.y.len());
            lane.y.copy_from_slice(front);
            rest = back;
        }
        Ok(())
    }
}

impl Drop for ProcessInstance {
    fn drop(&mut self) {
        begin(&mut self.bytes, Op::Bye, [1, 0]);
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

impl Process {
    /// Starts it once and asks what it is.
    ///
    /// # Errors
    ///
    /// Returns why it cannot be started, or what is wrong with its hello.
    pub fn contract(&self) -> Result<Contract, OutsideError> {
        Ok(ProcessInstance::open(self)?.1)
    }
}

impl Source for Process {
    fn open(&self) -> Result<Box<dyn Instance>, OutsideError> {
        Ok(Box::new(ProcessInstance::open(self)?.0))
    }

    fn note(&self) -> Option<String> {
        self.note.get()
    }
}
