//! Half of an even filter as a table: a piecewise linear density with an exact inverse.

/// Number of linear pieces over 0..=1 radii; they differ from either bell by at most 1e-4 of its height.
const PIECES: usize = 128;

/// A density on 0..=1 that is linear between `PIECES` + 1 nodes.
#[derive(Clone, Debug)]
pub(super) struct Table {
    /// The density at each node; its integral is 1.
    density: [f64; PIECES + 1],
    /// The cumulative distribution function at each node.
    sums: [f64; PIECES + 1],
}

impl Table {
    /// Tabulates a function that is non-negative, and positive before 1.
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

    /// The inverse distribution function; within 0..=1 for any `u`.
    #[inline]
    pub(super) fn invert(&self, u: f64) -> f64 {
        let piece = self.sums[1..PIECES].partition_point(|sum| *sum <= u);
        let (from, to) = (self.density[piece], self.density[piece + 1]);
        let step = 1.0 / PIECES as f64;
        // Solve from·x + (to − from)·x²/2 = rest, x in pieces; this form of the root is stable as the slope goes to 0.
        let rest = (u - self.sums[piece]).max(0.0) / step;
        let root = (from * from + 2.0 * (to - from) * rest).max(0.0).sqrt();
        let sum = from + root;
        let x = if sum > 0.0 { 2.0 * rest / sum } else { 0.0 };
        (piece as f64 + x.min(1.0)) * step
    }

    /// The distribution function at `x` of 0..=1.
    pub(super) fn sum(&self, x: f64) -> f64 {
        let piece = ((x * PIECES as f64) as usize).min(PIECES - 1);
        let t = x * PIECES as f64 - piece as f64;
        let (from, to) = (self.density[piece], self.density[piece + 1]);
        self.sums[piece] + (from * t + 0.5 * (to - from) * t * t) / PIECES as f64
    }

    /// The density at `x` of 0..=1.
    #[inline]
    pub(super) fn density(&self, x: f64) -> f64 {
        let piece = ((x * PIECES as f64) as usize).min(PIECES - 1);
        let t = x * PIECES as f64 - piece as f64;
        self.density[piece] * (1.0 - t) + self.density[piece + 1] * t
    }
}
