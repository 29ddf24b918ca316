//! How often something is told that happens again and again.

/// Whether the `count`-th of a row is told: the first, the tenth, the hundredth and so on.
fn is_told(count: u64) -> bool {
    let mut rest = count;
    while 10 <= rest && rest.is_multiple_of(10) {
        rest /= 10;
    }
    rest == 1
}

/// A row of things of one kind, one directly after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Runs {
    pub count: u64,
}

impl Runs {
    /// One more; the count when it is to be told.
    pub(crate) fn more(&mut self) -> Option<u64> {
        self.count += 1;
        is_told(self.count).then_some(self.count)
    }

    /// The row is over; the count when it is to be told, which a row of one has been.
    pub(crate) fn end(&mut self) -> Option<u64> {
        let count = std::mem::take(&mut self.count);
        (1 < count).then_some(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_row_is_told_seldom_and_never_silently() {
        let mut runs = Runs::default();
        let told: Vec<u64> = (0..1234).filter_map(|_| runs.more()).collect();
        assert_eq!(told, [1, 10, 100, 1000]);
        assert_eq!((runs.end(), runs.end()), (Some(1234), None));
        runs.more();
        assert_eq!(runs.end(), None, "one was told when it came");
    }
}
