//! The limit of bright samples.

use super::FilmDesc;
use crate::color::Spectrum;
use crate::schema::choice;

choice! {
    /// The channels of a sample that `clamp_sample` compares with its limit.
    pub enum ClampSpace {
        /// Red, green and blue of linear Rec. 709.
        Rgb = "rgb",
        /// X, Y and Z of CIE 1931, as pbrt does; white of 1 has a Z of 1.089.
        Xyz = "xyz",
    }
}

/// From linear Rec. 709 to CIE XYZ (IEC 61966-2-1).
const TO_XYZ: [[f32; 3]; 3] =
    [[0.412_4, 0.357_6, 0.180_5], [0.212_6, 0.715_2, 0.072_2], [0.019_3, 0.119_2, 0.950_5]];

impl FilmDesc {
    /// The factor by which `clamp_sample` scales a sample: 1 if it is not brighter than the limit.
    #[inline]
    pub fn clamp_factor(&self, color: Spectrum) -> f32 {
        let most = self.clamp_sample as f32;
        let max = match self.clamp_space {
            ClampSpace::Rgb => color.max_component(),
            ClampSpace::Xyz => {
                let [x, y, z] = TO_XYZ.map(|row| row[0] * color.r + row[1] * color.g + row[2] * color.b);
                x.max(y).max(z)
            }
        };
        if most > 0.0 && max > most { most / max } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_brightest_channel_becomes_the_limit() {
        let film = |clamp_space| FilmDesc { clamp_sample: 2.0, clamp_space, ..FilmDesc::default() };
        let (rgb, xyz) = (film(ClampSpace::Rgb), film(ClampSpace::Xyz));
        let white = Spectrum::grey(4.0);
        assert_eq!(rgb.clamp_factor(white), 0.5);
        // D65 has a Z of 1.089.
        assert!((xyz.clamp_factor(white) - 0.5 / 1.089).abs() < 1e-4);
        // A red of 4 has an X of 1.65.
        let red = Spectrum::new(4.0, 0.0, 0.0);
        assert_eq!((rgb.clamp_factor(red), xyz.clamp_factor(red)), (0.5, 1.0));
        assert_eq!(FilmDesc { clamp_sample: 0.0, ..xyz }.clamp_factor(white), 1.0);
    }
}
