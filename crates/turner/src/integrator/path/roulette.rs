//! Russian roulette: paths that carry little end at random (Arvo & Kirk 1990, "Particle transport and image synthesis").

use super::path_batch::Path;
use super::settings::Settings;

impl Path {
    /// After the first bounce: Russian roulette compares later throughputs with this one. Noise is seen relative to the
    /// brightness of a pixel, so paths from a dark surface matter as much as those from a white one, down to an albedo of
    /// a quarter.
    #[inline]
    pub(super) fn begin_roulette(&mut self) {
        /// Paths from darker surfaces end earlier: they would cost more than they are worth.
        const DARKEST: f32 = 0.25;
        if self.bounces.total == 1 {
            self.importance = 1.0 / (self.beta.max_component() * self.eta2).clamp(DARKEST, 1.0);
        }
    }
}

impl Settings {
    /// Survival probability of Russian roulette after a bounce; `None` before `rr_start` bounces.
    #[inline]
    pub(super) fn survival(&self, path: &Path) -> Option<f32> {
        (path.bounces.total >= self.rr_start).then(|| {
            let carried = path.beta.max_component() * path.importance * path.eta2;
            carried.max(0.0).sqrt().clamp(0.05, 1.0)
        })
    }
}
