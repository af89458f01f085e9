//! Colour spaces of display values: primaries and curves of displays.
//!
//! Scene values have the primaries of Rec. 709 and sRGB with the white point D65. The matrices follow from the
//! chromaticities of the primaries: SMPTE EG 432-1 for P3, ITU-R BT.2020 (with the matrix of BT.2087).

use super::{Spectrum, srgb_encode};
use crate::choice::choice;
use crate::math::elementary::pow;

choice! {
    /// The colour space of the display values of a picture.
    pub enum DisplaySpace {
        /// sRGB: primaries of Rec. 709, the curve of IEC 61966-2-1. What every program assumes.
        Srgb = "srgb",
        /// Display P3: the wider primaries of current phones and laptops, with the curve of sRGB.
        DisplayP3 = "display-p3",
        /// Rec. 2100 PQ: the primaries of BT.2020 and the curve of SMPTE ST 2084, for HDR displays; 1 becomes 203 cd/m².
        Rec2100Pq = "rec2100-pq",
    }
}

/// The luminance of the display value 1 in [`DisplaySpace::Rec2100Pq`], in cd/m²: the reference white of ITU-R BT.2408.
pub const REFERENCE_WHITE: f64 = 203.0;

/// The luminance of the largest PQ value, in cd/m².
const PQ_PEAK: f64 = 10_000.0;

const P3: [[f64; 3]; 3] = [
    [0.822_461_968_714_362, 0.177_538_031_285_638, 0.0],
    [0.033_194_198_850_962, 0.966_805_801_149_038, 0.0],
    [0.017_082_630_721_120, 0.072_397_440_663_963, 0.910_519_928_614_916],
];

const BT2020: [[f64; 3]; 3] = [
    [0.627_403_895_934_699, 0.329_283_038_377_884, 0.043_313_065_687_417],
    [0.069_097_289_358_232, 0.919_540_395_075_459, 0.011_362_315_566_309],
    [0.016_391_438_875_150, 0.088_013_307_877_226, 0.895_595_253_247_624],
];

impl DisplaySpace {
    /// From linear Rec. 709 to the linear primaries of the space. NaN stays NaN.
    pub fn convert(self, color: Spectrum) -> Spectrum {
        let matrix = match self {
            DisplaySpace::Srgb => return color,
            DisplaySpace::DisplayP3 => &P3,
            DisplaySpace::Rec2100Pq => &BT2020,
        };
        // Infinity times 0 would be NaN.
        let v = color.to_array().map(|v| f64::from(v.clamp(-f32::MAX, f32::MAX)));
        Spectrum::from(matrix.map(|row| (row[0] * v[0] + row[1] * v[1] + row[2] * v[2]) as f32))
    }

    /// From a linear value to the display value, 0..=1. Values are clamped to what the space can show: 0..=1, with PQ
    /// 0 to 10,000 cd/m². NaN becomes 0.
    pub fn encode(self, v: f32) -> f32 {
        let v = if v > 0.0 { v } else { 0.0 };
        match self {
            DisplaySpace::Srgb | DisplaySpace::DisplayP3 => srgb_encode(v.min(1.0)),
            DisplaySpace::Rec2100Pq => pq_encode(f64::from(v) * REFERENCE_WHITE) as f32,
        }
    }

    /// Code points of ITU-T H.273 for primaries and transfer curve.
    pub fn code_points(self) -> [u8; 2] {
        match self {
            DisplaySpace::Srgb => [1, 13],
            DisplaySpace::DisplayP3 => [12, 13],
            DisplaySpace::Rec2100Pq => [9, 16],
        }
    }
}

/// The PQ curve of SMPTE ST 2084: from cd/m², clamped to 0..=10,000, to 0..=1.
pub fn pq_encode(luminance: f64) -> f64 {
    const M1: f64 = 2610.0 / 16384.0;
    const M2: f64 = 2523.0 / 4096.0 * 128.0;
    const C1: f64 = 3424.0 / 4096.0;
    const C2: f64 = 2413.0 / 4096.0 * 32.0;
    const C3: f64 = 2392.0 / 4096.0 * 32.0;
    let y = pow((luminance / PQ_PEAK).clamp(0.0, 1.0), M1);
    pow((C1 + C2 * y) / (1.0 + C3 * y), M2).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use DisplaySpace::{DisplayP3, Rec2100Pq, Srgb};

    /// Chromaticities x, y of red, green and blue.
    type Primaries = [[f64; 2]; 3];
    const REC_709: Primaries = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];
    const WHITE: [f64; 2] = [0.3127, 0.3290];

    fn xyz([x, y]: [f64; 2]) -> glam::DVec3 {
        glam::DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
    }

    /// From linear RGB to XYZ: the primaries are scaled so that their sum is white.
    fn to_xyz(primaries: Primaries) -> glam::DMat3 {
        let [r, g, b] = primaries.map(xyz);
        let m = glam::DMat3::from_cols(r, g, b);
        let scale = m.inverse() * xyz(WHITE);
        glam::DMat3::from_cols(r * scale.x, g * scale.y, b * scale.z)
    }

    #[test]
    fn matrices_follow_from_the_chromaticities() {
        let p3 = [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]];
        let bt2020 = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]];
        for (matrix, primaries) in [(P3, p3), (BT2020, bt2020)] {
            let expected = to_xyz(primaries).inverse() * to_xyz(REC_709);
            for (r, row) in matrix.iter().enumerate() {
                for (c, v) in row.iter().enumerate() {
                    assert!((v - expected.col(c)[r]).abs() < 1e-12, "{v} {}", expected.col(c)[r]);
                }
            }
        }
    }

    /// Table of ITU-R BT.2087.
    #[test]
    fn bt2020_is_the_published_matrix() {
        let published = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]];
        for (row, expected) in BT2020.iter().zip(published) {
            assert!(row.iter().zip(expected).all(|(v, e)| (v - e).abs() < 5e-5), "{row:?}");
        }
    }

    #[test]
    fn white_stays_white_and_every_colour_is_inside() {
        for space in [Srgb, DisplayP3, Rec2100Pq] {
            for v in space.convert(Spectrum::grey(1.0)).to_array() {
                assert!((v - 1.0).abs() < 1e-6, "{space:?}: {v}");
            }
            for color in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]] {
                let inside = space.convert(Spectrum::from(color)).to_array();
                assert!(inside.iter().all(|v| (0.0..=1.0).contains(v)), "{space:?}: {inside:?}");
            }
            let bright = space.convert(Spectrum::new(f32::INFINITY, 0.0, 0.0)).to_array();
            assert!(bright.iter().all(|v| !v.is_nan() && space.encode(*v) >= 0.0), "{bright:?}");
            assert_eq!(space.encode(f32::NAN), space.encode(0.0));
        }
    }

    /// Report ITU-R BT.2408: 100 cd/m² is 51 %, reference white 58 %, 1000 cd/m² 75 % of the signal.
    #[test]
    fn pq_is_the_published_curve() {
        for (luminance, expected) in [
            (0.0, 7.309_559e-7),
            (100.0, 0.508_078_4),
            (203.0, 0.580_688_8),
            (1000.0, 0.751_827_1),
            (10_000.0, 1.0),
            (1e9, 1.0),
        ] {
            let found = pq_encode(luminance);
            assert!((found - expected).abs() < 1e-6, "{luminance}: {found}");
        }
        assert!((Rec2100Pq.encode(1.0) - 0.580_689).abs() < 1e-6);
        assert_eq!(DisplayP3.encode(0.5), Srgb.encode(0.5));
    }
}
