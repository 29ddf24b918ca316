//! Learning the bias from healthy residuals, in one go or sample by sample.

use fd_compensate::residual_compensation::ResidualCompensator;
use fd_core::{Event, EventKind, Frame, IoDims, stage::Compensator};
use fd_ident::{
    arx::{ArxFit, ArxModel, ArxOrders, ArxSimulator},
    least_squares::LeastSquares,
    order::{OrderTable, paper_orders, select_orders},
    refine::Prefilter,
};
use fd_model::Record;

use super::{error::RoadError, train::recursive};
use crate::spec::{LearningSpec, OrderSpec, PipelineSpec};

/// One part in so many of the training data is held out when orders are compared.
const HELD_OUT_PART: usize = 4;

/// A bias model and how it came about.
pub(super) struct Learned {
    pub(super) model: ArxModel,
    pub(super) selection: Option<OrderTable>,
    pub(super) events: Vec<Event>,
}

/// Learns from residual records, one per log.
pub(super) fn learn(spec: &PipelineSpec, records: &[Record]) -> Result<Learned, RoadError> {
    let (orders, selection) = match &spec.bias.orders {
        OrderSpec::Fixed(orders) => (*orders, None),
        OrderSpec::Select { most, criterion, offset } => {
            let table = score_orders(records, *most, *offset)?;
            let best = table.choice(*criterion).ok_or(RoadError::NoOrder { most: *most })?.orders;
            (best, Some(table))
        }
    };
    let (model, events) = match &spec.bias.learning {
        LearningSpec::Batch { prefilter_rad_s } => {
            (batch(orders, *prefilter_rad_s, records)?, Vec::new())
        }
        LearningSpec::Recursive(_) => match records {
            [record] => learn_on_line(spec, orders, record)?,
            _ => return Err(RoadError::RecursiveNeedsOneLog { found: records.len() }),
        },
    };
    for channel in 0..model.residual_len() {
        let poles = model.poles(channel)?;
        let radius = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
        if radius >= 1.0 {
            return Err(RoadError::UnstableBias { radius });
        }
    }
    Ok(Learned { model, selection, events })
}

fn batch(
    orders: ArxOrders,
    prefilter_rad_s: Option<f64>,
    records: &[Record],
) -> Result<ArxModel, RoadError> {
    let mut fit = ArxFit::new(orders);
    if let (Some(omega), Some(first)) = (prefilter_rad_s, records.first()) {
        fit = fit.with_prefilter(Prefilter::low_pass(2, omega, first.ts())?);
    }
    Ok(fit.fit(records)?.model)
}

/// Judges the paper's structures; the last part of each log is held out from the comparison.
fn score_orders(records: &[Record], most: usize, offset: bool) -> Result<OrderTable, RoadError> {
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
    orders: ArxOrders,
    record: &Record,
) -> Result<(ArxModel, Vec<Event>), RoadError> {
    let (nu, channels) = (record.inputs().len(), record.outputs().len());
    let identifier = recursive(spec, orders, nu, channels)?;
    let simulator = ArxSimulator::new(orders, nu, channels)?;
    let mut compensator = ResidualCompensator::new(identifier, simulator, &spec.compensation)?;
    let mut r_star = vec![0.0; channels];
    let mut events = Vec::new();
    for k in (0..record.len()).filter(|&k| record.is_complete(k)) {
        let r = record.y(k);
        let frame = Frame::new(IoDims { nu, ny: channels }, k as u64, record.u(k), r)?;
        let step = compensator.step(frame, r, &mut r_star);
        events.extend(step.events.iter().map(|kind| Event { k: frame.k(), kind }));
        if step.events.iter().any(|kind| kind == EventKind::Frozen) {
            let theta = compensator.theta().unwrap_or_default().to_vec();
            let model = ArxModel::new(orders, nu, channels, theta, record.ts())?;
            return Ok((model, events));
        }
    }
    Err(RoadError::NotConverged { samples: record.len() })
}
