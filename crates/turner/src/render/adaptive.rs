//! Whitted's adaptive anti-aliasing: rays through the corners of a square; where their values differ, the square
//! is divided.
//!
//! Whitted 1980, §"Antialiasing". The value of a pixel is the mean of its four corners if they differ by at most
//! `threshold`, otherwise the mean of its four quarters, computed in the same way.
//!
//! ```text
//! ●───────●       ●───●───●      ● ray; at most 2^max_subdivisions cells along the side of a pixel
//! │       │  ──►  │   │   │
//! │       │       ●───●───●
//! │       │       │   │   │
//! ●───────●       ●───●───●
//! ```
//!
//! A corner's sample id is its position on the finest grid over the picture. So a corner has the same value for
//! every pixel that it belongs to, in any tile.

use super::tile::TileBuffers;
use super::work::Stop;
use crate::film::PixelRect;
use crate::integrator::Radiance;
use crate::math::DVec2;
use crate::sampler::SampleId;

/// The known corner values of one pixel, on the finest grid.
struct PixelGrid {
    /// Corners per side, 2^max_subdivisions + 1.
    side: usize,
    values: Vec<Option<Radiance>>,
    /// The position of the pixel's top left corner on the finest grid of the picture.
    x: u32,
    y: u32,
}

impl TileBuffers<'_> {
    /// Renders a tile. Returns false if it was stopped.
    pub(super) fn render_adaptive(&mut self, tile: &PixelRect, stop: Stop<'_>) -> bool {
        let film = &self.p.view.film;
        let cells = 1u32 << film.max_subdivisions;
        let point = |x: u32, y: u32| {
            let id = SampleId { x, y, index: 0, seed: u64::from(film.seed) };
            (id, DVec2::new(f64::from(x), f64::from(y)) / f64::from(cells))
        };
        let columns = tile.width + 1;
        let corners = (0..tile.height + 1)
            .flat_map(|row| (0..columns).map(move |column| (tile.x + column, tile.y + row)))
            .map(|(x, y)| point(x * cells, y * cells));
        let corners: Vec<Radiance> = self.trace_points(corners).to_vec();

        let side = cells as usize + 1;
        let mut grid = PixelGrid { side, values: vec![None; side * side], x: 0, y: 0 };
        for row in 0..tile.height {
            for column in 0..tile.width {
                if stop.is_set() {
                    return false;
                }
                let (x, y) = (tile.x + column, tile.y + row);
                grid.values.fill(None);
                (grid.x, grid.y) = (x * cells, y * cells);
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let corner = corners[((row + dy) * columns + column + dx) as usize];
                    grid.values[dy as usize * (side - 1) * side + dx as usize * (side - 1)] = Some(corner);
                }
                let mean =
                    self.square(&mut grid, 0, 0, cells as usize, f64::from(film.threshold as f32), &point);
                self.pixels.push(mean);
            }
        }
        self.check_pixels(tile);
        true
    }

    /// The mean over the square of `size` cells at (`cx`, `cy`) of a pixel. The recursion is at most
    /// `max_subdivisions` deep.
    #[allow(clippy::too_many_arguments)]
    fn square(
        &mut self,
        grid: &mut PixelGrid,
        cx: usize,
        cy: usize,
        size: usize,
        threshold: f64,
        point: &impl Fn(u32, u32) -> (SampleId, DVec2),
    ) -> Radiance {
        let at = |x: usize, y: usize| y * grid.side + x;
        let corners = [at(cx, cy), at(cx + size, cy), at(cx, cy + size), at(cx + size, cy + size)];
        let values = corners.map(|i| grid.values[i].unwrap_or_default());
        if size == 1 || spread(&values) <= threshold {
            if let Some(log) = &mut self.log {
                let corner = [grid.x + cx as u32, grid.y + cy as u32];
                log.squares.push((corner, size as u32, spread(&values)));
            }
            return mean(&values);
        }
        let half = size / 2;
        let missing: Vec<(usize, usize)> = [(half, 0), (0, half), (half, half), (size, half), (half, size)]
            .into_iter()
            .map(|(x, y)| (cx + x, cy + y))
            .filter(|(x, y)| grid.values[at(*x, *y)].is_none())
            .collect();
        let (gx, gy) = (grid.x, grid.y);
        let traced = self.trace_points(missing.iter().map(|(x, y)| point(gx + *x as u32, gy + *y as u32)));
        for ((x, y), value) in missing.iter().zip(traced) {
            grid.values[y * grid.side + x] = Some(*value);
        }
        let quarters = [(0, 0), (half, 0), (0, half), (half, half)]
            .map(|(x, y)| self.square(grid, cx + x, cy + y, half, threshold, point));
        mean(&quarters)
    }
}

/// The largest difference of the four values in any channel.
fn spread(values: &[Radiance; 4]) -> f64 {
    let channels = values.map(|v| [v.color.r, v.color.g, v.color.b, v.alpha]);
    (0..4)
        .map(|c| {
            let (low, high) = channels
                .iter()
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v[c]), h.max(v[c])));
            f64::from(high - low)
        })
        .fold(0.0, f64::max)
}

fn mean(values: &[Radiance; 4]) -> Radiance {
    let [a, b, c, d] = values;
    Radiance {
        color: (a.color + b.color + c.color + d.color) * 0.25,
        alpha: (a.alpha + b.alpha + c.alpha + d.alpha) * 0.25,
    }
}
