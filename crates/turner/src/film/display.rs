//! Display values: exposure, tone mapping, colour space, transfer curve, rounding.

use super::byte_table::{ByteTable, quantise};
use super::exposure::factor;
use super::strips;
use crate::color::{DisplaySpace, Spectrum, Tonemap, Transfer};

/// How scene values become the display values of a picture file:
///
/// ```text
/// display value = round(largest · encode(convert(tonemap(2^exposure · linear / alpha))))
/// ```
///
/// `convert` changes to the primaries of the colour space, and `encode` is its curve. This is the transform of
/// [`super::Film::develop`], for pictures that are already developed or read from a file.
///
/// ```
/// use turner::color::{DisplaySpace, Tonemap, Transfer};
/// use turner::film::DisplayTransform;
///
/// let transform = DisplayTransform {
///     exposure: 1.0,
///     tonemap: Tonemap::Agx,
///     transfer: Transfer::Srgb,
///     space: DisplaySpace::DisplayP3,
/// };
/// let linear = [[0.18, 0.09, 0.02, 1.0]];
/// assert_eq!(transform.to_8_bits(&linear, 1).len(), 1);
/// assert_eq!(transform.to_16_bits(&linear, 1)[0][3], 65535);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayTransform {
    /// Exposure in stops: values are multiplied by 2 to this power.
    pub exposure: f64,
    /// The tone mapping operator.
    pub tonemap: Tonemap,
    /// The curve. With [`Transfer::None`] values are display values already: they are written unchanged, and `space`
    /// has no effect.
    pub transfer: Transfer,
    /// The colour space.
    pub space: DisplaySpace,
}

impl Default for DisplayTransform {
    /// sRGB without exposure and tone mapping.
    fn default() -> DisplayTransform {
        DisplayTransform {
            exposure: 0.0,
            tonemap: Tonemap::None,
            transfer: Transfer::Srgb,
            space: DisplaySpace::Srgb,
        }
    }
}

impl DisplayTransform {
    /// 8-bit display values with straight alpha, from premultiplied scene values: the nearest to the exact values.
    /// Pixels with NaN are magenta, pixels without coverage transparent black.
    /// `threads` of 0 uses all.
    pub fn to_8_bits(&self, linear: &[[f32; 4]], threads: usize) -> Vec<[u8; 4]> {
        let curve = Curve::new(self);
        match curve.table() {
            Some((table, stage)) => strips::map(linear.len(), threads, |i| {
                curve.pixel(linear[i], MAGENTA, stage, |v| table.byte(v))
            }),
            None => strips::map(linear.len(), threads, |i| {
                curve.pixel(linear[i], MAGENTA, Stage::Shown, |v| quantise(curve.encode(v)))
            }),
        }
    }

    /// 8-bit display values with dither: before rounding, an ordered pattern between -0.5 and +0.5 is added, so that
    /// smooth gradients have no bands. Values that 8 bits hold exactly stay as they are. The pattern depends only on
    /// the position in the picture: `linear` are rows of `width` columns from row `first_row` on.
    pub fn to_8_bits_dithered(
        &self,
        linear: &[[f32; 4]],
        width: u32,
        first_row: u32,
        threads: usize,
    ) -> Vec<[u8; 4]> {
        let curve = Curve::new(self);
        let width = (width as usize).max(1);
        strips::map(linear.len(), threads, |i| {
            let threshold = threshold_at((i % width) as u32, first_row + (i / width) as u32);
            curve.pixel(linear[i], MAGENTA, Stage::Shown, |v| {
                (f64::from(curve.encode(v)) * 255.0 + threshold) as u8
            })
        })
    }

    /// Like [`DisplayTransform::to_8_bits`], with 16 bits.
    pub fn to_16_bits(&self, linear: &[[f32; 4]], threads: usize) -> Vec<[u16; 4]> {
        let curve = Curve::new(self);
        let round = |v: f32| (f64::from(curve.encode(v)) * 65535.0 + 0.5) as u16;
        let nan = MAGENTA.map(|v| u16::from(v) * 257);
        strips::map(linear.len(), threads, |i| curve.pixel(linear[i], nan, Stage::Shown, round))
    }
}

/// Pixels with NaN.
const MAGENTA: [u8; 4] = [255, 0, 255, 255];

/// The rounding threshold of a pixel, 0 included to 1 excluded: multiples of the plastic number's powers, whose
/// neighbours differ strongly as in blue noise (M. Roberts, "The unreasonable effectiveness of quasirandom sequences",
/// 2018).
fn threshold_at(x: u32, y: u32) -> f64 {
    /// 2^32 / 1.3247179572… and 2^32 / 1.3247179572…².
    const STEP: [u32; 2] = [0xc13f_a9a9, 0x91e1_0da6];
    let at = x.wrapping_mul(STEP[0]).wrapping_add(y.wrapping_mul(STEP[1]));
    f64::from(at) / 4_294_967_296.0
}

/// A display transform, prepared for many pixels.
struct Curve {
    transfer: Transfer,
    tonemap: Tonemap,
    space: DisplaySpace,
    /// 2^exposure.
    factor: f32,
}

/// The step of the transform whose values [`Curve::pixel`] rounds.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// Linear display values in the primaries of the colour space.
    Shown,
    /// Before the final power of the tone mapping, which the lookup table includes.
    BeforePower,
}

impl Curve {
    fn new(transform: &DisplayTransform) -> Curve {
        let DisplayTransform { exposure, tonemap, transfer, space } = *transform;
        Curve { transfer, tonemap, space, factor: factor(exposure) }
    }

    /// The lookup table for 8-bit values, if there is one, and the step of the transform whose values it takes.
    fn table(&self) -> Option<(&'static ByteTable, Stage)> {
        let stage = match (self.transfer, self.space) {
            // Other primaries mix the components after the power.
            (Transfer::Srgb, DisplaySpace::DisplayP3) => Stage::Shown,
            (Transfer::Srgb, DisplaySpace::Srgb) => Stage::BeforePower,
            (Transfer::None, _) | (_, DisplaySpace::Rec2100Pq) => return None,
        };
        let power = if stage == Stage::BeforePower { self.tonemap.last_power() } else { 1.0 };
        ByteTable::srgb_of_power(power).map(|table| (table, stage))
    }

    /// From premultiplied scene values to straight display values; `round` encodes and rounds a colour value. Coverage
    /// has as many bits as the largest value of `nan`, the pixel for NaN.
    fn pixel<T: Copy + Default + FromEncoded>(
        &self,
        [r, g, b, a]: [f32; 4],
        nan: [T; 4],
        stage: Stage,
        round: impl Fn(f32) -> T,
    ) -> [T; 4] {
        if r.is_nan() || g.is_nan() || b.is_nan() {
            return nan;
        }
        if a <= 0.0 {
            return [T::default(); 4];
        }
        let straight = Spectrum::new(r, g, b).map(|v| if a == 1.0 { v } else { v / a });
        let shown = match self.tonemap {
            Tonemap::None if self.factor == 1.0 => straight,
            Tonemap::None => straight * self.factor,
            tonemap if stage == Stage::BeforePower => tonemap.before_power(straight * self.factor),
            tonemap => tonemap.map(straight * self.factor),
        };
        let shown = if self.transfer == Transfer::None { shown } else { self.space.convert(shown) };
        let [r, g, b] = shown.to_array().map(round);
        [r, g, b, T::from_coverage(a.min(1.0))]
    }

    /// The display value of a linear value, 0..=1.
    fn encode(&self, v: f32) -> f32 {
        match self.transfer {
            Transfer::None => self.transfer.encode(v),
            Transfer::Srgb => self.space.encode(v),
        }
    }
}

/// Integers of 8 or 16 bits.
trait FromEncoded {
    /// The nearest to a coverage of 0..=1.
    fn from_coverage(a: f32) -> Self;
}

impl FromEncoded for u8 {
    fn from_coverage(a: f32) -> u8 {
        (a * 255.0 + 0.5) as u8
    }
}

impl FromEncoded for u16 {
    fn from_coverage(a: f32) -> u16 {
        (f64::from(a) * 65535.0 + 0.5) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::pow;

    fn transform(transfer: Transfer, tonemap: Tonemap, exposure: f64) -> DisplayTransform {
        DisplayTransform { exposure, tonemap, transfer, space: DisplaySpace::Srgb }
    }

    fn shown(transform: &DisplayTransform, pixel: [f32; 4]) -> [u8; 4] {
        transform.to_8_bits(&[pixel], 1)[0]
    }

    /// The table joins the power at the end of a tone mapping with the sRGB curve.
    #[test]
    fn tables_give_the_bytes_of_the_curves() {
        for tonemap in [Tonemap::None, Tonemap::Neutral, Tonemap::Studio, Tonemap::Agx, Tonemap::Aces] {
            for space in [DisplaySpace::Srgb, DisplaySpace::DisplayP3] {
                let t = DisplayTransform { space, ..transform(Transfer::Srgb, tonemap, 0.3) };
                let curve = Curve::new(&t);
                let mut differ = 0;
                for i in 0..20_000_u16 {
                    let v = |k: u16| pow(2.0, f64::from(i.wrapping_mul(k)) / 4000.0 - 13.0) as f32;
                    let pixel = [v(7), v(131), v(613), 1.0];
                    let exact = curve.pixel(pixel, MAGENTA, Stage::Shown, |v| quantise(curve.encode(v)));
                    let found = shown(&t, pixel);
                    differ += u32::from(found != exact);
                    assert!(found.iter().zip(exact).all(|(a, b)| a.abs_diff(b) <= 1), "{found:?} {exact:?}");
                }
                // A value within the rounding of f32 of a half.
                assert!(differ <= 2, "{tonemap:?} {space:?}: {differ}");
            }
        }
    }

    #[test]
    fn display_values_are_straight() {
        let plain = transform(Transfer::None, Tonemap::None, 0.0);
        assert_eq!(shown(&plain, [0.25, 0.5, 0.0, 0.5]), [128, 255, 0, 128]);
        assert_eq!(shown(&plain, [0.2, 2.0, -1.0, 1.0]), [51, 255, 0, 255]);
        assert_eq!(shown(&plain, [f32::NAN, 0.0, 0.0, 1.0]), [255, 0, 255, 255]);
    }

    #[test]
    fn exposure_is_in_stops_and_comes_before_the_curves() {
        let plain = DisplayTransform::default();
        for stops in [-3.0, -1.0, 1.0, 5.0] {
            let exposed = transform(Transfer::Srgb, Tonemap::None, stops);
            for i in 0..500 {
                let v = i as f32 / 400.0;
                let by_hand = if stops < 0.0 {
                    v / (1 << -stops as i32) as f32
                } else {
                    v * (1 << stops as i32) as f32
                };
                assert_eq!(shown(&exposed, [v, v, v, 1.0]), shown(&plain, [by_hand, by_hand, by_hand, 1.0]));
            }
        }
        let mapped = transform(Transfer::None, Tonemap::Neutral, 2.0);
        // 0.15 · 4 − 0.04.
        assert_eq!(shown(&mapped, [0.15, 0.15, 0.15, 1.0]), [143, 143, 143, 255]);
    }

    #[test]
    fn tone_mapping_sees_colours_without_their_alpha() {
        for tonemap in [Tonemap::Neutral, Tonemap::Agx, Tonemap::Aces] {
            let mapped = transform(Transfer::Srgb, tonemap, 0.5);
            for v in [0.02, 0.3, 0.9, 7.0f32] {
                let [r, g, b, _] = shown(&mapped, [v, v / 2.0, v / 4.0, 1.0]);
                let half = shown(&mapped, [v / 2.0, v / 4.0, v / 8.0, 0.5]);
                assert_eq!(half, [r, g, b, 128], "{tonemap:?} {v}");
            }
            assert_eq!(shown(&mapped, [f32::INFINITY, 0.0, 0.0, 1.0])[0], 255);
            assert_eq!(shown(&mapped, [f32::NAN, 0.0, 0.0, 1.0]), [255, 0, 255, 255]);
            assert_eq!(shown(&mapped, [3.0, 3.0, 3.0, 0.0]), [0; 4]);
        }
    }

    #[test]
    fn sixteen_bits_are_the_eight_bits_more_precisely() {
        let wild: Vec<[f32; 4]> = (0..1000)
            .map(|i| {
                let v = i as f32 / 700.0;
                [v, v * v, 1.0 - v, [1.0, 0.5, 0.25][i % 3]]
            })
            .collect();
        for tonemap in [Tonemap::None, Tonemap::Agx] {
            for space in [DisplaySpace::Srgb, DisplaySpace::DisplayP3, DisplaySpace::Rec2100Pq] {
                let t = DisplayTransform { space, ..transform(Transfer::Srgb, tonemap, -0.5) };
                for (eight, sixteen) in t.to_8_bits(&wild, 1).iter().zip(t.to_16_bits(&wild, 1)) {
                    for (e, s) in eight.iter().zip(sixteen) {
                        assert!((f64::from(*e) * 257.0 - f64::from(s)).abs() <= 129.0, "{e} {s}");
                    }
                }
            }
        }
        let odd = [[f32::NAN, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 0.0], [1.0, 0.0, 0.0, 1.0]];
        let found = DisplayTransform::default().to_16_bits(&odd, 1);
        assert_eq!(found, [[65535, 0, 65535, 65535], [0; 4], [65535, 0, 0, 65535]]);
    }

    #[test]
    fn spaces_change_the_numbers_of_colours_not_of_greys() {
        let p3 = DisplayTransform { space: DisplaySpace::DisplayP3, ..DisplayTransform::default() };
        assert_eq!(
            shown(&p3, [0.5, 0.5, 0.5, 1.0]),
            shown(&DisplayTransform::default(), [0.5, 0.5, 0.5, 1.0])
        );
        // sRGB red in Display P3 is 0.9175, 0.2003, 0.1386.
        assert_eq!(shown(&p3, [1.0, 0.0, 0.0, 1.0]), [234, 51, 35, 255]);
        let pq = DisplayTransform { space: DisplaySpace::Rec2100Pq, ..DisplayTransform::default() };
        // Reference white is 58.07 % of the signal, ten times that 82.6 %.
        assert_eq!(pq.to_16_bits(&[[1.0, 1.0, 1.0, 1.0]], 1)[0][0], 38055);
        let bright = pq.to_16_bits(&[[10.0, 10.0, 10.0, 1.0]], 1)[0][0];
        assert!((54_000..54_600).contains(&bright), "{bright}");
        let plain = transform(Transfer::None, Tonemap::None, 0.0);
        let classic = DisplayTransform { space: DisplaySpace::DisplayP3, ..plain };
        assert_eq!(shown(&classic, [0.2, 0.4, 0.6, 1.0]), shown(&plain, [0.2, 0.4, 0.6, 1.0]));
    }

    #[test]
    fn dither_keeps_means_and_exact_values() {
        let plain = transform(Transfer::None, Tonemap::None, 0.0);
        let side = 256u32;
        for level in [0.0, 10.25, 99.5, 127.875, 255.0] {
            let v = level / 255.0;
            let flat = vec![[v, v, v, 1.0]; (side * side) as usize];
            let dithered = plain.to_8_bits_dithered(&flat, side, 0, 1);
            let mean: f64 = dithered.iter().map(|p| f64::from(p[0])).sum::<f64>() / f64::from(side * side);
            assert!((mean - f64::from(level)).abs() < 1e-3, "{level}: {mean}");
            assert!(dithered.iter().all(|p| (f64::from(p[0]) - f64::from(level)).abs() < 1.0));
            // Blocks of 8 x 8 pixels are already close to the mean: the noise has no low frequencies.
            for block in 0..32 {
                let at = |i: u32| dithered[((block * 8 + i / 8) * side + block * 8 + i % 8) as usize][0];
                let mean: f64 = (0..64).map(|i| f64::from(at(i))).sum::<f64>() / 64.0;
                assert!((mean - f64::from(level)).abs() < 0.1, "{level}: block {mean}");
            }
            if level.fract() == 0.0 {
                assert!(dithered.iter().all(|p| *p == dithered[0]), "{level}");
            }
        }
    }
}
