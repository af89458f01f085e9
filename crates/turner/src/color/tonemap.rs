//! Tone mapping: from scene radiance to what a display can show.
//!
//! Each curve maps linear Rec. 709 values (0.18 is middle grey, 1 a fully lit white surface) to linear display values
//! in 0..=1, which the transfer curve then encodes.

use super::Spectrum;
use crate::choice::choice;
use crate::math::elementary::{log2, pow};

choice! {
    /// How scene radiance becomes display values.
    pub enum Tonemap {
        /// No tone mapping: values above 1 are clipped.
        None = "none",
        /// Khronos PBR Neutral: keeps surface colours and compresses only highlights. For product pictures.
        Neutral = "neutral",
        /// "neutral" with a white point: a value of 1.25 is shown as white, so a white backdrop is white. For models in
        /// the studio.
        Studio = "studio",
        /// AgX, base look: strong light fades to white as on film, with soft contrast. For interiors and landscapes.
        Agx = "agx",
        /// The filmic curve of ACES 1, as fitted by S. Hill: strong contrast, darker mid-tones.
        Aces = "aces",
    }
}

impl Tonemap {
    /// Maps scene radiance to display values. Negative and NaN components count as 0, infinite ones as the largest f32.
    pub fn map(self, color: Spectrum) -> Spectrum {
        let power = self.last_power();
        let mapped = self.before(color).map(|v| if power == 1.0 { v } else { pow(v.max(0.0), power) });
        Spectrum::from(mapped.map(|v| v.clamp(0.0, 1.0) as f32))
    }

    /// The exponent of the power that [`Tonemap::map`] applies last; 1 for none.
    pub(crate) fn last_power(self) -> f64 {
        match self {
            Tonemap::None | Tonemap::Neutral | Tonemap::Studio | Tonemap::Aces => 1.0,
            Tonemap::Agx => 2.2,
        }
    }

    /// Display values before the last power, in 0..=1.
    #[inline]
    pub(crate) fn before_power(self, color: Spectrum) -> Spectrum {
        Spectrum::from(self.before(color).map(|v| v.clamp(0.0, 1.0) as f32))
    }

    #[inline]
    fn before(self, color: Spectrum) -> [f64; 3] {
        let light = color.to_array().map(|v| if v > 0.0 { f64::from(v.min(f32::MAX)) } else { 0.0 });
        match self {
            Tonemap::None => light,
            Tonemap::Neutral => neutral(light),
            Tonemap::Studio => neutral(light).map(|v| v / STUDIO_PEAK),
            Tonemap::Agx => agx(light),
            Tonemap::Aces => aces(light),
        }
    }

    /// The scene radiance that [`Tonemap::map`] maps to a display value of 0..=1: exactly for [`Tonemap::None`],
    /// [`Tonemap::Neutral`] and [`Tonemap::Studio`]. The others give a multiple of the value with the same largest
    /// component. A value that no radiance reaches gives that of 0.99.
    pub fn inverse(self, display: Spectrum) -> Spectrum {
        let shown = display.to_array().map(|v| f64::from(v).clamp(0.0, 1.0));
        let light = match self {
            Tonemap::None => shown,
            Tonemap::Neutral => neutral_inverse(shown.map(|v| v.min(0.99))),
            Tonemap::Studio => neutral_inverse(shown.map(|v| v * STUDIO_PEAK)),
            Tonemap::Agx | Tonemap::Aces => {
                let wanted = display.max_component().clamp(0.0, 0.99);
                let (mut low, mut high) = (0.0_f32, 64.0_f32);
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    let reached = self.map(display * middle).max_component() >= wanted;
                    (low, high) = if reached { (low, middle) } else { (middle, high) };
                }
                return display * high;
            }
        };
        Spectrum::from(light.map(|v| v.max(0.0) as f32))
    }
}

/// The value that [`Tonemap::Studio`] shows as white.
const STUDIO_WHITE: f64 = 1.25;

/// [`neutral`] of [`STUDIO_WHITE`].
const STUDIO_PEAK: f64 = 1.0 - HEADROOM * HEADROOM / (STUDIO_WHITE - F90 - START + HEADROOM);

/// Constants of Khronos PBR Neutral, see [`neutral`].
const F90: f64 = 0.04;
const START: f64 = 0.8 - F90;
const HEADROOM: f64 = 1.0 - START;
const DESATURATION: f64 = 0.15;

/// Khronos PBR Neutral ("Khronos PBR Neutral Tone Mapper" specification, 2024). First it subtracts the reflection
/// that every dielectric adds, F90 = 0.04, and less from colours whose least component is below 0.08: a glTF colour of 0.5 is shown as 0.5 under
/// white light of 1. Above K_s = 0.8 − 0.04, a hyperbola compresses the largest component towards 1, and the colour
/// loses saturation at the rate K_d = 0.15.
fn neutral(color: [f64; 3]) -> [f64; 3] {
    let least = color[0].min(color[1]).min(color[2]);
    let offset = if least < 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let color = color.map(|v| v - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak <= START {
        return color;
    }
    let compressed = 1.0 - HEADROOM * HEADROOM / (peak - START + HEADROOM);
    let whiteness = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    color.map(|v| v / peak * compressed * (1.0 - whiteness) + compressed * whiteness)
}

/// The inverse of [`neutral`] for values below 1.
fn neutral_inverse(shown: [f64; 3]) -> [f64; 3] {
    let compressed = shown[0].max(shown[1]).max(shown[2]);
    let color = if compressed <= START {
        shown
    } else {
        let peak = HEADROOM * HEADROOM / (1.0 - compressed) - HEADROOM + START;
        let whiteness = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
        shown.map(|v| (v - compressed * whiteness) / (compressed * (1.0 - whiteness)) * peak)
    };
    let least = color[0].min(color[1]).min(color[2]).max(0.0);
    // A least component x below 2 F90 became x² / (4 F90).
    let offset = if least < F90 { (4.0 * F90 * least).sqrt() - least } else { F90 };
    color.map(|v| v + offset)
}

type Matrix = [[f64; 3]; 3];

fn multiply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// AgX (T. Sobotka 2022) with the matrices and the polynomial of B. Wrensch, "Minimal AgX Implementation" (2024):
/// inset the primaries, take a logarithm over 16.5 stops, apply a sigmoid, outset the primaries. The display's power of
/// 2.2 is then undone: [`Tonemap::last_power`].
fn agx(color: [f64; 3]) -> [f64; 3] {
    const INSET: Matrix = [
        [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
        [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
        [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
    ];
    const OUTSET: Matrix = [
        [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
        [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
        [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
    ];
    /// Range of the logarithm, in stops: the darkest and the brightest value it distinguishes.
    const STOPS: [f64; 2] = [-12.473_93, 4.026_069];
    /// Below the first of them.
    const DARKEST: f64 = 1.0 / 8192.0;
    /// Coefficients of the sigmoid polynomial, from x⁶ down.
    const SIGMOID: [f64; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
    let curved = multiply(&INSET, color).map(|v| {
        // Nothing is darker than the darkest value.
        let stops = log2(v.max(DARKEST));
        let x = ((stops - STOPS[0]) / (STOPS[1] - STOPS[0])).clamp(0.0, 1.0);
        SIGMOID.iter().fold(0.0, |sum, c| sum * x + c).max(0.0)
    });
    multiply(&OUTSET, curved)
}

/// The reference rendering and display transforms of ACES 1 as fitted by S. Hill (BakingLab, "ACES.hlsl", 2016): Rec.
/// 709 to working primaries with desaturation, a rational curve, and back.
fn aces(color: [f64; 3]) -> [f64; 3] {
    const INPUT: Matrix =
        [[0.597_19, 0.354_58, 0.048_23], [0.076, 0.908_34, 0.015_66], [0.0284, 0.133_83, 0.837_77]];
    const OUTPUT: Matrix = [
        [1.604_75, -0.531_08, -0.073_67],
        [-0.102_08, 1.108_13, -0.006_05],
        [-0.003_27, -0.072_76, 1.076_02],
    ];
    let curved = multiply(&INPUT, color).map(|v| {
        let above = v * (v + 0.024_578_6) - 0.000_090_537;
        let below = v * (0.983_729 * v + 0.432_951) + 0.238_081;
        above / below
    });
    multiply(&OUTPUT, curved)
}

#[cfg(test)]
mod tests {
    use super::*;
    use Tonemap::{Aces, Agx, Neutral, Studio};

    fn near(tonemap: Tonemap, color: [f32; 3], expected: [f64; 3], tolerance: f64) {
        let found = tonemap.map(Spectrum::from(color)).to_array();
        let close = found.iter().zip(expected).all(|(f, e)| (f64::from(*f) - e).abs() <= tolerance);
        assert!(close, "{tonemap:?} of {color:?}: {found:?}, expected {expected:?}");
    }

    /// Computed by hand from the specification: 1 − 0.24² / (0.96 − 0.76 + 0.24), and so on.
    #[test]
    fn neutral_is_as_specified() {
        near(Neutral, [0.5, 0.2, 0.1], [0.46, 0.16, 0.06], 1e-7);
        near(Neutral, [0.8, 0.5, 0.3], [0.76, 0.46, 0.26], 1e-7);
        // In the toe the smallest component becomes x² / 0.16.
        near(Neutral, [0.5, 0.3, 0.04], [0.47, 0.27, 0.01], 1e-7);
        near(Neutral, [0.6, 0.2, 0.0], [0.6, 0.2, 0.0], 1e-7);
        near(Neutral, [1.0, 1.0, 1.0], [0.869_090_909; 3], 1e-7);
        // Peak 4: compressed 1 − 0.0576 / 3.48 = 0.983448; whiteness 1 − 1 / (0.15 · 3.016552 + 1) = 0.311524.
        let (p, w) = (0.983_448_275_9, 0.311_523_669_3);
        near(Neutral, [4.0, 0.0, 0.0], [p, p * w, p * w], 1e-6);
    }

    #[test]
    fn studio_is_neutral_with_a_white_point() {
        // 1 − 0.0576 / (1.21 − 0.52) of the specification.
        let peak = 1.0 - 0.0576 / 0.69;
        near(Studio, [0.5, 0.2, 0.1], [0.46 / peak, 0.16 / peak, 0.06 / peak], 1e-6);
        near(Studio, [1.25; 3], [1.0; 3], 1e-7);
        near(Studio, [40.0; 3], [1.0; 3], 0.0);
    }

    #[test]
    fn the_inverse_gives_the_shown_colour() {
        for tonemap in [Tonemap::None, Neutral, Studio] {
            for color in [[0.0; 3], [0.9; 3], [0.9, 0.5, 0.1], [0.01, 0.02, 0.5], [0.3, 0.004, 0.06]] {
                let inverse = tonemap.inverse(Spectrum::from(color)).to_array();
                near(tonemap, inverse, color.map(f64::from), 2e-5);
            }
        }
        assert!((Studio.inverse(Spectrum::WHITE).r - 1.25).abs() < 1e-5);
        for tonemap in [Agx, Aces] {
            let shown = tonemap.map(tonemap.inverse(Spectrum::new(0.4, 0.6, 0.5)));
            assert!((shown.max_component() - 0.6).abs() < 1e-4, "{tonemap:?} {shown:?}");
        }
    }

    #[test]
    fn neutral_leaves_surface_colours_unchanged_but_for_the_offset() {
        for i in 0..1000_u16 {
            let mix = |k: u16| 0.08 + 0.72 * f32::from(i.wrapping_mul(k) % 997) / 997.0;
            let color = Spectrum::new(mix(7), mix(131), mix(613));
            let mapped = Neutral.map(color);
            for (mapped, v) in mapped.to_array().iter().zip(color.to_array()) {
                assert!((mapped - (v - 0.04)).abs() < 1e-6, "{color:?}: {mapped:?}");
            }
        }
    }

    /// Values of the published shaders, computed separately in double precision.
    #[test]
    fn agx_and_aces_are_the_published_curves() {
        near(Agx, [0.18, 0.18, 0.18], AGX[0], 1e-6);
        near(Agx, [1.0, 1.0, 1.0], AGX[1], 1e-6);
        near(Agx, [4.0, 0.1, 0.02], AGX[2], 1e-6);
        near(Aces, [0.18, 0.18, 0.18], ACES[0], 1e-6);
        near(Aces, [1.0, 1.0, 1.0], ACES[1], 1e-6);
        near(Aces, [4.0, 0.1, 0.02], ACES[2], 1e-6);
    }

    const AGX: [[f64; 3]; 3] = [
        [0.214_467_430_7, 0.214_532_668_6, 0.214_536_728_3],
        [0.589_976_980_6, 0.590_207_155_3, 0.590_221_479_4],
        [0.995_127_150_5, 0.266_473_149_0, 0.202_920_217_6],
    ];
    const ACES: [[f64; 3]; 3] = [
        [0.105_591_247_2, 0.105_591_247_2, 0.105_590_191_3],
        [0.619_115_426_9, 0.619_115_426_9, 0.619_109_225_8],
        [1.0, 0.240_215_823_5, 0.056_709_038_5],
    ];

    #[test]
    fn greys_stay_grey_and_rise() {
        for tonemap in [Tonemap::None, Neutral, Studio, Agx, Aces] {
            let mut last = 0.0;
            for i in 0..2400 {
                let v = pow(2.0, f64::from(i) / 50.0 - 24.0) as f32;
                let [r, g, b] = tonemap.map(Spectrum::grey(v)).to_array();
                assert!(r >= last && r <= 1.0, "{tonemap:?} at {v}: {r} after {last}");
                // The published matrices are rounded.
                assert!((r - g).abs() < 6e-4 && (r - b).abs() < 6e-4, "{tonemap:?} at {v}");
                last = r;
            }
            assert!(last > 0.99, "{tonemap:?} ends at {last}");
            assert!(tonemap.map(Spectrum::BLACK).max_component() < 1e-6, "{tonemap:?}");
        }
    }

    #[test]
    fn any_input_gives_finite_output() {
        let odd =
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -1.0, 0.0, -0.0, 1e-45, 1e30];
        for tonemap in [Tonemap::None, Neutral, Studio, Agx, Aces] {
            for i in 0..odd.len().pow(3) {
                let [r, g, b] = [i, i / odd.len(), i / odd.len() / odd.len()].map(|i| odd[i % odd.len()]);
                let mapped = tonemap.map(Spectrum::new(r, g, b));
                let inside = mapped.to_array().iter().all(|v| (0.0..=1.0).contains(v));
                assert!(inside, "{tonemap:?} of {r}, {g}, {b}: {mapped:?}");
            }
            assert!(tonemap.map(Spectrum::grey(f32::INFINITY)).max_component() > 0.99);
        }
    }
}
