//! Tone mapping: from scene radiance to what a display can show.
//!
//! Each curve maps linear Rec. 709 values (0.18 is middle grey, 1 a fully lit white surface) to linear display values
//! in 0..=1, which the transfer curve then encodes.

use super::Spectrum;
use crate::choice::choice;
use crate::math::elementary::{ln, pow};

choice! {
    /// How scene radiance becomes display values.
    pub enum Tonemap {
        /// No tone mapping: values above 1 are clipped.
        None = "none",
        /// Khronos PBR Neutral: keeps surface colours and compresses only highlights. For product pictures.
        Neutral = "neutral",
        /// AgX, base look: strong light fades to white as on film, with soft contrast. For interiors and landscapes.
        Agx = "agx",
        /// The filmic curve of ACES 1, as fitted by S. Hill: strong contrast, darker mid-tones.
        Aces = "aces",
    }
}

impl Tonemap {
    /// Maps scene radiance to display values. Negative and NaN components count as 0, infinite ones as the largest f32.
    pub fn map(self, color: Spectrum) -> Spectrum {
        let light = color.to_array().map(|v| if v > 0.0 { f64::from(v.min(f32::MAX)) } else { 0.0 });
        let mapped = match self {
            Tonemap::None => light,
            Tonemap::Neutral => neutral(light),
            Tonemap::Agx => agx(light),
            Tonemap::Aces => aces(light),
        };
        Spectrum::from(mapped.map(|v| v.clamp(0.0, 1.0) as f32))
    }
}

/// Khronos PBR Neutral ("Khronos PBR Neutral Tone Mapper" specification, 2024). First it subtracts the reflection
/// that every dielectric adds, F90 = 0.04, with a parabola at the toe: a glTF colour of 0.5 is shown as 0.5 under
/// white light of 1. Above K_s = 0.8 − 0.04, a hyperbola compresses the largest component towards 1, and the colour
/// loses saturation at the rate K_d = 0.15.
fn neutral(color: [f64; 3]) -> [f64; 3] {
    const F90: f64 = 0.04;
    const START: f64 = 0.8 - F90;
    const DESATURATION: f64 = 0.15;
    let least = color[0].min(color[1]).min(color[2]);
    let offset = if least < 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let color = color.map(|v| v - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak <= START {
        return color;
    }
    let headroom = 1.0 - START;
    let compressed = 1.0 - headroom * headroom / (peak - START + headroom);
    let whiteness = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    color.map(|v| v / peak * compressed * (1.0 - whiteness) + compressed * whiteness)
}

type Matrix = [[f64; 3]; 3];

fn multiply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// AgX (T. Sobotka 2022) with the matrices and the polynomial of B. Wrensch, "Minimal AgX Implementation" (2024):
/// inset the primaries, take a logarithm over 16.5 stops, apply a sigmoid, outset the primaries, and undo the
/// display's power of 2.2.
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
    /// Coefficients of the sigmoid polynomial, from x⁶ down.
    const SIGMOID: [f64; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
    let curved = multiply(&INSET, color).map(|v| {
        let stops = ln(v) * std::f64::consts::LOG2_E;
        // The logarithm of 0 is −∞.
        let x = ((stops - STOPS[0]) / (STOPS[1] - STOPS[0])).clamp(0.0, 1.0);
        SIGMOID.iter().fold(0.0, |sum, c| sum * x + c).max(0.0)
    });
    multiply(&OUTSET, curved).map(|v| pow(v.max(0.0), 2.2))
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
    use Tonemap::{Aces, Agx, Neutral};

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
        for tonemap in [Tonemap::None, Neutral, Agx, Aces] {
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
        for tonemap in [Tonemap::None, Neutral, Agx, Aces] {
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
