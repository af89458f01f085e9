//! The size of preview frames: as large as the time allows.

use std::time::Duration;

/// The time of a preview frame that the user does not notice as a delay.
const TARGET: f64 = 0.070;
/// Sizes, as fractions of the largest.
const SCALES: [f64; 4] = [1.0, 0.75, 0.5, 0.25];

/// Chooses the size of preview frames by the time of the last ones.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// Index into [`SCALES`].
    step: usize,
    late: u32,
    early: u32,
}

impl Pace {
    /// The size of the next frame: that of the film reduced to fit `limit`, times the scale. At least 1 x 1.
    pub(super) fn size(&self, film: [u32; 2], limit: [u32; 2], moving: bool) -> [u32; 2] {
        let [w, h] = film.map(f64::from);
        let fit = (f64::from(limit[0].max(1)) / w).min(f64::from(limit[1].max(1)) / h).min(1.0);
        let scale = if moving { fit * SCALES[self.step] } else { fit };
        [w, h].map(|side| ((side * scale).round() as u32).max(1))
    }

    /// Learns from the time of a moving frame. Twice late: smaller. Eight times early enough for the next size: larger.
    pub(super) fn learn(&mut self, took: Duration) {
        let took = took.as_secs_f64();
        let larger = SCALES[self.step.saturating_sub(1)] / SCALES[self.step];
        if took > TARGET * 1.2 {
            (self.late, self.early) = (self.late + 1, 0);
        } else if took * larger * larger < TARGET {
            (self.late, self.early) = (0, self.early + 1);
        } else {
            (self.late, self.early) = (0, 0);
        }
        if (self.late >= 2 || took > 3.0 * TARGET) && self.step + 1 < SCALES.len() {
            *self = Pace { step: self.step + 1, ..Pace::default() };
        } else if self.early >= 8 && self.step > 0 {
            *self = Pace { step: self.step - 1, ..Pace::default() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_frames_get_smaller_and_fast_ones_larger_again() {
        let mut pace = Pace::default();
        assert_eq!(pace.size([1280, 720], [1280, 720], true), [1280, 720]);
        assert_eq!(pace.size([1280, 720], [640, 640], true), [640, 360]);
        pace.learn(Duration::from_millis(100));
        pace.learn(Duration::from_millis(100));
        assert_eq!(pace.size([1280, 720], [1280, 720], true), [960, 540]);
        assert_eq!(pace.size([1280, 720], [1280, 720], false), [1280, 720]);
        for _ in 0..8 {
            pace.learn(Duration::from_millis(20));
        }
        assert_eq!(pace.size([1280, 720], [1280, 720], true), [1280, 720]);
    }

    #[test]
    fn a_window_of_no_size_has_a_pixel() {
        assert_eq!(Pace::default().size([640, 480], [0, 0], true), [1, 1]);
        assert_eq!(Pace::default().size([65536, 1], [10, 10], true), [10, 1]);
    }
}
