//! Numbers side by side, computed by the widest registers of the machine: the one place that knows
//! its instructions.
//!
//! [`Machine`] finds out at run time what there is, and takes [`Work`] through code that is compiled
//! for it. Work is written once, for any [`Registers`]: estimators side by side in `fd-ident`, runs
//! of a simulator side by side in `fd-sim`, long scalar products in [`wide`](crate::wide). What is
//! not inlined into it is compiled for the smallest machine, hence `#[inline(always)]` throughout.
//!
//! Sums, products, quotients, roots and comparisons round alike on all machines, and so do the
//! [elementary functions](elementary) made of them: the same bits for one number and for several
//! side by side. [`Registers::mul_add`] alone does not, where a machine has no such instruction.
//!
//! ```
//! use fd_numeric::lanes::{DoubleRegisters, Machine, Registers, Simd, Work};
//!
//! /// Halves all numbers; as many as a row of memory holds, or a multiple.
//! struct Halve<'a>(&'a mut [f64]);
//!
//! impl Work<f64> for Halve<'_> {
//!     type Output = ();
//!
//!     #[inline(always)]
//!     fn run<S: Simd>(self, m: DoubleRegisters<S>) {
//!         let half = m.splat(0.5);
//!         for register in DoubleRegisters::<S>::of_mut(self.0) {
//!             *register = m.mul(*register, half);
//!         }
//!     }
//! }
//!
//! for machine in Machine::all() {
//!     let mut numbers = [3.0; 16];
//!     machine.run(Halve(&mut numbers));
//!     assert_eq!(numbers, [1.5; 16], "{machine}");
//! }
//! ```

mod exponential;
mod machine;
mod registers;
mod sine;

pub use pulp::Simd;

pub use self::{
    machine::{Machine, Work},
    registers::{
        Aligned, DoubleRegisters, Doubles, LaneScalar, Registers, SingleRegisters, Singles,
    },
};

pub mod elementary {
    //! Elementary functions of one number, to the bit what [`DoubleRegisters`](super::DoubleRegisters)
    //! compute in each lane, and the ranges in which they do.

    pub use super::{
        exponential::{FAR as FAR_EXPONENT, exp, tanh},
        sine::{FAR as FAR_ANGLE, SMALL as SMALL_ANGLE, cos, sin},
    };
}
