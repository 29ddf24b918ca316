//! Sums of probabilities over mechanisms at places, and over sides of the plant.

use fd_effect::Side;

use crate::diagnose::result::{Cause, CauseId, Group, Pair, SideShare};

/// Probabilities that mechanisms at places are at work, alone or as one of two.
pub(in crate::diagnose) fn groups<'a>(
    causes: impl IntoIterator<Item = &'a Cause>,
    pairs: &[Pair],
) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let is_of =
        |group: &Group, cause: &Cause| group.family == cause.family && group.site == cause.site;
    for (place, cause) in causes.into_iter().enumerate() {
        if let Some(group) = groups.iter_mut().find(|group| is_of(group, cause)) {
            group.probability += cause.probability;
            group.causes.push(CauseId(place));
        } else {
            groups.push(Group {
                family: cause.family,
                site: cause.site.clone(),
                side: cause.side,
                probability: cause.probability,
                causes: vec![CauseId(place)],
            });
        }
    }
    for group in &mut groups {
        let with = pairs.iter().filter(|pair| pair.causes.iter().any(|cause| is_of(group, cause)));
        group.probability += with.map(|pair| pair.probability).sum::<f64>();
    }
    groups.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    groups
}

/// Probabilities that something is at work on a side of the plant.
pub(in crate::diagnose) fn sides(causes: &[Cause], pairs: &[Pair]) -> Vec<SideShare> {
    let of = |side| {
        let alone = causes.iter().filter(|cause| cause.side == side).map(|cause| cause.probability);
        let is_there = |pair: &&Pair| pair.causes.iter().any(|cause| cause.side == side);
        let paired = pairs.iter().filter(is_there).map(|pair| pair.probability);
        SideShare { side, probability: alone.chain(paired).sum() }
    };
    let mut sides = [Side::Input, Side::Dynamics, Side::Output].map(of);
    sides.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    sides.to_vec()
}
