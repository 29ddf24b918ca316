//! Learning the bias from healthy residuals, in one go or sample by sample.

use fd_compensate::residual_compensation::ResidualCompensator;
use fd_core::{Event, EventKind, Frame, IoDims, stage::Compensator};
use fd_ident::{
    arx::ArxOrders,
    least_squares::LeastSquares,
    order::{OrderTable, paper_orders, select_orders},
    subspace::Subspace,
};
use fd_model::Record;

use super::{
    bias::LearnedBias,
    choose::{Candidate, Choice, Compared, choose},
    error::TrainingError,
    fit::{Search, fit},
    structure::{Sizes, Structure},
};
use crate::spec::{ApplySpec, OrderSpec, PipelineSpec, StructureSpec};

/// One part in this many of the training data is held out when orders are compared.
const HELD_OUT_PART: usize = 4;

/// A bias model and how it came about.
pub(super) struct Learned {
    pub bias: LearnedBias,
    pub selection: Option<OrderTable>,
    /// The forms that were compared, when the form was to be chosen.
    pub compared: Vec<Compared>,
    pub events: Vec<Event>,
}

/// Learns from residual records, one per log.
pub(super) fn learn(spec: &PipelineSpec, records: &[Record]) -> Result<Learned, TrainingError> {
    let learned = match &spec.bias.orders {
        _ if spec.bias.apply == ApplySpec::Never => Learned::nothing(records, Vec::new())?,
        OrderSpec::Choose { most }
            if !matches!(spec.bias.structure, StructureSpec::StateSpace { .. }) =>
        {
            learn_chosen(spec, *most, records)?
        }
        _ => match Structure::of(&spec.bias.structure, records)? {
            Some(structure) => learn_equations(spec, &structure, records)?,
            None => learn_states(spec, records)?,
        },
    };
    let radius = learned.bias.pole_radii()?.into_iter().flatten().fold(0.0, f64::max);
    if radius >= 1.0 {
        return Err(TrainingError::UnstableBias { radius });
    }
    Ok(learned)
}

/// Compares the forms that the spec leaves open, then learns the one that was chosen from all records.
fn learn_chosen(
    spec: &PipelineSpec,
    most: usize,
    records: &[Record],
) -> Result<Learned, TrainingError> {
    let Choice { candidate, table } = choose(spec, most, records)?;
    let Some(Candidate { structure, orders, learning }) = candidate else {
        return Learned::nothing(records, table);
    };
    let mut chosen = spec.clone();
    (chosen.bias.structure, chosen.bias.orders) = (structure, OrderSpec::Fixed(orders));
    if !spec.bias.learning.is_on_line() {
        chosen.bias.learning = learning;
    }
    Ok(Learned { compared: table, ..learn(&chosen, records)? })
}

impl Learned {
    /// No bias: a constant that is zero.
    fn nothing(records: &[Record], compared: Vec<Compared>) -> Result<Self, TrainingError> {
        let first = records.first().ok_or(TrainingError::NoHealthyLog)?;
        let (nu, channels) = (first.inputs().len(), first.outputs().len());
        let bias = LearnedBias::constant(vec![0.0; channels], nu, first.ts())?;
        Ok(Self { bias, selection: None, compared, events: Vec::new() })
    }
}

fn learn_equations(
    spec: &PipelineSpec,
    structure: &Structure,
    records: &[Record],
) -> Result<Learned, TrainingError> {
    let (orders, selection) = match &spec.bias.orders {
        OrderSpec::Fixed(orders) => (*orders, None),
        OrderSpec::Choose { most } => (ArxOrders::paper(*most).with_offset(), None),
        OrderSpec::Select { most, criterion, offset } => {
            let table = score_orders(&structure.seen(records)?, *most, *offset)?;
            let best =
                table.choice(*criterion).ok_or(TrainingError::NoOrder { most: *most })?.orders;
            (best, Some(table))
        }
    };
    if spec.bias.learning.is_on_line() {
        let [record] = records else {
            return Err(TrainingError::RecursiveNeedsOneLog { found: records.len() });
        };
        let (bias, events) = learn_on_line(spec, structure, orders, record)?;
        return Ok(Learned { bias, selection, compared: Vec::new(), events });
    }
    let bias = fit(structure, &spec.bias.learning, orders, records, Search::AsFarAsItCame)?;
    Ok(Learned { bias, selection, compared: Vec::new(), events: Vec::new() })
}

/// Subspace identification; of the orders only the constant counts.
fn learn_states(spec: &PipelineSpec, records: &[Record]) -> Result<Learned, TrainingError> {
    let StructureSpec::StateSpace { states, horizon } = spec.bias.structure else {
        return Err(TrainingError::NoOrder { most: 0 });
    };
    let mut subspace = Subspace::new(states);
    if let Some(horizon) = horizon {
        subspace = subspace.with_horizon(horizon);
    }
    let offset = match spec.bias.orders {
        OrderSpec::Fixed(ArxOrders { offset, .. }) | OrderSpec::Select { offset, .. } => offset,
        OrderSpec::Choose { .. } => true,
    };
    if offset {
        subspace = subspace.with_offset();
    }
    let bias = LearnedBias::StateSpace(Box::new(subspace.fit(records)?.model));
    Ok(Learned { bias, selection: None, compared: Vec::new(), events: Vec::new() })
}

/// Judges the paper's structures; the last part of each log is held out from the comparison.
fn score_orders(
    records: &[Record],
    most: usize,
    offset: bool,
) -> Result<OrderTable, TrainingError> {
    let candidates: Vec<ArxOrders> = paper_orders(most)
        .into_iter()
        .map(|orders| if offset { orders.with_offset() } else { orders })
        .collect();
    let cut = |record: &Record| record.len() - record.len() / HELD_OUT_PART;
    let training: Vec<Record> = records.iter().map(|r| r.slice(0, cut(r))).collect();
    let held_out: Vec<Record> = records.iter().map(|r| r.slice(cut(r), r.len())).collect();
    let (training, held_out): (Vec<&Record>, Vec<&Record>) =
        (training.iter().collect(), held_out.iter().collect());
    Ok(select_orders(&candidates, &LeastSquares::new(), &training, &held_out)?)
}

/// Lets the compensator train itself, as it would next to the plant, until it opens its switch.
fn learn_on_line(
    spec: &PipelineSpec,
    structure: &Structure,
    orders: ArxOrders,
    record: &Record,
) -> Result<(LearnedBias, Vec<Event>), TrainingError> {
    let (nu, channels) = (record.inputs().len(), record.outputs().len());
    let sizes = Sizes { orders, nu, channels };
    let identifier = structure.identifier(&spec.bias.learning, sizes)?;
    let silent = vec![0.0; identifier.theta().len()];
    let empty = structure.with_parameters(sizes, &silent, record.ts())?.freeze()?;
    let mut compensator = ResidualCompensator::new(identifier, empty, &spec.compensation)?;
    let mut r_star = vec![0.0; channels];
    let mut events = Vec::new();
    for k in (0..record.len()).filter(|&k| record.is_complete(k)) {
        let r = record.y(k);
        let frame = Frame::new(IoDims { nu, ny: channels }, k as u64, record.u(k), r)?;
        let step = compensator.step(frame, r, &mut r_star);
        events.extend(step.events.iter().map(|kind| Event { k: frame.k(), kind }));
        if step.events.iter().any(|kind| kind == EventKind::Frozen) {
            let theta = compensator.theta().unwrap_or_default();
            return Ok((structure.with_parameters(sizes, theta, record.ts())?, events));
        }
    }
    Err(TrainingError::NotConverged { samples: record.len() })
}
