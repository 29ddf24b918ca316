//! The matrix of a residual that is linear in a window.

use faer::{Mat, MatRef};
use fd_core::{HeapMap, IoDims, Scalar, Shape, ShapeError};
use fd_model::freeze;

use super::run::WindowMap;
use crate::error::DataError;

/// `r = F w + c` for a window `w` of `order + 1` samples of `[u; y]`, oldest first.
#[derive(Clone, Debug)]
pub struct WindowMapDesign {
    io: IoDims,
    order: usize,
    map: Mat<f64>,
    constant: Vec<f64>,
}

impl WindowMapDesign {
    /// A map with one row per residual; `constant` has one entry per row.
    ///
    /// # Errors
    ///
    /// Returns an error when sizes do not fit, or a number is not finite.
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Frame, IoDims, stage::ResidualGenerator};
    /// use fd_data::window::WindowMapDesign;
    ///
    /// // y(k) − 0.5 y(k−1) − u(k−1), of windows [u(k−1), y(k−1), u(k), y(k)].
    /// let io = IoDims { nu: 1, ny: 1 };
    /// let design = WindowMapDesign::new(io, 1, mat![[-1.0, -0.5, 0.0, 1.0]], vec![0.0])?;
    /// let (mut lag, mut r) = (design.freeze::<f64>()?, [0.0]);
    /// lag.step(Frame::new(io, 0, &[1.0], &[2.0])?, &mut r);
    /// lag.step(Frame::new(io, 1, &[1.0], &[2.5])?, &mut r);
    /// assert_eq!(r, [0.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        io: IoDims,
        order: usize,
        map: Mat<f64>,
        constant: Vec<f64>,
    ) -> Result<Self, DataError> {
        let found = Shape::new(map.nrows(), map.ncols());
        let expected = Shape::new(constant.len(), (order + 1) * (io.nu + io.ny));
        if found != expected {
            return Err(ShapeError { role: "window map F", expected, found }.into());
        }
        let all = map.col_iter().flat_map(|column| column.iter().copied().collect::<Vec<_>>());
        if let Some(found) = all.chain(constant.iter().copied()).find(|v| !v.is_finite()) {
            let expected = "finite numbers".to_owned();
            return Err(DataError::Setting { setting: "window map", expected, found });
        }
        Ok(Self { io, order, map, constant })
    }

    /// Channels of a sample.
    #[must_use]
    pub fn io(&self) -> IoDims {
        self.io
    }

    /// Window length minus one.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// `F`: one row per residual, one column per channel and sample, oldest sample first.
    #[must_use]
    pub fn map(&self) -> MatRef<'_, f64> {
        self.map.as_ref()
    }

    /// `c`, one entry per residual.
    #[must_use]
    pub fn constant(&self) -> &[f64] {
        &self.constant
    }

    /// Moves the map to run time.
    ///
    /// # Errors
    ///
    /// None for a design that was made.
    pub fn freeze<T: Scalar>(&self) -> Result<WindowMap<T>, DataError> {
        let map: HeapMap<T> = freeze("window map F", self.map.as_ref())?;
        Ok(WindowMap::new(self.io, self.order, map, &self.constant))
    }
}
