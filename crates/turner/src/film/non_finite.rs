//! Non-finite samples.

/// Samples with NaN or infinity: they are not added to the sums, but counted, and the first one is reported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NonFinite {
    /// The number of such samples.
    pub count: u64,
    /// (row, column, sample index) of the first in picture order.
    pub first: Option<(u32, u32, u32)>,
}

impl NonFinite {
    /// Counts one.
    pub fn note(&mut self, x: u32, y: u32, index: u32) {
        self.merge(&NonFinite { count: 1, first: Some((y, x, index)) });
    }

    /// Adds the counts of another part.
    pub fn merge(&mut self, other: &NonFinite) {
        self.count = self.count.saturating_add(other.count);
        self.first = match (self.first, other.first) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
    }
}
