//! Sets of indices as ranges: the samples that a tile holds, the light paths that a film holds.

use std::ops::Range;

/// A set of sample indices or light path indices. Passes add long runs of indices, so a few ranges hold them all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleSet {
    /// In ascending order; not empty, not overlapping, not adjacent.
    ranges: Vec<Range<u64>>,
}

impl SampleSet {
    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// The number of indices.
    pub fn len(&self) -> u64 {
        self.ranges.iter().map(|r| r.end - r.start).sum()
    }

    /// The ranges in ascending order, with gaps between them.
    pub fn ranges(&self) -> &[Range<u64>] {
        &self.ranges
    }

    /// The inverse of [`SampleSet::ranges`]; `None` if a range is empty, or two are adjacent, overlap or are out
    /// of order.
    pub fn from_ranges(ranges: Vec<Range<u64>>) -> Option<SampleSet> {
        let rising = ranges.windows(2).all(|w| w[0].end < w[1].start);
        (rising && ranges.iter().all(|r| r.start < r.end)).then_some(SampleSet { ranges })
    }

    /// The smallest index that is not in the set.
    pub fn first_missing(&self) -> u64 {
        self.ranges.first().filter(|r| r.start == 0).map_or(0, |r| r.end)
    }

    /// Whether an index is in the set.
    pub fn contains(&self, number: u64) -> bool {
        let after = self.ranges.partition_point(|r| r.end <= number);
        self.ranges.get(after).is_some_and(|r| r.start <= number)
    }

    /// Adds all indices of a range.
    pub fn insert(&mut self, range: Range<u64>) {
        if range.is_empty() {
            return;
        }
        // Ranges that touch or overlap the new one are merged with it.
        let first = self.ranges.partition_point(|r| r.end < range.start);
        let last = self.ranges.partition_point(|r| r.start <= range.end);
        let mut merged = range;
        if let (true, Some(low), Some(high)) =
            (first < last, self.ranges.get(first), self.ranges.get(last.max(1) - 1))
        {
            merged = merged.start.min(low.start)..merged.end.max(high.end);
        }
        self.ranges.splice(first..last, [merged]);
    }

    /// Adds all indices of another set.
    pub fn insert_all(&mut self, other: &SampleSet) {
        other.ranges.iter().for_each(|r| self.insert(r.clone()));
    }

    /// The parts of a range that are not in the set, in ascending order.
    pub fn missing(&self, range: Range<u64>) -> Vec<Range<u64>> {
        let mut out = Vec::new();
        let mut at = range.start;
        let first = self.ranges.partition_point(|r| r.end <= range.start);
        for held in self.ranges[first..].iter().take_while(|r| r.start < range.end) {
            if at < held.start {
                out.push(at..held.start);
            }
            at = held.end;
        }
        if at < range.end {
            out.push(at..range.end);
        }
        out
    }

    /// The parts of a range that are in the set, in ascending order.
    pub fn within(&self, range: Range<u64>) -> Vec<Range<u64>> {
        let first = self.ranges.partition_point(|r| r.end <= range.start);
        let held = self.ranges[first..].iter().take_while(|r| r.start < range.end);
        held.map(|r| r.start.max(range.start)..r.end.min(range.end)).collect()
    }

    /// The first run of indices in both sets.
    pub fn overlap(&self, other: &SampleSet) -> Option<Range<u64>> {
        let (mut a, mut b) = (self.ranges.iter().peekable(), other.ranges.iter().peekable());
        while let (Some(x), Some(y)) = (a.peek(), b.peek()) {
            let both = x.start.max(y.start)..x.end.min(y.end);
            if !both.is_empty() {
                return Some(both);
            }
            if x.end <= y.end {
                a.next();
            } else {
                b.next();
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The same results as sets of single indices.
        #[test]
        fn ranges_are_sets(
            a in proptest::collection::vec((0u64..40, 0u64..9), 0..12),
            b in proptest::collection::vec((0u64..40, 0u64..9), 0..12),
            asked in (0u64..50, 0u64..30),
        ) {
            let make = |parts: &[(u64, u64)]| {
                let (mut ranges, mut plain) = (SampleSet::default(), BTreeSet::new());
                for &(start, count) in parts {
                    ranges.insert(start..start + count);
                    plain.extend(start..start + count);
                }
                (ranges, plain)
            };
            let ((a, plain_a), (b, plain_b)) = (make(&a), make(&b));
            prop_assert_eq!(SampleSet::from_ranges(a.ranges().to_vec()), Some(a.clone()));
            prop_assert_eq!(a.len(), plain_a.len() as u64);
            prop_assert!((0..60).all(|n| a.contains(n) == plain_a.contains(&n)));
            prop_assert_eq!(Some(a.first_missing()), (0..60).find(|n| !plain_a.contains(n)));
            let range = asked.0..asked.0 + asked.1;
            let missing: Vec<u64> = a.missing(range.clone()).into_iter().flatten().collect();
            let (held, expected) = range.clone().partition::<Vec<u64>, _>(|n| plain_a.contains(n));
            prop_assert_eq!(missing, expected);
            prop_assert_eq!(a.within(range).into_iter().flatten().collect::<Vec<u64>>(), held);
            let first = plain_a.intersection(&plain_b).next().copied();
            prop_assert_eq!(a.overlap(&b).map(|r| r.start), first);
            if let Some(run) = a.overlap(&b) {
                prop_assert!(run.clone().all(|n| plain_a.contains(&n) && plain_b.contains(&n)));
            }
            let mut all = a.clone();
            all.insert_all(&b);
            prop_assert!((0..60).all(|n| all.contains(n) == (plain_a.contains(&n) || plain_b.contains(&n))));
        }
    }

    #[test]
    fn ranges_that_touch_or_are_empty_are_refused() {
        for bad in [vec![0..2, 2..3], vec![3..3, 5..6], vec![4..6, 1..2], vec![0..5, 3..9]] {
            assert_eq!(SampleSet::from_ranges(bad), None);
        }
    }
}
