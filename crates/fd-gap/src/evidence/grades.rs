//! How much evidence is how much: differences of its natural logarithm.
//!
//! The grades of Kass & Raftery (1995, section 3.2), who give twice the logarithm: from 2 on evidence is positive, from 6
//! on strong, from 10 on very strong. A question asks for the grade that a wrong answer to it deserves.

/// Less is worth no more than a bare mention: a factor of 2.7.
pub(crate) const BARE_MENTION: f64 = 1.0;
/// A factor of 20: what is nearer to the best than that cannot be told from it.
pub(crate) const STRONG: f64 = 3.0;
/// A factor of 150: what a further cause, or a strength that nobody has named, must bring.
pub(crate) const VERY_STRONG: f64 = 5.0;
/// A factor of 22 000: what only a mistake in the model of the noise could be.
pub(crate) const BEYOND_DOUBT: f64 = 10.0;
