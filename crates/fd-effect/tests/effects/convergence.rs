//! The simulation of each law converges to that with a far shorter integration step.

use proptest::prelude::*;

use crate::{
    cases::{Case, PLANTS, name},
    finer::{error, run},
};

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(12) })]

    /// Whatever the law, the place and the start: a hundredth of the step changes the run by little, and a fourth of the step
    /// leaves less of that.
    #[test]
    fn every_law_converges(
        plant in 0..PLANTS.len(),
        which in any::<prop::sample::Index>(),
        start in any::<prop::sample::Index>(),
    ) {
        let case = Case::new(PLANTS[plant], 150);
        let candidates = case.simulated();
        let candidate = &candidates[which.index(candidates.len())];
        let start = &candidate.starts[start.index(candidate.starts.len())];
        let fine = run(&case, candidate, start, 100);
        let [coarse, finer] = [1, 4].map(|f| error(&case, &run(&case, candidate, start, f), &fine));
        // What a switch within a sample makes of one row.
        prop_assert!(coarse < 0.05, "{}: {coarse}", name(candidate));
        prop_assert!(finer < 0.5 * coarse + 2e-3, "{}: {coarse}, {finer}", name(candidate));
    }
}
