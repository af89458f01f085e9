//! The colour spaces of FLIP, sections 4.1.1 and 4.1.2 of the paper of 2020.

use crate::math::elementary::{cbrt, pow};

type Matrix = [[f64; 3]; 3];

/// Linear sRGB to CIE XYZ from the primaries and white of IEC 61966-2-1, as exact fractions.
const TO_XYZ: Matrix = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

fn multiply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// The inverse by cofactors.
fn inverse(m: &Matrix) -> Matrix {
    let cofactor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let det: f64 = (0..3).map(|c| m[0][c] * cofactor(0, c)).sum();
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| cofactor(c, r) / det))
}

/// XYZ relative to white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (multiply(&TO_XYZ, rgb), multiply(&TO_XYZ, [1.0; 3]));
    [xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]]
}

/// The opponent colours YyCxCz of linear RGB: lightness without the cube root, red-green, blue-yellow.
pub(super) fn opponent(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear RGB of opponent colours.
pub(super) struct FromOpponent(Matrix);

impl FromOpponent {
    pub(super) fn new() -> FromOpponent {
        FromOpponent(inverse(&TO_XYZ))
    }

    /// Clamped to 0..=1.
    pub(super) fn rgb(&self, [yy, cx, cz]: [f64; 3]) -> [f64; 3] {
        let white = multiply(&TO_XYZ, [1.0; 3]);
        let y = (yy + 16.0) / 116.0;
        let xyz = [(y + cx / 500.0) * white[0], y * white[1], (y - cz / 200.0) * white[2]];
        multiply(&self.0, xyz).map(|v| v.clamp(0.0, 1.0))
    }
}

/// CIE 1976 L*a*b*.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lab {
    l: f64,
    a: f64,
    b: f64,
}

impl Lab {
    /// From linear RGB, with the Hunt effect: colours of dark pixels count less, a and b are multiplied by L / 100.
    pub(super) fn hunt(rgb: [f64; 3]) -> Lab {
        const DELTA: f64 = 6.0 / 29.0;
        let root = |t: f64| {
            if t > DELTA * DELTA * DELTA { cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
        };
        let [x, y, z] = relative_xyz(rgb).map(root);
        let l = 116.0 * y - 16.0;
        Lab { l, a: 0.01 * l * 500.0 * (x - y), b: 0.01 * l * 200.0 * (y - z) }
    }

    /// The HyAB distance (Abasi, Amani Tehran and Fairchild 2020): |ΔL| plus the Euclidean distance in a and b.
    pub(super) fn hyab(self, o: Lab) -> f64 {
        let (a, b) = (self.a - o.a, self.b - o.b);
        (self.l - o.l).abs() + (a * a + b * b).sqrt()
    }
}

/// Maps distances to 0..=1 (eq. 8 to 10): they are compressed by a power, and those below 0.4 of the largest
/// get 95 % of the range.
pub(super) struct Scale {
    /// The largest compressed distance: that between green and blue.
    pub(super) largest: f64,
}

impl Scale {
    const POWER: f64 = 0.7;
    const BEND: f64 = 0.4;
    const AT_BEND: f64 = 0.95;

    pub(super) fn new() -> Scale {
        let distance = Lab::hunt([0.0, 1.0, 0.0]).hyab(Lab::hunt([0.0, 0.0, 1.0]));
        Scale { largest: pow(distance, Scale::POWER) }
    }

    pub(super) fn redistributed(&self, distance: f64) -> f64 {
        let (c, bend) = (pow(distance, Scale::POWER), Scale::BEND * self.largest);
        if c < bend {
            Scale::AT_BEND / bend * c
        } else {
            let beyond = (c - bend) / (self.largest - bend);
            (Scale::AT_BEND + beyond * (1.0 - Scale::AT_BEND)).min(1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opponent_colours_and_back() {
        let from = FromOpponent::new();
        for rgb in [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.75], [1.0, 0.0, 0.0]] {
            let back = from.rgb(opponent(rgb));
            assert!(back.iter().zip(rgb).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
        }
        // White has no colour; its Y is 100.
        let [y, cx, cz] = opponent([1.0; 3]);
        assert!((y - 100.0).abs() < 1e-12 && cx.abs() < 1e-12 && cz.abs() < 1e-12);
    }

    #[test]
    fn lab_of_red() {
        // L* 53.24, a* 80.09, b* 67.20 in tables; a and b times 0.5324.
        let red = Lab::hunt([1.0, 0.0, 0.0]);
        assert!((red.l - 53.24).abs() < 0.01 && (red.a / 0.5324 - 80.09).abs() < 0.02, "{red:?}");
        assert!((red.b / 0.5324 - 67.2).abs() < 0.02, "{red:?}");
    }

    #[test]
    fn the_scale_ends_at_one() {
        let scale = Scale::new();
        assert_eq!(scale.redistributed(0.0), 0.0);
        let distance = pow(scale.largest, 1.0 / 0.7);
        assert!((scale.redistributed(distance) - 1.0).abs() < 1e-12);
        let bend = pow(0.4 * scale.largest, 1.0 / 0.7);
        assert!((scale.redistributed(bend) - 0.95).abs() < 1e-9);
    }
}
