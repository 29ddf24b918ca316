//! Slopes of residuals, column by column, most of which many fits share.
//!
//! With 24 outputs, 1000 samples and 60 parameters the slopes of a fit are 12 MB, and there are a thousand candidates. All
//! of them have the slopes of the nuisances from the fit without any effect, until they are fitted to the end: so these
//! are there once, and so are their scalar products.

use std::{ops::Range, sync::Arc};

use fd_numeric::wide::dots;

use super::layout::Layout;

/// Slopes of residuals, column by column: shared unknowns, then own ones. Copies share what they have in common.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    all: Vec<Arc<Vec<f64>>>,
    products: Option<Arc<Products>>,
}

/// Scalar products of columns with each other.
#[derive(Debug)]
struct Products {
    of: Vec<Arc<Vec<f64>>>,
    /// Per segment, row by row.
    values: Vec<Vec<f64>>,
}

impl Columns {
    /// Columns of the same length.
    ///
    /// ```
    /// use fd_gap::fit::Columns;
    ///
    /// let columns = Columns::new(vec![vec![1.0, 2.0], vec![0.0, 1.0]]);
    /// assert_eq!(columns.iter().nth(1), Some(&[0.0, 1.0][..]));
    /// ```
    #[must_use]
    pub fn new(all: Vec<Vec<f64>>) -> Self {
        Self { all: all.into_iter().map(Arc::new).collect(), products: None }
    }

    /// The columns.
    pub fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.all.iter().map(|column| column.as_slice())
    }

    /// Puts new columns into the place of some.
    ///
    /// # Panics
    ///
    /// Panics when these are not there.
    pub fn splice(&mut self, place: Range<usize>, new: Vec<Vec<f64>>) {
        self.all.splice(place, new.into_iter().map(Arc::new));
    }

    /// The same, with the products of all columns, for those who share them.
    pub(crate) fn multiplied(mut self, layout: &Layout) -> Self {
        let of_segment = |rows: &Range<usize>| -> Vec<f64> {
            let columns: Vec<&[f64]> = self.iter().map(|column| &column[rows.clone()]).collect();
            let mut values = vec![0.0; columns.len() * columns.len()];
            for (i, column) in columns.iter().enumerate() {
                for (j, product) in dots(column, &columns[..=i]).into_iter().enumerate() {
                    values[i * columns.len() + j] = product;
                    values[j * columns.len() + i] = product;
                }
            }
            values
        };
        let values = layout.segments.iter().map(of_segment).collect();
        self.products = Some(Arc::new(Products { of: self.all.clone(), values }));
        self
    }

    /// The place of each column among those of which products are known.
    pub(super) fn known(&self) -> Vec<Option<usize>> {
        let place = |column: &Arc<Vec<f64>>| {
            let products = self.products.as_ref()?;
            products.of.iter().position(|known| Arc::ptr_eq(known, column))
        };
        self.all.iter().map(place).collect()
    }

    /// The product, in a segment, of two columns of which products are known.
    pub(super) fn product(&self, segment: usize, i: usize, j: usize) -> f64 {
        self.products.as_ref().map_or(f64::NAN, |p| p.values[segment][i * p.of.len() + j])
    }
}

impl PartialEq for Columns {
    fn eq(&self, other: &Self) -> bool {
        self.all == other.all
    }
}
