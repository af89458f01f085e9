//! What a search finds.

/// The nearest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where along the ray; infinite if there is none.
    pub t: f32,
    /// Weight of the triangle's second corner, 0 to 1.
    pub u: f32,
    /// Weight of its third corner; the first one's is `1 - u - v`.
    pub v: f32,
    /// Number of the triangle; [`Hit::NONE`] if there is none.
    pub primitive: u32,
}

impl Hit {
    /// In place of a number: nothing.
    pub const NONE: u32 = u32::MAX;

    /// No hit.
    pub const MISS: Hit = Hit { t: f32::INFINITY, u: 0.0, v: 0.0, primitive: Hit::NONE };

    /// Whether there is a hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.primitive != Hit::NONE
    }

    /// The hit, if there is one.
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
