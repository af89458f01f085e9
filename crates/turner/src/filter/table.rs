//! Half of an even filter as a table: its density in straight pieces, inverted exactly.

/// Pieces over 0..=1 radii: the pieces differ from either bell by 1e-4 of its height at most.
const PIECES: usize = 128;

/// A density on 0..=1 that is linear between `PIECES` + 1 places.
#[derive(Clone, Debug)]
pub(super) struct Table {
    /// The density at each place; its integral is 1.
    density: [f64; PIECES + 1],
    /// The distribution function there.
    sums: [f64; PIECES + 1],
}

impl Table {
    /// Of a function that is positive before 1, and never negative.
    pub(super) fn new(f: impl Fn(f64) -> f64) -> Table {
        let step = 1.0 / PIECES as f64;
        let mut density = [0.0; PIECES + 1];
        for (i, d) in density.iter_mut().enumerate() {
            *d = f(i as f64 * step);
        }
        let mut sums = [0.0; PIECES + 1];
        for i in 0..PIECES {
            sums[i + 1] = sums[i] + 0.5 * step * (density[i] + density[i + 1]);
        }
        let total = sums[PIECES];
        density.iter_mut().for_each(|d| *d /= total);
        sums.iter_mut().for_each(|s| *s /= total);
        sums[PIECES] = 1.0;
        Table { density, sums }
    }

    /// The place up to which the share `u` of the whole lies; 0..=1 for any `u`.
    #[inline]
    pub(super) fn invert(&self, u: f64) -> f64 {
        let piece = self.sums[1..PIECES].partition_point(|sum| *sum <= u);
        let (from, to) = (self.density[piece], self.density[piece + 1]);
        let step = 1.0 / PIECES as f64;
        // from·x + (to − from)·x²/2 = rest, x in pieces: the root that stays exact as the slope goes to 0.
        let rest = (u - self.sums[piece]).max(0.0) / step;
        let root = (from * from + 2.0 * (to - from) * rest).max(0.0).sqrt();
        let sum = from + root;
        let x = if sum > 0.0 { 2.0 * rest / sum } else { 0.0 };
        (piece as f64 + x.min(1.0)) * step
    }

    /// The density at `x` of 0..=1.
    pub(super) fn density(&self, x: f64) -> f64 {
        let piece = ((x * PIECES as f64) as usize).min(PIECES - 1);
        let t = x * PIECES as f64 - piece as f64;
        self.density[piece] * (1.0 - t) + self.density[piece + 1] * t
    }
}
