//! The forms that are compared.

use fd_ident::{arx::ArxOrders, hammerstein::Basis};
use fd_model::Record;

use crate::{
    spec::{LearningSpec, StructureSpec},
    training::{
        error::TrainingError,
        fit::{Search, fit},
        structure::Structure,
    },
};

/// Delays in samples that are tried with each order; powers of two, since an order more takes in the next delay.
pub(super) const DELAYS: [usize; 4] = [0, 1, 2, 4];

/// One form of the bias model.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::training) struct Candidate {
    pub structure: StructureSpec,
    pub orders: ArxOrders,
    pub learning: LearningSpec,
}

/// A constant; then the paper's orders up to `most`, order 0 being a gain, with and without a constant, delayed.
pub(super) fn orders(most: usize) -> Vec<ArxOrders> {
    let mut all = vec![ArxOrders::new(0, 0, 0).with_offset()];
    for n in 0..=most {
        for delay in DELAYS {
            let orders = ArxOrders::new(n, n + 1, delay);
            all.extend([orders, orders.with_offset()]);
        }
    }
    all
}

/// Richer structures than the linear one, with the orders and the time constant of what was found there.
pub(super) fn structures(
    found: &Candidate,
    nu: usize,
    records: &[Record],
) -> Result<Vec<StructureSpec>, TrainingError> {
    let basis = |degree| Basis::Polynomial { degree };
    let mut all: Vec<StructureSpec> =
        [2, 3].map(|degree| StructureSpec::Hammerstein { basis: basis(degree) }).into();
    let model =
        fit(&Structure::Linear, &found.learning, found.orders, records, Search::AsFarAsItCame)?;
    let slowest = model.pole_radii()?.into_iter().flatten().fold(0.0, f64::max);
    let samples = if slowest > 0.0 && slowest < 1.0 { -slowest.ln().recip() } else { 1.0 };
    let longest = records.iter().map(Record::len).max().unwrap_or(1);
    // Beyond a part of the log the level of an input is that of the whole log.
    let time_constant_s = samples.min(longest as f64 / 20.0) * records[0].ts().seconds();
    all.extend((0..nu).map(|input| StructureSpec::Scheduled {
        input,
        time_constant_s,
        regions: 2,
        centres: None,
    }));
    Ok(all)
}

impl Candidate {
    /// Parameters of one residual channel.
    pub(super) fn parameters(&self, nu: usize) -> usize {
        let functions = |basis: &Basis| match basis {
            Basis::Polynomial { degree } => *degree,
            Basis::PiecewiseLinear { segments } => *segments,
        };
        match &self.structure {
            StructureSpec::Hammerstein { basis } => self.orders.parameters(nu * functions(basis)),
            StructureSpec::Scheduled { regions, centres, .. } => {
                let regions = centres.as_ref().map_or(*regions, Vec::len);
                regions * self.orders.parameters(nu)
            }
            StructureSpec::Linear | StructureSpec::StateSpace { .. } => self.orders.parameters(nu),
        }
    }

    pub(super) fn in_words(&self) -> String {
        let ArxOrders { na, nb, delay, offset } = self.orders;
        let structure = match &self.structure {
            _ if nb == 0 => return "a constant".to_owned(),
            StructureSpec::Linear => "linear".to_owned(),
            StructureSpec::Hammerstein { basis: Basis::Polynomial { degree } } => {
                format!("Hammerstein of degree {degree}")
            }
            StructureSpec::Hammerstein { basis: Basis::PiecewiseLinear { segments } } => {
                format!("Hammerstein of {segments} pieces")
            }
            StructureSpec::Scheduled { input, .. } => format!("scheduled by input {}", input + 1),
            StructureSpec::StateSpace { states, .. } => format!("{states} states"),
        };
        let delay = if delay > 0 { format!(", delay {delay}") } else { String::new() };
        let constant = if offset { ", constant" } else { "" };
        let learning = match &self.learning {
            LearningSpec::Batch { .. } => "",
            LearningSpec::OutputError { .. } => ", output error",
            _ => ", learned as the spec says",
        };
        format!("{structure}, order {na}{delay}{constant}{learning}")
    }
}
