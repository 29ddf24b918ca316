//! Running the observer of a set of states.

use fd_core::{
    Frame, HeapMap, IoDims, LinMap, Scalar, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

use super::set::{Zonotope, dot};

/// The matrices of the model and its bounds, rounded to the scalar that runs.
#[derive(Clone, Debug)]
pub(super) struct Parts<T: Scalar> {
    /// `A − L C`, `B − L D`, `L`.
    pub closed: HeapMap<T>,
    pub b: HeapMap<T>,
    pub gain: HeapMap<T>,
    /// Rows of `C`, columns of `L` and of `E`, as slices.
    pub c_rows: Vec<Vec<T>>,
    pub gain_columns: Vec<Vec<T>>,
    pub disturbance: Vec<Vec<T>>,
    pub d: HeapMap<T>,
    pub noise: Vec<T>,
    /// `ΔA`, `ΔB`, `ΔC`, `ΔD`, if any is above zero.
    pub model: Option<[HeapMap<T>; 4]>,
}

/// An observer of all states that the bounds allow; all memory is taken at construction.
#[derive(Clone, Debug)]
pub struct ZonotopeObserver<T: Scalar> {
    parts: Parts<T>,
    start: Zonotope<T>,
    set: Zonotope<T>,
    /// Columns that are left after each sample.
    most: usize,
    /// Half widths of the predicted outputs at the last sample.
    widths: Vec<T>,
    scratch: Scratch<T>,
}

/// Memory that does not outlive a sample.
#[derive(Clone, Debug)]
struct Scratch<T> {
    centre: Vec<T>,
    /// Largest magnitudes of the states and of the inputs.
    state: Vec<T>,
    input: Vec<T>,
    /// Half widths of what the model adds to the states, and of the noise on the outputs.
    unsure: Vec<T>,
    noise: Vec<T>,
    column: Vec<T>,
}

impl<T: Scalar> ZonotopeObserver<T> {
    pub(super) fn new(parts: Parts<T>, start: Zonotope<T>, most: usize) -> Self {
        let (nx, nu, ny) = (parts.closed.nrows(), parts.b.ncols(), parts.noise.len());
        let zeros = |len: usize| vec![T::zero(); len];
        let scratch = Scratch {
            centre: zeros(nx),
            state: zeros(nx),
            input: zeros(nu),
            unsure: zeros(nx),
            noise: zeros(ny),
            column: zeros(nx),
        };
        Self { parts, set: start.clone(), start, most, widths: zeros(ny), scratch }
    }

    /// The states that the samples so far allow at the next sample.
    #[must_use]
    pub fn states(&self) -> &Zonotope<T> {
        &self.set
    }

    /// Half widths of the predicted outputs at the last sample, in the units of the outputs.
    #[must_use]
    pub fn half_widths(&self) -> &[T] {
        &self.widths
    }
}

impl<T: Scalar> Stage<T> for ZonotopeObserver<T> {
    fn reset(&mut self) {
        self.set.copy_from(&self.start);
        self.widths.fill(T::zero());
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.set.visit_state(visitor);
        visitor.reals("half widths of the outputs", &mut self.widths);
    }
}

impl<T: Scalar> ResidualGenerator<T> for ZonotopeObserver<T> {
    fn io(&self) -> IoDims {
        IoDims { nu: self.parts.b.ncols(), ny: self.parts.noise.len() }
    }

    fn residual_len(&self) -> usize {
        self.parts.noise.len()
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        let (u, y) = (frame.u(), frame.y());
        let Self { parts, set, scratch, widths, .. } = self;
        scratch.noise.copy_from_slice(&parts.noise);
        scratch.unsure.fill(T::zero());
        if let Some([a, b, c, d]) = &parts.model {
            for (i, (size, centre)) in scratch.state.iter_mut().zip(set.centre()).enumerate() {
                *size = centre.abs() + set.radius(i);
            }
            for (size, u) in scratch.input.iter_mut().zip(u) {
                *size = u.abs();
            }
            a.mul_into(&scratch.state, &mut scratch.unsure);
            b.mul_add_into(&scratch.input, &mut scratch.unsure);
            c.mul_add_into(&scratch.state, &mut scratch.noise);
            d.mul_add_into(&scratch.input, &mut scratch.noise);
        }
        // r = (y − C c − D u) over its largest magnitude.
        parts.d.mul_into(u, r);
        let rows = parts.c_rows.iter().zip(&scratch.noise).zip(widths.iter_mut());
        for ((r, &y), ((row, &noise), width)) in r.iter_mut().zip(y).zip(rows) {
            *width = set.half_width(row) + noise;
            *r = (y - *r - dot(row, set.centre())) / *width;
        }
        parts.closed.mul_into(set.centre(), &mut scratch.centre);
        parts.b.mul_add_into(u, &mut scratch.centre);
        parts.gain.mul_add_into(y, &mut scratch.centre);
        set.move_to(&scratch.centre);
        set.turn(&parts.closed);
        for column in &parts.disturbance {
            set.add(column);
        }
        for (column, &noise) in parts.gain_columns.iter().zip(&scratch.noise) {
            for (own, &l) in scratch.column.iter_mut().zip(column) {
                *own = l * noise;
            }
            set.add(&scratch.column);
        }
        if parts.model.is_some() {
            set.add_box(scratch.unsure.iter().copied());
        }
        set.reduce(self.most);
    }
}
