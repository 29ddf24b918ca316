//! The integration tests of `fd-ident`, one program.

mod allocation;
mod arx_model;
mod arx_road;
mod batch;
mod batch_samples;
mod common;
mod equation_18;
mod equation_18_alpha;
mod instructions;
mod laws;
mod least_squares;
mod noise_methods;
mod order_selection;
mod recursive_noise_methods;
mod refinement;
mod rls_identities;
mod rls_information;
mod rls_long;
mod rls_stability;
mod structures;
