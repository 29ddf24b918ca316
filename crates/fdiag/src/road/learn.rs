//! Learning the bias from healthy residuals, in one go or sample by sample.

use fd_compensate::residual_compensation::ResidualCompensator;
use fd_core::{Event, EventKind, Frame, IoDims, stage::Compensator};
use fd_ident::arx::{ArxFit, ArxModel, ArxOrders, ArxSimulator};
use fd_model::Record;
use fd_residual::GeneratorDesign;

use super::{error::RoadError, train::recursive};
use crate::spec::{LearningSpec, OrderSpec, PipelineSpec};

/// A bias model and how it came about.
pub(super) struct Learned {
    pub(super) model: ArxModel,
    pub(super) events: Vec<Event>,
}

/// Learns from residual records, one per log.
pub(super) fn learn(
    spec: &PipelineSpec,
    design: &dyn GeneratorDesign,
    records: &[Record],
) -> Result<Learned, RoadError> {
    let orders = match &spec.bias.orders {
        OrderSpec::Fixed(orders) => *orders,
        OrderSpec::Select { .. } => ArxOrders::paper(2),
    };
    let learned = match &spec.bias.learning {
        LearningSpec::Batch { .. } => {
            let model = ArxFit::new(orders).fit(records)?.model;
            Learned { model, events: Vec::new() }
        }
        LearningSpec::Recursive(_) => match records {
            [record] => learn_on_line(spec, orders, record)?,
            _ => return Err(RoadError::RecursiveNeedsOneLog { found: records.len() }),
        },
    };
    let _ = design;
    for channel in 0..learned.model.residual_len() {
        let poles = learned.model.poles(channel)?;
        let radius = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
        if radius >= 1.0 {
            return Err(RoadError::UnstableBias { radius });
        }
    }
    Ok(learned)
}

/// Lets the compensator train itself, as it would next to the plant, until it opens its switch.
fn learn_on_line(
    spec: &PipelineSpec,
    orders: ArxOrders,
    record: &Record,
) -> Result<Learned, RoadError> {
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
            return Ok(Learned { model, events });
        }
    }
    Err(RoadError::NotConverged { samples: record.len() })
}
