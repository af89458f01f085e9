//! Corner tables: corner 3f + k is corner k of face f. Two corners are opposite if their faces share the edge that
//! they face.

/// No corner, vertex or entry.
pub(super) const NONE: u32 = u32::MAX;

/// The next corner of the same face, counter-clockwise.
#[inline]
pub(super) fn next(corner: u32) -> u32 {
    if corner == NONE {
        NONE
    } else if corner % 3 == 2 {
        corner - 2
    } else {
        corner + 1
    }
}

/// The corner before, counter-clockwise.
#[inline]
pub(super) fn previous(corner: u32) -> u32 {
    if corner == NONE {
        NONE
    } else if corner.is_multiple_of(3) {
        corner + 2
    } else {
        corner - 1
    }
}

/// An element; `NONE` if there is none.
#[inline]
pub(super) fn at(list: &[u32], i: u32) -> u32 {
    list.get(i as usize).copied().unwrap_or(NONE)
}

/// Sets an element, if there is one.
#[inline]
pub(super) fn put(list: &mut [u32], i: u32, value: u32) {
    if let Some(slot) = list.get_mut(i as usize) {
        *slot = value;
    }
}

/// The connectivity of a mesh, or that of an attribute, whose seams are boundaries.
///
/// Opposite corners are mutual, so the corners around a vertex form a chain or a ring.
#[derive(Debug, Default)]
pub(super) struct Corners {
    /// The vertex of each corner.
    pub(super) vertex: Vec<u32>,
    /// The opposite corner of each corner; `NONE` at a boundary.
    pub(super) opposite: Vec<u32>,
    /// A corner of each vertex, at a boundary the leftmost; `NONE` if the vertex is unused.
    pub(super) leftmost: Vec<u32>,
}

impl Corners {
    #[inline]
    pub(super) fn vertex(&self, corner: u32) -> u32 {
        at(&self.vertex, corner)
    }

    #[inline]
    pub(super) fn opposite(&self, corner: u32) -> u32 {
        at(&self.opposite, corner)
    }

    /// The corner to the left around the same vertex: clockwise seen from the vertex's face.
    #[inline]
    pub(super) fn swing_left(&self, corner: u32) -> u32 {
        next(self.opposite(next(corner)))
    }

    /// The corner to the right around the same vertex.
    #[inline]
    pub(super) fn swing_right(&self, corner: u32) -> u32 {
        previous(self.opposite(previous(corner)))
    }

    /// Whether a vertex lies at a boundary.
    #[inline]
    pub(super) fn is_at_boundary(&self, vertex: u32) -> bool {
        self.swing_left(at(&self.leftmost, vertex)) == NONE
    }

    /// All corners around the vertex of a corner, which is the first: to the left until the end of a chain, then to
    /// the right.
    pub(super) fn around(&self, first: u32) -> Around<'_> {
        Around { corners: self, first, at: first, to_left: true }
    }
}

/// See [`Corners::around`].
#[derive(Debug)]
pub(super) struct Around<'a> {
    corners: &'a Corners,
    first: u32,
    at: u32,
    to_left: bool,
}

impl Iterator for Around<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        let corner = self.at;
        if corner == NONE {
            return None;
        }
        if self.to_left {
            self.at = self.corners.swing_left(corner);
            if self.at == NONE {
                self.to_left = false;
                self.at = self.corners.swing_right(self.first);
            } else if self.at == self.first {
                self.at = NONE;
            }
        } else {
            self.at = self.corners.swing_right(corner);
        }
        Some(corner)
    }
}
