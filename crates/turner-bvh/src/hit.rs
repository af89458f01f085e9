//! The result of an intersection query.

/// The hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter; infinite for a miss.
    pub t: f32,
    /// Barycentric weight of the second vertex, 0 to 1.
    pub u: f32,
    /// Barycentric weight of the third vertex. The first vertex has `1 - u - v`.
    pub v: f32,
    /// Index of the triangle; [`Hit::NONE`] for a miss.
    pub primitive: u32,
}

impl Hit {
    /// The primitive index of a miss.
    pub const NONE: u32 = u32::MAX;

    /// A miss.
    pub const MISS: Hit = Hit { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: Hit::NONE };

    /// Whether this is a hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.primitive != Hit::NONE
    }

    /// `None` for a miss.
    #[inline]
    pub fn some(self) -> Option<Hit> {
        self.is_hit().then_some(self)
    }
}

impl Default for Hit {
    fn default() -> Hit {
        Hit::MISS
    }
}
