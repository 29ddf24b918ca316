//! What all units of a fleet share.

use faer::{MatRef, traits::ComplexField};
use fd_core::{Heap, IoDims};
use fd_ident::{arx::ArxOrders, batch::BatchScalar, rls::RlsDesign};
use fd_residual::ResidualForm;

use super::error::FleetError;

/// A number that fleets compute with: `f64` or `f32`.
///
/// ```
/// use fdiag::fleet::{FleetBlock, FleetScalar};
///
/// /// Room for a second of samples of all units.
/// fn second<T: FleetScalar>(units: usize) -> FleetBlock<T> {
///     FleetBlock::new(fdiag::core::IoDims { nu: 1, ny: 1 }, units, 10)
/// }
///
/// let mut block = second::<f32>(100);
/// block.set(99, 9, &[0.5], &[1.5]);
/// ```
pub trait FleetScalar: BatchScalar + ComplexField {}

impl<T: BatchScalar + ComplexField> FleetScalar for T {}

/// Everything that is decided before the first sample.
#[derive(Clone, Debug)]
pub struct FleetDesign<D, J> {
    /// From `u` and `y` of a unit to its residual, for example
    /// [`GeneratorDesign::form`](crate::residual::GeneratorDesign::form).
    pub generator: ResidualForm,
    /// Orders of each unit's bias model, for each residual channel.
    pub orders: ArxOrders,
    /// How its parameters are learned; the batch engine knows some kinds of forgetting only.
    pub learning: RlsDesign,
    /// Complete samples in which the generator forgets where it started, and nothing is learned.
    pub settling: u64,
    /// Samples that each unit learns from before its parameters are frozen; at least 1. Samples
    /// whose past is missing do not count.
    pub training: u64,
    /// Judges the compensated residual of each unit; every unit gets a copy.
    pub detector: D,
    /// Makes decisions of verdicts; every unit gets a copy.
    pub rule: J,
}

/// The generator as one matrix, and what parts need to know besides.
#[derive(Clone, Debug)]
pub(super) struct Shared<T> {
    pub io: IoDims,
    pub nx: usize,
    pub channels: usize,
    /// `[A B; C D]`, row by row, with `B = [B_u B_y]` and `D = [D_u D_y]`.
    matrix: Vec<T>,
    pub settling: u64,
    pub training: u64,
}

impl<T: FleetScalar> Shared<T> {
    pub(super) fn new<D, J>(design: &FleetDesign<D, J>) -> Result<Self, FleetError> {
        let FleetDesign { generator, settling, training, .. } = design;
        if *training == 0 {
            let (setting, expected) = ("training", "at least 1 sample");
            return Err(FleetError::Setting { setting, expected, found: 0 });
        }
        // What a pipeline would refuse to run, a fleet refuses too.
        generator.freeze::<T, Heap, Heap>()?;
        let (io, system) = (generator.io(), generator.system());
        let (nx, channels) = (system.nx(), system.ny());
        let entry = |row: usize, column: usize| match (row < nx, column < nx) {
            (true, true) => system.a()[(row, column)],
            (true, false) => system.b()[(row, column - nx)],
            (false, true) => system.c()[(row - nx, column)],
            (false, false) => system.d()[(row - nx, column - nx)],
        };
        let columns = nx + io.nu + io.ny;
        let matrix = (0..(nx + channels) * columns)
            .map(|at| T::from_design(entry(at / columns, at % columns)))
            .collect();
        Ok(Self { io, nx, channels, matrix, settling: *settling, training: *training })
    }

    /// Rows `[x; u; y]`.
    pub(super) fn columns(&self) -> usize {
        self.nx + self.io.nu + self.io.ny
    }

    /// Rows `[x⁺; r]`.
    pub(super) fn rows(&self) -> usize {
        self.nx + self.channels
    }

    pub(super) fn matrix(&self) -> MatRef<'_, T> {
        MatRef::from_row_major_slice(&self.matrix, self.rows(), self.columns())
    }
}
