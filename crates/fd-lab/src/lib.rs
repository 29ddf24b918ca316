//! Experiments and proofs, which no user of the library links: what the methods gain, and how often they are right.
//!
//! | room | question |
//! |---|---|
//! | [`engine`] | what does residual compensation gain on 1000 perturbed engines? |
//! | [`compare`] | which method wins where, at the same rate of false alarms? |
//! | [`blind`] | how often is the gap diagnosis right on cases whose truth is sealed? |
//! | [`engine_gap`] | does it name the cause that an engine was given? |
//! | [`journal`] | finished pieces of work, so that a killed run goes on |

pub mod blind;
pub mod compare;
pub mod engine;
pub mod engine_gap;
pub mod journal;
mod quantile;
