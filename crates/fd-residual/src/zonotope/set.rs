//! A zonotope: the image of a cube.

use std::cmp::Ordering;

use fd_core::{HeapMap, LinMap, Scalar, StateVisitor};
use fd_model::ModelError;

use crate::error::DesignError;

/// The set `c + Σ_j h_j ξ_j` with `|ξ_j| ≤ 1`, in memory that is taken once.
#[derive(Clone, Debug, PartialEq)]
pub struct Zonotope<T> {
    centre: Vec<T>,
    /// Columns `h_j`, one after the other, as far as `count` says.
    columns: Vec<T>,
    count: u64,
    /// Memory of a step: a column, and columns with their rank in a reduction.
    column: Vec<T>,
    ranked: Vec<(T, usize)>,
    kept: Vec<T>,
}

impl<T: Scalar> Zonotope<T> {
    /// A box: its centre, its half widths in the same unit, and for how many columns there is room.
    ///
    /// # Errors
    ///
    /// Returns an error when the lengths differ, there is less room than the box needs, or a half width is negative or
    /// not finite.
    ///
    /// # Examples
    ///
    /// ```
    /// use fd_residual::zonotope::Zonotope;
    ///
    /// let square = Zonotope::<f64>::of_box(&[1.0, 2.0], &[0.5, 0.5], 8)?;
    /// assert_eq!(square.half_width(&[1.0, -1.0]), 1.0);
    /// assert!(Zonotope::<f64>::of_box(&[0.0], &[-1.0], 8).is_err());
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn of_box(centre: &[f64], radii: &[f64], room: usize) -> Result<Self, DesignError> {
        let n = centre.len();
        if radii.len() != n {
            return Err(DesignError::Count {
                what: "half widths of a box",
                expected: n,
                found: radii.len(),
            });
        }
        if room < n {
            return Err(DesignError::Count {
                what: "columns of a zonotope",
                expected: n,
                found: room,
            });
        }
        if let Some(&value) = radii.iter().find(|r| !(0.0 <= **r && r.is_finite())) {
            return Err(ModelError::OutOfRange {
                role: "half width of a box",
                range: "[0, inf)",
                value,
            }
            .into());
        }
        let mut set = Self {
            centre: centre.iter().map(|&c| T::from_design(c)).collect(),
            columns: vec![T::zero(); n * room],
            count: 0,
            column: vec![T::zero(); n],
            ranked: vec![(T::zero(), 0); room],
            kept: vec![T::zero(); n * room],
        };
        set.add_box(radii.iter().map(|&r| T::from_design(r)));
        Ok(set)
    }

    /// Its centre.
    #[must_use]
    pub fn centre(&self) -> &[T] {
        &self.centre
    }

    /// Its columns.
    pub fn columns(&self) -> impl Iterator<Item = &[T]> {
        self.columns.chunks_exact(self.centre.len().max(1)).take(self.len())
    }

    /// How many columns it has.
    #[must_use]
    pub fn len(&self) -> usize {
        usize::try_from(self.count).unwrap_or(usize::MAX)
    }

    /// Whether it is a point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// How many columns fit.
    #[must_use]
    pub fn room(&self) -> usize {
        self.columns.len() / self.centre.len().max(1)
    }

    /// How far the set reaches to either side of its centre along a direction, `Σ_j |d·h_j|`.
    #[must_use]
    pub fn half_width(&self, direction: &[T]) -> T {
        self.columns().map(|column| dot(direction, column).abs()).fold(T::zero(), |sum, v| sum + v)
    }

    /// How far the set reaches from its centre in coordinate `i`; zero for one that does not exist.
    #[must_use]
    pub fn radius(&self, i: usize) -> T {
        let entries = self.columns().filter_map(|column| column.get(i));
        entries.fold(T::zero(), |sum, v| sum + v.abs())
    }

    /// Puts the centre somewhere else.
    pub(super) fn move_to(&mut self, centre: &[T]) {
        for (own, &new) in self.centre.iter_mut().zip(centre) {
            *own = new;
        }
    }

    /// The image under a square matrix; the centre is left alone.
    pub(super) fn turn(&mut self, a: &HeapMap<T>) {
        let (n, len) = (self.centre.len().max(1), self.len());
        for column in self.columns.chunks_exact_mut(n).take(len) {
            a.mul_into(column, &mut self.column);
            column.copy_from_slice(&self.column);
        }
    }

    /// Adds a segment `h [−1, 1]`. Makes room by a reduction when there is none.
    pub fn add(&mut self, segment: &[T]) {
        if segment.iter().all(|v| *v == T::zero()) {
            return;
        }
        if self.len() >= self.room() {
            self.reduce(self.room() - 1);
        }
        let n = self.centre.len();
        let from = self.len() * n;
        if let Some(column) = self.columns.get_mut(from..from + n) {
            for (own, &new) in column.iter_mut().zip(segment) {
                *own = new;
            }
            self.count += 1;
        }
    }

    /// Adds a box with these half widths.
    pub fn add_box(&mut self, radii: impl Iterator<Item = T>) {
        let mut edge = std::mem::take(&mut self.column);
        for (i, radius) in radii.take(self.centre.len()).enumerate() {
            edge.fill(T::zero());
            if let Some(entry) = edge.get_mut(i) {
                *entry = radius;
            }
            self.add(&edge);
        }
        self.column = edge;
    }

    /// A set around this one with at most `most` columns: the shortest, by `‖h‖₁ − ‖h‖∞`, become a box.
    ///
    /// A column along a coordinate has the length zero in this measure: nothing is lost by putting it into a box. With
    /// room for fewer columns than coordinates, nothing can be done and nothing is.
    pub fn reduce(&mut self, most: usize) {
        let (n, len) = (self.centre.len(), self.len());
        if len <= most || most < n {
            return;
        }
        let columns = self.columns.chunks_exact(n.max(1)).take(len).enumerate();
        for (ranked, (j, column)) in self.ranked.iter_mut().zip(columns) {
            let sum = column.iter().fold(T::zero(), |sum, v| sum + v.abs());
            let largest = column.iter().fold(T::zero(), |most, v| most.max(v.abs()));
            *ranked = (sum - largest, j);
        }
        // Longest first; among equals the older one, so that the result does not depend on the sort.
        self.ranked[..len].sort_unstable_by(|a, b| {
            b.0.partial_cmp(&a.0).unwrap_or(Ordering::Equal).then(a.1.cmp(&b.1))
        });
        let stays = most - n;
        self.column.fill(T::zero());
        for (rank, &(_, j)) in self.ranked[..len].iter().enumerate() {
            let column = &self.columns[j * n..(j + 1) * n];
            if rank < stays {
                self.kept[rank * n..(rank + 1) * n].copy_from_slice(column);
            } else {
                for (radius, v) in self.column.iter_mut().zip(column) {
                    *radius += v.abs();
                }
            }
        }
        self.columns[..stays * n].copy_from_slice(&self.kept[..stays * n]);
        for i in 0..n {
            let edge = &mut self.columns[(stays + i) * n..(stays + i + 1) * n];
            edge.fill(T::zero());
            edge[i] = self.column[i];
        }
        self.count = (stays + n) as u64;
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.centre.copy_from_slice(&other.centre);
        self.columns.copy_from_slice(&other.columns);
        self.count = other.count;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("centre of the states", &mut self.centre);
        visitor.reals("columns of the zonotope", &mut self.columns);
        visitor.counts("number of columns", std::slice::from_mut(&mut self.count));
    }
}

pub(super) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (&a, &b)| sum + a * b)
}
