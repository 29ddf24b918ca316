//! The numbers that estimators side by side are made of.

use fd_numeric::lanes::{LaneScalar, Machine};

use super::tile::Pass;

/// A number that estimators side by side are made of: `f64` or `f32`. The trait is sealed.
///
/// There is a kernel for each number of parameters and each machine. They are compiled where they are used, which takes
/// minutes; with the feature `testing` they are compiled here, once for all tests.
///
/// ```
/// use fd_ident::batch::{BatchError, BatchRls, BatchScalar};
/// use fd_ident::rls::RlsDesign;
///
/// fn fleet<T: BatchScalar>(design: &RlsDesign) -> Result<BatchRls<T>, BatchError> {
///     BatchRls::new(5, 100, design)
/// }
///
/// assert!(fleet::<f32>(&RlsDesign::default()).is_ok());
/// ```
pub trait BatchScalar: LaneScalar {
    #[doc(hidden)]
    fn learn(pass: Pass<'_, Self>, machine: Machine);
}

impl BatchScalar for f64 {
    #[cfg_attr(any(test, not(feature = "testing")), inline)]
    fn learn(pass: Pass<'_, Self>, machine: Machine) {
        pass.run(machine);
    }
}

impl BatchScalar for f32 {
    #[cfg_attr(any(test, not(feature = "testing")), inline)]
    fn learn(pass: Pass<'_, Self>, machine: Machine) {
        pass.run(machine);
    }
}
