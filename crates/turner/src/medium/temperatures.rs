//! The glow of hot gas: a grid of temperatures, each with the colour of a black body.

use std::sync::Arc;

use crate::color::cie::black_body;
use crate::math::DVec3;
use crate::schema::GridData;

/// Number of temperatures of the table of colours, besides 0.
const STEPS: usize = 2048;

/// A grid of temperatures in a box, prepared.
#[derive(Clone, Debug)]
pub(super) struct Temperatures {
    grid: Arc<GridData>,
    /// World to cell coordinates: (p − min) · scale.
    min: DVec3,
    scale: DVec3,
    /// A value of the grid less `offset`, times `rate`, is a position in the table.
    offset: f64,
    rate: f64,
    /// Colours of temperatures from 0 on, in equal steps.
    colors: Arc<[[f32; 3]]>,
}

impl Temperatures {
    /// Values less `offset`, times `kelvin`, are temperatures.
    pub(super) fn new(
        grid: &Arc<GridData>,
        [min, max]: [DVec3; 2],
        offset: f64,
        kelvin: f64,
    ) -> Temperatures {
        let most = grid.density().iter().copied().fold(0.0f32, f32::max);
        let hottest = ((f64::from(most) - offset) * kelvin).clamp(1.0, 1e7);
        let color = |i: usize| black_body(hottest * i as f64 / STEPS as f64).to_array();
        let cells = DVec3::from(grid.size().map(f64::from));
        Temperatures {
            grid: Arc::clone(grid),
            min,
            scale: cells / (max - min),
            offset,
            rate: kelvin * STEPS as f64 / hottest,
            colors: (0..=STEPS).map(color).collect(),
        }
    }

    /// The colour at a point: black outside the box.
    pub(super) fn color_at(&self, p: DVec3) -> [f64; 3] {
        let p = (p - self.min) * self.scale;
        let cells = DVec3::from(self.grid.size().map(f64::from));
        if !(p.cmpge(DVec3::ZERO).all() && p.cmple(cells).all()) {
            return [0.0; 3];
        }
        let at = ((self.grid.at(p)[0] - self.offset) * self.rate).clamp(0.0, STEPS as f64);
        let low = (at as usize).min(STEPS - 1);
        let part = at - low as f64;
        [0, 1, 2].map(|i| {
            let [a, b] = [low, low + 1].map(|k| f64::from(self.colors[k][i]));
            a + (b - a) * part
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_glow_in_the_colour_of_their_temperature() {
        let grid = Arc::new(GridData::new([3, 1, 1], vec![16.0, 31.0, 1.0], None).unwrap());
        let bounds = [DVec3::ZERO, DVec3::new(6.0, 2.0, 2.0)];
        let hot = Temperatures::new(&grid, bounds, 1.0, 100.0);
        for (x, kelvin) in [(1.0, 1500.0), (3.0, 3000.0), (2.0, 2250.0)] {
            let seen = hot.color_at(DVec3::new(x, 1.0, 1.0));
            let exact = black_body(kelvin).to_array();
            for (a, b) in seen.into_iter().zip(exact) {
                assert!(
                    (a - f64::from(b)).abs() < 1e-3 * f64::from(b) + 1e-9,
                    "{kelvin}: {seen:?} {exact:?}"
                );
            }
        }
        assert_eq!(hot.color_at(DVec3::new(5.0, 1.0, 1.0)), [0.0; 3]);
        assert_eq!(hot.color_at(DVec3::new(3.0, 2.5, 1.0)), [0.0; 3]);
    }
}
