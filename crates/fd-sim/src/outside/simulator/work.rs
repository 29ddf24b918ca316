//! What one copy of a simulator has an instance do.

use super::{
    super::{
        loan::Work,
        source::{Instance, Lost, Start},
        tally::Tally,
    },
    OutsideSimulator,
};

impl OutsideSimulator {
    /// Lets a simulator that is where this copy is do something.
    pub(super) fn work(
        &mut self,
        mut act: impl FnMut(&mut dyn Instance, &mut [f64]) -> Result<usize, Lost>,
    ) -> Work {
        let Self { shared, loan, theta, x0, first, tape, samples, x, was_made, .. } = self;
        let (theta, x0, first, samples) = (&*theta, &*x0, *first, *samples);
        let (ny, width) = (shared.contract.outputs.len(), tape.len() / samples.max(1));
        loan.work(shared, self.origin, |instance, reached| {
            let start = Start { theta, x0, first };
            let mut from = reached.take().unwrap_or(usize::MAX);
            if samples < from {
                let counter = if *was_made { &shared.tally.repeated } else { &shared.tally.made };
                Tally::add(counter, 1);
                *was_made = true;
                from = 0;
                if shared.contract.powers.rollout && 0 < samples {
                    let mut y = vec![0.0; samples * ny];
                    instance.rollout(start, tape, samples, &mut y, x)?;
                    from = samples;
                } else {
                    instance.reset(start)?;
                }
                Tally::add(&shared.tally.steps, from as u64);
            }
            let mut y = vec![0.0; if from < samples { ny } else { 0 }];
            for k in from..samples {
                instance.step(&tape[k * width..(k + 1) * width], &mut y, x)?;
            }
            let more = act(instance, x)?;
            Tally::add(&shared.tally.steps, (samples - from + more) as u64);
            *reached = Some(samples + more);
            Ok(())
        })
    }

    /// Inputs and forces of a sample as one row.
    pub(super) fn note_row(&mut self, u: &[f64], f: &[f64]) {
        self.row.clear();
        self.row.extend_from_slice(u);
        self.row.extend_from_slice(f);
        // No forces are none at any port.
        self.row.resize(u.len() + self.shared.contract.ports.len(), 0.0);
    }

    /// The outputs of this sample, moving on, by whatever the simulator can do.
    pub(super) fn advance(&mut self, y: &mut [f64]) -> Work {
        let row = std::mem::take(&mut self.row);
        let work = if self.shared.contract.powers.step {
            self.work(|instance, x| instance.step(&row, y, x).map(|()| 1))
        } else {
            self.step_whole(&row, y);
            Work::Done
        };
        self.row = row;
        work
    }
}
