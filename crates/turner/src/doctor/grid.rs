//! The pixels of the probe.

use crate::doctor::subject::Subject;
use crate::sampler::SampleId;

/// A pixel of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pixel {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
}

/// About `count` pixels of a rectangle `[x, y, width, height]`, and the columns and rows of their grid. The pixels are
/// jittered within the cells of the grid, so that regular patterns do not alias.
pub(super) fn pixels([x0, y0, width, height]: [u32; 4], count: u32) -> (Vec<Pixel>, [u32; 2]) {
    let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
    let columns =
        ((f64::from(count) * aspect).sqrt().round() as u32).clamp(1, width.max(1)).min(count.max(1));
    let rows = (count / columns).clamp(1, height.max(1));
    let mut out = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let jitter = SampleId { x: column, y: row, index: 0, seed: 0x646f_6374 }.unit_square(0);
            let position = |i: u32, n: u32, size: u32, u: f64| {
                let at = (f64::from(i) + u) / f64::from(n) * f64::from(size);
                (at as u32).min(size.saturating_sub(1))
            };
            out.push(Pixel {
                x: x0 + position(column, columns, width, jitter.x),
                y: y0 + position(row, rows, height, jitter.y),
            });
        }
    }
    (out, [columns, rows])
}

impl Pixel {
    /// Its sample with the given index.
    pub(super) fn sample(&self, scene: &Subject, index: u32) -> SampleId {
        SampleId { x: self.x, y: self.y, index, seed: u64::from(scene.film().seed) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_lie_in_their_rectangle_and_apart() {
        for rect in [[0, 0, 640, 480], [10, 20, 3, 2], [5, 5, 1, 1], [0, 0, 1, 900], [0, 0, 900, 1]] {
            let (pixels, [columns, rows]) = pixels(rect, 432);
            assert_eq!(pixels.len(), (columns * rows) as usize);
            assert!(!pixels.is_empty() && pixels.len() <= 500, "{rect:?}: {}", pixels.len());
            let [x, y, width, height] = rect;
            for p in &pixels {
                assert!((x..x + width).contains(&p.x) && (y..y + height).contains(&p.y), "{rect:?} {p:?}");
            }
        }
    }
}
