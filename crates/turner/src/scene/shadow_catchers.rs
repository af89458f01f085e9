//! Shadow catchers: objects of which the camera sees only the shadow on them.

use crate::scene::{Hit, Scene};

/// Which primitives are shadow catchers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ShadowCatchers {
    /// Ranges of primitive IDs: first, and one beyond the last; ascending.
    ranges: Vec<(u32, u32)>,
}

impl ShadowCatchers {
    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Whether a primitive is one, by its ID.
    pub fn contains(&self, primitive: u32) -> bool {
        let behind = self.ranges.partition_point(|(first, _)| *first <= primitive);
        behind.checked_sub(1).and_then(|i| self.ranges.get(i)).is_some_and(|(_, end)| primitive < *end)
    }

    /// Adds a primitive that is behind all others.
    pub(crate) fn add(&mut self, primitive: u32) {
        match self.ranges.last_mut() {
            Some((_, end)) if *end == primitive => *end += 1,
            _ => self.ranges.push((primitive, primitive + 1)),
        }
    }
}

impl Scene {
    /// Whether a hit is on a shadow catcher.
    #[inline]
    pub fn is_shadow_catcher(&self, hit: &Hit) -> bool {
        !self.shadow_catchers.is_empty() && self.shadow_catchers.contains(self.primitive_id(hit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_primitives_are_one_range() {
        let mut catchers = ShadowCatchers::default();
        assert!(catchers.is_empty() && !catchers.contains(0));
        [2, 3, 4, 9].into_iter().for_each(|id| catchers.add(id));
        assert_eq!(catchers.ranges, [(2, 5), (9, 10)]);
        assert_eq!((0..12).filter(|id| catchers.contains(*id)).collect::<Vec<_>>(), [2, 3, 4, 9]);
    }
}
