//! Generators that are learned from healthy logs alone.

use faer::{Mat, MatRef};
use fd_core::{IoDims, stage::ResidualGenerator};
use fd_data::{
    DataError,
    cva::{CvaDesign, States},
    monitor::MonitorDesign,
    parity::DataParityDesign,
    pca::{Components, PcaDesign},
    window::WindowMapDesign,
};
use fd_model::{Discrete, Record, StateSpace};
use fd_residual::{DesignError, GeneratorDesign, ResidualForm};

use super::{
    GeneratorSpec,
    component::{ComponentSpec, PartSpec},
    error::GeneratorSpecError,
};
use crate::spec::NominalPlant;

/// A generator that was learned. The form of a map is the map without its constant part; that of statistics,
/// which are squares, is that at the centre, where they do not respond.
#[derive(Clone, Debug)]
enum Learned {
    Map(WindowMapDesign),
    Statistics(Box<MonitorDesign>),
}

/// The same in a pipeline of this sample time.
#[derive(Clone, Debug)]
struct LearnedDesign {
    learned: Learned,
    domain: Discrete,
}

/// Learns the generator of a data-driven kind; none for other kinds.
pub(super) fn design(
    spec: &GeneratorSpec,
    plant: &NominalPlant<'_>,
    healthy: &[Record],
) -> Option<Result<Box<dyn GeneratorDesign>, GeneratorSpecError>> {
    let learned = match spec {
        GeneratorSpec::Pca { lags, components, part } => {
            let components = match *components {
                ComponentSpec::Count { count } => Components::Count(count),
                ComponentSpec::Variance { share } => Components::Variance(share),
                ComponentSpec::ParallelAnalysis { draws, seed } => {
                    Components::Parallel { draws, seed }
                }
            };
            let pca = PcaDesign { lags: *lags, components, ..PcaDesign::default() };
            pca.learn(healthy).and_then(|pca| Learned::part(pca.monitor(), *part))
        }
        GeneratorSpec::Cva { past, future, states, part } => {
            let states = states.map_or(States::Aic, States::Count);
            let cva = CvaDesign { past: *past, future: *future, states };
            cva.learn(healthy).and_then(|cva| Learned::part(cva.monitor(), *part))
        }
        GeneratorSpec::DataParity { order, states } => {
            let parity = DataParityDesign { order: *order, states: *states };
            parity.learn(healthy).map(|parity| Learned::Map(parity.map().clone()))
        }
        _ => return None,
    };
    let domain = plant.system.domain();
    let boxed = |learned| Box::new(LearnedDesign { learned, domain }) as Box<dyn GeneratorDesign>;
    Some(learned.map(boxed).map_err(GeneratorSpecError::from))
}

impl Learned {
    fn part(monitor: &MonitorDesign, part: PartSpec) -> Result<Self, DataError> {
        Ok(match part {
            PartSpec::Residual => Self::Map(monitor.residual()?),
            PartSpec::Scores => Self::Map(monitor.scores()?),
            PartSpec::Statistics => Self::Statistics(Box::new(monitor.clone())),
        })
    }
}

impl GeneratorDesign for LearnedDesign {
    fn io(&self) -> IoDims {
        match &self.learned {
            Learned::Map(map) => map.io(),
            Learned::Statistics(monitor) => monitor.io(),
        }
    }

    fn residual_len(&self) -> usize {
        match &self.learned {
            Learned::Map(map) => map.map().nrows(),
            Learned::Statistics(monitor) => 2 + usize::from(monitor.limits().rest.is_some()),
        }
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        let io = self.io();
        let width = io.nu + io.ny;
        match &self.learned {
            Learned::Map(map) => register(io, map.order(), map.map(), self.domain),
            Learned::Statistics(_) => {
                let none = Mat::zeros(self.residual_len(), width);
                register(io, 0, none.as_ref(), self.domain)
            }
        }
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        // A design that was made has the sizes of its own parts.
        let sizes = |_| DesignError::Empty { what: "residual" };
        Ok(match &self.learned {
            Learned::Map(map) => Box::new(map.freeze::<f64>().map_err(sizes)?),
            Learned::Statistics(monitor) => Box::new(monitor.freeze::<f64>().map_err(sizes)?),
        })
    }
}

/// A shift register of the last `order` samples of `[u; y]`, oldest first, and the map behind it.
fn register(
    io: IoDims,
    order: usize,
    map: MatRef<'_, f64>,
    domain: Discrete,
) -> Result<ResidualForm, DesignError> {
    let width = io.nu + io.ny;
    let nx = order * width;
    let shift = Mat::from_fn(nx, nx, |i, j| if i + width == j { 1.0 } else { 0.0 });
    let enter = Mat::from_fn(nx, width, |i, j| if i + width == nx + j { 1.0 } else { 0.0 });
    let (c, d) = (map.subcols(0, nx).to_owned(), map.subcols(nx, width).to_owned());
    ResidualForm::new(io, StateSpace::new(shift, enter, c, d, domain)?)
}
