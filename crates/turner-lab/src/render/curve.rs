//! Error over time: the time to reach a given error.

use turner::math::elementary::{exp, ln};

/// A measurement at one sample count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// Seconds.
    pub(super) seconds: f64,
    /// Relative mean square error, minus the reference's own.
    pub(super) error: f64,
}

/// The time to reach an error, read off a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    /// Seconds.
    pub(super) seconds: f64,
    /// Whether the error is within the measured range; otherwise the time is extrapolated.
    pub(super) measured: bool,
}

/// Seconds until the error is `target`: interpolated linearly in logarithms between measured points; beyond them,
/// extrapolated with the least-squares line through the nearest three. `None` with fewer than two points or if errors
/// do not fall.
pub(super) fn seconds_to(points: &[Point], target: f64) -> Option<Reach> {
    let usable = |p: &&Point| p.error > 0.0 && p.seconds > 0.0;
    let mut logs: Vec<(f64, f64)> =
        points.iter().filter(usable).map(|p| (ln(p.seconds), ln(p.error))).collect();
    logs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let target = ln(target);
    // The last crossing: later points are below the target.
    let crossing = logs.windows(2).rev().find_map(|pair| match pair {
        [a, b] if a.1 >= target && b.1 <= target && a.1 > b.1 => {
            Some(a.0 + (b.0 - a.0) * (a.1 - target) / (a.1 - b.1))
        }
        _ => None,
    });
    if let Some(seconds) = crossing {
        return Some(Reach { seconds: exp(seconds), measured: true });
    }
    let above = logs.iter().all(|p| p.1 > target);
    let near = if above { &logs[logs.len().saturating_sub(3)..] } else { &logs[..logs.len().min(3)] };
    let (slope, offset) = line(near)?;
    (slope < 0.0).then(|| Reach { seconds: exp((target - offset) / slope), measured: false })
}

/// Slope and offset of the least-squares line.
fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / spread;
    (points.len() > 1 && slope.is_finite()).then_some((slope, y - slope * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(count: i32) -> Vec<Point> {
        let times = (0..count).map(|k| f64::from(1 << k));
        times.map(|t| Point { seconds: 0.1 * t, error: 0.08 / t }).collect()
    }

    #[test]
    fn errors_that_fall_as_one_over_time_are_found_within_and_beyond() {
        // error * seconds is 0.008.
        for (target, measured) in [(0.01, true), (0.0001, false), (0.5, false)] {
            let found = seconds_to(&curve(5), target).unwrap();
            assert!((found.seconds * target / 0.008 - 1.0).abs() < 1e-9, "{found:?}");
            assert_eq!(found.measured, measured, "{target}");
        }
    }

    #[test]
    fn curves_that_do_not_fall_give_none() {
        assert_eq!(seconds_to(&[], 0.01), None);
        assert_eq!(seconds_to(&curve(1), 0.01), None);
        // Errors below the reference's own noise can be negative.
        let noise = [Point { seconds: 1.0, error: 0.02 }, Point { seconds: 2.0, error: -0.001 }];
        assert_eq!(seconds_to(&noise, 0.01), None);
        let rising = [Point { seconds: 1.0, error: 0.02 }, Point { seconds: 2.0, error: 0.03 }];
        assert_eq!(seconds_to(&rising, 0.01), None);
    }
}
