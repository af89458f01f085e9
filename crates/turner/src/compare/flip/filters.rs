//! The filters of FLIP: contrast sensitivity (section 4.1.1), edges and points (section 4.2).

use std::f64::consts::PI;
use std::ops::Range;

use super::super::kernel::{Border, Kernel, Plane};
use super::color::{FromOpponent, opponent};
use crate::math::elementary::exp;

/// Table 1: amplitude a and width b of the Gaussians a·√(π/b)·exp(−π²x²/b), x in degrees, that approximate the
/// contrast sensitivity for each opponent colour.
const ACHROMATIC: (f64, f64) = (1.0, 0.0047);
const RED_GREEN: (f64, f64) = (1.0, 0.0053);
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// The widest Gaussian sets the radius of all kernels.
const WIDEST: f64 = 0.04;
/// Width of the detected features, degrees.
const FEATURE: f64 = 0.082;

/// The filters for one viewing distance.
pub(super) struct Filters {
    achromatic: Kernel,
    red_green: Kernel,
    /// Two Gaussians with their weights, which sum to 1.
    blue_yellow: [(f64, Kernel); 2],
    smooth: Kernel,
    edge: Kernel,
    point: Kernel,
    /// The largest radius.
    halo: usize,
    from_opponent: FromOpponent,
}

impl Filters {
    pub(super) fn new(pixels_per_degree: f64) -> Filters {
        // Three standard deviations.
        let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
        let gaussian = |b: f64| {
            Kernel::new(radius, |i| {
                let x = i / pixels_per_degree;
                exp(-PI * PI * x * x / b)
            })
        };
        // In two dimensions the sum of a kernel is squared.
        let sums = BLUE_YELLOW.map(|(a, b)| {
            let sum: f64 = gaussian(b).0.iter().sum();
            a * (PI / b).sqrt() * sum * sum
        });
        let share = |i: usize| sums[i] / (sums[0] + sums[1]);

        let sigma = 0.5 * FEATURE * pixels_per_degree;
        let reach = (3.0 * sigma).ceil() as usize;
        let bell = |i: f64| exp(-i * i / (2.0 * sigma * sigma));
        Filters {
            achromatic: gaussian(ACHROMATIC.1).normalised(),
            red_green: gaussian(RED_GREEN.1).normalised(),
            blue_yellow: [0, 1].map(|i| (share(i), gaussian(BLUE_YELLOW[i].1).normalised())),
            smooth: Kernel::new(reach, bell).normalised(),
            edge: Kernel::new(reach, |i| -i * bell(i)).balanced(),
            point: Kernel::new(reach, |i| (i * i / (sigma * sigma) - 1.0) * bell(i)).balanced(),
            halo: radius.max(reach),
            from_opponent: FromOpponent::new(),
        }
    }

    /// The filtered rows of an image whose linear RGB is `at(x, y)`.
    pub(super) fn response(
        &self,
        size @ (width, _): (usize, usize),
        rows: Range<usize>,
        at: impl Fn(usize, usize) -> [f64; 3],
    ) -> Response {
        const EDGE: Border = Border::Clamp;
        // A plane of pixel indices, so that each pixel's colour is computed once.
        let places = Plane::new(size, rows, self.halo, EDGE, |x, y| (y * width + x) as f64);
        let mut band: [Plane; 3] = [0, 1, 2].map(|_| places.map(|_| 0.0));
        for (i, place) in places.values.iter().enumerate() {
            let place = *place as usize;
            let color = opponent(at(place % width, place / width));
            band.iter_mut().zip(color).for_each(|(band, v)| band.values[i] = v);
        }
        let both = |p: &Plane, k: &Kernel, l: &Kernel| p.along_x(k, EDGE).along_y(l, self.halo);
        let [y, cx, cz] = &band;
        let [narrow, wide] = [0, 1].map(|i| {
            let (share, kernel) = &self.blue_yellow[i];
            both(cz, kernel, kernel).map(|v| v * share)
        });
        let blue_yellow = narrow.values.iter().zip(&wide.values).map(|(a, b)| a + b).collect();
        let filtered = [
            both(y, &self.achromatic, &self.achromatic).values,
            both(cx, &self.red_green, &self.red_green).values,
            blue_yellow,
        ];
        let grey = y.map(|v| (v + 16.0) / 116.0);
        let strength = |k: &Kernel| -> Vec<f64> {
            let (x, y) = (both(&grey, k, &self.smooth), both(&grey, &self.smooth, k));
            x.values.iter().zip(&y.values).map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        let (edges, points) = (strength(&self.edge), strength(&self.point));
        let colors = (0..edges.len())
            .map(|i| self.from_opponent.rgb([filtered[0][i], filtered[1][i], filtered[2][i]]))
            .collect();
        Response { colors, edges, points }
    }
}

/// A filtered image, pixel by pixel.
pub(super) struct Response {
    /// Linear RGB after the contrast sensitivity filter.
    colors: Vec<[f64; 3]>,
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Response {
    pub(super) fn filtered(&self, i: usize) -> [f64; 3] {
        self.colors[i]
    }

    /// Eq. 14: the larger difference of edges and points, 0 to 1.
    pub(super) fn feature_difference(&self, o: &Response, i: usize) -> f64 {
        let edge = (self.edges[i] - o.edges[i]).abs();
        let point = (self.points[i] - o.points[i]).abs();
        (edge.max(point) * std::f64::consts::FRAC_1_SQRT_2).sqrt().min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_pictures_stay_and_have_no_features() {
        let filters = Filters::new(super::super::PIXELS_PER_DEGREE);
        assert_eq!((filters.halo, filters.achromatic.0.len(), filters.edge.0.len()), (10, 21, 19));
        let color = [0.2, 0.5, 0.7];
        let found = filters.response((15, 9), 2..6, |_, _| color);
        assert_eq!(found.colors.len(), 60);
        for (i, rgb) in found.colors.iter().enumerate() {
            assert!(rgb.iter().zip(color).all(|(a, b)| (a - b).abs() < 1e-12));
            assert!(found.edges[i] < 1e-12 && found.points[i] < 1e-12);
        }
    }

    #[test]
    fn a_step_is_an_edge() {
        let filters = Filters::new(super::super::PIXELS_PER_DEGREE);
        let found = filters.response((40, 5), 0..5, |x, _| [if x < 20 { 0.0 } else { 1.0 }; 3]);
        // Next to the step all weights of one sign see white; they sum to 1 or −1. The central weight is 0.
        let most = found.edges.iter().copied().fold(0.0, f64::max);
        assert!((most - 1.0).abs() < 1e-9, "{most}");
        assert!(found.edges[0] < 1e-12 && found.edges[39] < 1e-12);
    }
}
