//! Limits: `docs/limits.md` lists them as they are; what is taken of a budget is gone.

use std::path::Path;

use fd_core::{
    LimitError, Limits, Resource,
    memory::{Budget, MemoryError},
};
use proptest::prelude::*;

#[test]
fn the_table_of_limits_is_that_of_the_source() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/limits.md");
    let text = std::fs::read_to_string(&page).unwrap_or_default();
    let limits = Limits::default();
    let mut from = 0;
    for resource in Resource::ALL {
        let row = format!("| `{}` | {} |", resource.name(), limits.most(resource));
        let at = text[from..].find(&row);
        assert!(at.is_some(), "{}: expected the row {row} here", page.display());
        from += at.unwrap_or_default();
    }
}

#[test]
fn what_is_at_a_limit_is_allowed_and_what_is_beyond_is_not() {
    for resource in Resource::ALL {
        let limits = Limits::default();
        let most = limits.most(resource) as f64;
        assert_eq!(limits.check(resource, "x", most), Ok(()));
        for beyond in [most.next_up(), 2.0 * most, f64::INFINITY, f64::NAN] {
            let error = limits.check(resource, "a.b", beyond).err();
            let named = |e: &LimitError| e.what == "a.b" && e.resource == resource;
            assert!(error.as_ref().is_some_and(named), "{beyond}: {error:?}");
            let text = error.map_or_else(String::new, |error| error.to_string());
            assert!(text.contains(&format!("(limit `{}`)", resource.name())), "{text}");
        }
    }
}

proptest! {
    #[test]
    fn what_is_taken_of_a_budget_is_gone(whole in 0..1000_u64, takes in prop::collection::vec(0..400_u64, 0..9)) {
        let (mut budget, mut left) = (Budget::of(whole), whole);
        for bytes in takes {
            let taken = budget.take("x", bytes);
            let refused = MemoryError::Budget { what: "x".to_owned(), most: left, found: bytes };
            prop_assert_eq!(taken, if left < bytes { Err(refused) } else { Ok(()) });
            left -= if left < bytes { 0 } else { bytes };
            prop_assert_eq!(budget.left(), left);
        }
    }
}
