//! Display colours as they are seen with a colour vision deficiency.
//!
//! Machado, Oliveira and Fernandes 2009, "A physiologically-based model for simulation of color vision deficiency", table 1
//! with severity 1: matrices that act on linear RGB. The rows sum to 1, so greys stay grey.

use super::{srgb_decode, srgb_encode};

/// A kind of colour vision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vision {
    /// All three kinds of cones.
    #[default]
    Normal,
    /// Without the cones for long wavelengths: red is dark, and looks like green.
    Protanopia,
    /// Without the cones for middle wavelengths, the most frequent kind: green looks like red.
    Deuteranopia,
    /// Without the cones for short wavelengths: blue looks like green, yellow like pink.
    Tritanopia,
}

impl Vision {
    /// All kinds.
    pub const ALL: [Vision; 4] =
        [Vision::Normal, Vision::Protanopia, Vision::Deuteranopia, Vision::Tritanopia];

    /// The name.
    pub fn name(self) -> &'static str {
        match self {
            Vision::Normal => "normal colour vision",
            Vision::Protanopia => "protanopia",
            Vision::Deuteranopia => "deuteranopia",
            Vision::Tritanopia => "tritanopia",
        }
    }

    /// The matrix for linear RGB, row by row.
    pub fn matrix(self) -> [[f32; 3]; 3] {
        match self {
            Vision::Normal => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Vision::Protanopia => [
                [0.152_286, 1.052_583, -0.204_868],
                [0.114_503, 0.786_281, 0.099_216],
                [-0.003_882, -0.048_116, 1.051_998],
            ],
            Vision::Deuteranopia => [
                [0.367_322, 0.860_646, -0.227_968],
                [0.280_085, 0.672_501, 0.047_413],
                [-0.011_820, 0.042_940, 0.968_881],
            ],
            Vision::Tritanopia => [
                [1.255_528, -0.076_749, -0.178_779],
                [-0.078_411, 0.930_809, 0.147_602],
                [0.004_733, 0.691_367, 0.303_900],
            ],
        }
    }

    /// What turns sRGB bytes into those that show how they are seen. It holds a table, so it is made once for a picture.
    pub fn of_bytes(self) -> impl Fn([u8; 3]) -> [u8; 3] {
        let linear: Vec<f32> = (0..=255u8).map(|v| srgb_decode(f32::from(v) / 255.0)).collect();
        // Linear values in steps that are finer than those of bytes, down to the darkest.
        let encoded: Vec<u8> = (0..=STEPS).map(|i| byte(srgb_encode(i as f32 / STEPS as f32))).collect();
        let matrix = self.matrix();
        move |rgb| {
            let rgb = rgb.map(|v| linear[usize::from(v)]);
            matrix.map(|row| {
                let sum: f32 = row.iter().zip(rgb).map(|(m, v)| m * v).sum();
                encoded[(sum.clamp(0.0, 1.0) * STEPS as f32 + 0.5) as usize]
            })
        }
    }
}

/// Steps of the table of encoded values: the darkest byte is 20 of them.
const STEPS: u32 = 1 << 16;

fn byte(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_stay_and_normal_vision_changes_nothing() {
        for vision in Vision::ALL {
            let seen = vision.of_bytes();
            for v in 0..=255 {
                let found = seen([v; 3]);
                assert!(found.iter().all(|c| c.abs_diff(v) <= 1), "{vision:?} {v}: {found:?}");
            }
            for row in vision.matrix() {
                assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{vision:?}");
            }
        }
        let same = Vision::Normal.of_bytes();
        for color in [[255, 0, 0], [1, 2, 3], [17, 130, 200]] {
            assert_eq!(same(color), color);
        }
    }

    /// Red and green of equal lightness: far apart for most people, near for dichromats; blue and green for tritanopia.
    #[test]
    fn confused_colours_come_near() {
        let apart = |vision: Vision, a: [u8; 3], b: [u8; 3]| {
            let seen = vision.of_bytes();
            let (a, b) = (seen(a), seen(b));
            (0..3).map(|c| u32::from(a[c].abs_diff(b[c]))).sum::<u32>()
        };
        let (red, green) = ([190, 90, 60], [110, 130, 60]);
        let far = apart(Vision::Normal, red, green);
        assert!(apart(Vision::Deuteranopia, red, green) * 2 < far);
        assert!(apart(Vision::Tritanopia, red, green) * 2 > far);
        let (blue, teal) = ([60, 120, 190], [60, 140, 120]);
        let far = apart(Vision::Normal, blue, teal);
        assert!(apart(Vision::Tritanopia, blue, teal) * 2 < far);
    }
}
