//! Several causes in one sentence.

use fd_gap::road::{CauseList, End, ListedCause};

use crate::gap_study::words::{capital, list, p, percent, with_strength};

/// The causes with what each takes away, and what is left.
pub(super) fn several(road: &CauseList) -> String {
    let named = |listed: &ListedCause| {
        let share = listed.share.map_or_else(String::new, |share| format!("{}, ", percent(share)));
        format!("{} [{share}{}]", with_strength(&listed.cause), p(listed.probability))
    };
    let names: Vec<String> = road.causes.iter().map(named).collect();
    let left = if road.unexplained.is_finite() {
        format!(
            "; {} of the held-out gap is unexplained, {} is noise",
            percent(road.unexplained),
            percent(road.noise)
        )
    } else {
        "; nothing was held out to check them".to_owned()
    };
    let end = match road.end {
        End::AtTheNoise | End::Enough => "",
        End::NothingHelps => ", and nothing else that was tried helps",
    };
    let how_many = if road.causes.len() == 1 { "One cause" } else { "Several causes" };
    capital(&format!("{how_many}, with the share of the gap: {}{left}{end}.", list(&names, "then")))
}
