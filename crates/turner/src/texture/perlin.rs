//! Gradient noise (Perlin 2002, "Improving noise") and its fractal sums.
//!
//! Each point of the integer lattice gets a pseudo-random gradient. Within a cell, the eight linear functions that
//! the corners' gradients define are blended by a quintic polynomial:
//!
//! ```text
//!      g01 o---------o g11        value = Σ w(d) · g · d
//!          |    . p  |            d: vector from the corner to p
//!      g00 o---------o g10        w: fade(1 − |dx|) fade(1 − |dy|) ...
//! ```
//!
//! There are two differences to the paper: lattice points are hashed by 64-bit arithmetic instead of a table, so the
//! noise does not repeat; and the gradients are 48 unit vectors (the corners of a truncated cuboctahedron), so no
//! axis stands out. Only additions, multiplications and comparisons are used: the same bits on every machine.

use super::placement::{floor, smoothstep};
use crate::math::DVec3;

/// Coordinates of the 48 directions (±a, ±b, ±c) and their permutations: 1, 1 + √2, 1 + 2√2, normalized.
const A: f64 = 0.215_739_405_272_266_48;
const B: f64 = 0.520_840_998_146_611_3;
const C: f64 = 0.825_942_591_020_956_2;

/// The 48 gradients.
const GRADIENTS: [DVec3; 48] = {
    let orders = [[A, B, C], [A, C, B], [B, A, C], [B, C, A], [C, A, B], [C, B, A]];
    let mut list = [DVec3::ZERO; 48];
    let mut i = 0;
    while i < 48 {
        let [x, y, z] = orders[i / 8];
        list[i] = DVec3::new(
            if i & 1 == 0 { x } else { -x },
            if i & 2 == 0 { y } else { -y },
            if i & 4 == 0 { z } else { -z },
        );
        i += 1;
    }
    list
};

/// Scales the noise to −1..1. Its largest value for unit gradients is √3/2: the weights w of the corners at offsets d
/// give |Σ w g·d| ≤ √(Σ w d²), and Σ w d² ≤ 1/4 per axis.
const TO_UNIT: f64 = 1.154_700_538_379_251_7;

/// The mean absolute value of the noise, measured.
const MEAN_ABS: f64 = 0.219;

/// Gradient noise: values in −1..1 with mean 0 and two continuous derivatives, 0 at all integer coordinates, with
/// features about one unit wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Perlin {
    seed: u64,
}

impl Perlin {
    /// The noise of a seed.
    pub fn new(seed: u64) -> Perlin {
        Perlin { seed: mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) }
    }

    /// The value at a point; 0 if a coordinate is not finite or too large (2^52) to have a fraction.
    pub fn at(&self, p: DVec3) -> f64 {
        let small = |v: f64| v.abs() < 4_503_599_627_370_496.0;
        if !(small(p.x) && small(p.y) && small(p.z)) {
            return 0.0;
        }
        let (x, y, z) = (floor(p.x), floor(p.y), floor(p.z));
        let d = p - DVec3::new(x as f64, y as f64, z as f64);
        let (x0, x1) = (key(x, KX), key(x + 1, KX));
        let (y0, y1) = (key(y, KY), key(y + 1, KY));
        let (z0, z1) = (key(z, KZ), key(z + 1, KZ));
        let (e, w) = (d - DVec3::ONE, DVec3::new(fade(d.x), fade(d.y), fade(d.z)));
        let corner = |x: u64, y: u64, z: u64, dx: f64, dy: f64, dz: f64| {
            let h = mix(self.seed.wrapping_add(x).wrapping_add(y).wrapping_add(z));
            GRADIENTS[(((h >> 32) * 48) >> 32) as usize].dot(DVec3::new(dx, dy, dz))
        };
        let near = lerp(
            lerp(corner(x0, y0, z0, d.x, d.y, d.z), corner(x1, y0, z0, e.x, d.y, d.z), w.x),
            lerp(corner(x0, y1, z0, d.x, e.y, d.z), corner(x1, y1, z0, e.x, e.y, d.z), w.x),
            w.y,
        );
        let far = lerp(
            lerp(corner(x0, y0, z1, d.x, d.y, e.z), corner(x1, y0, z1, e.x, d.y, e.z), w.x),
            lerp(corner(x0, y1, z1, d.x, e.y, e.z), corner(x1, y1, z1, e.x, e.y, e.z), w.x),
            w.y,
        );
        (TO_UNIT * lerp(near, far, w.z)).clamp(-1.0, 1.0)
    }
}

const KX: u64 = 0x9e37_79b9_7f4a_7c15;
const KY: u64 = 0xc2b2_ae3d_27d4_eb4f;
const KZ: u64 = 0x1656_67b1_9e37_79f9;

fn key(i: i64, k: u64) -> u64 {
    (i as u64).wrapping_mul(k)
}

/// A hash of 64 bits (the finalizer of SplitMix64, Steele et al. 2014).
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// 6t⁵ − 15t⁴ + 10t³: first and second derivatives are 0 at both ends.
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// Fractal noise: octaves of noise with increasing frequency and decreasing amplitude. Between octaves the lattice is
/// rotated and shifted; on a common lattice the octaves' zeros would coincide and show as a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fractal {
    seed: u64,
    octaves: u32,
    lacunarity: f64,
    gain: f64,
    /// 1 / the sum of the amplitudes.
    scale: f64,
}

impl Fractal {
    /// `octaves` (at least 1) of noise, each with `lacunarity` times the frequency and `gain` times the amplitude.
    pub fn new(seed: u64, octaves: u32, lacunarity: f64, gain: f64) -> Fractal {
        let octaves = octaves.max(1);
        let (mut sum, mut amplitude) = (0.0, 1.0);
        for _ in 0..octaves {
            sum += amplitude;
            amplitude *= gain;
        }
        Fractal {
            seed: seed.wrapping_mul(0x2545_f491_4f6c_dd1d),
            octaves,
            lacunarity,
            gain,
            scale: 1.0 / sum,
        }
    }

    /// Fractal Brownian motion: the sum of the octaves, in −1..1, mean 0. Octaves too fine for a footprint of this
    /// `width` fade to their mean (clamping, Norton et al. 1982); width 0 is a point.
    pub fn fbm(&self, p: DVec3, width: f64) -> f64 {
        self.sum(p, width, 0.0, |n| n)
    }

    /// The sum of the octaves' absolute values, in 0..1; it has creases where an octave is 0. `width` as in
    /// [`Fractal::fbm`].
    pub fn turbulence(&self, p: DVec3, width: f64) -> f64 {
        self.sum(p, width, MEAN_ABS, f64::abs)
    }

    #[inline]
    fn sum(&self, mut p: DVec3, mut width: f64, mean: f64, f: impl Fn(f64) -> f64) -> f64 {
        let (mut sum, mut amplitude) = (0.0, self.scale);
        for octave in 0..self.octaves {
            p = rotate_lattice(p);
            // Features are about one unit wide: a footprint half as wide begins to average them.
            let lost = if width > 0.0 { smoothstep(0.3, 1.0, width) } else { 0.0 };
            if lost < 1.0 {
                let value = f(Perlin::new(self.seed.wrapping_add(u64::from(octave))).at(p));
                sum += amplitude * (value + lost * (mean - value));
            } else {
                sum += amplitude * mean;
            }
            p *= self.lacunarity;
            width *= self.lacunarity;
            amplitude *= self.gain;
        }
        sum.clamp(-1.0, 1.0)
    }
}

/// A rotation by the integer quaternion (1, 2, 3, 4)/√30, exact to about the last bit, and a shift. No axis, diagonal
/// or coordinate plane is aligned with the lattice.
#[inline]
fn rotate_lattice(p: DVec3) -> DVec3 {
    DVec3::new(
        (-20.0 * p.x + 4.0 * p.y + 22.0 * p.z) / 30.0 + 0.419_38,
        (20.0 * p.x - 10.0 * p.y + 20.0 * p.z) / 30.0 + 7.217_51,
        (10.0 * p.x + 28.0 * p.y + 4.0 * p.z) / 30.0 - 3.641_97,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Irregular points within ±50.
    fn points(n: u64) -> impl Iterator<Item = DVec3> {
        let unit = |i: u64| (mix(i.wrapping_mul(KX)) >> 11) as f64 / (1u64 << 53) as f64;
        (1..=n).map(move |i| 100.0 * DVec3::new(unit(3 * i), unit(3 * i + 1), unit(3 * i + 2)) - 50.0)
    }

    #[test]
    fn gradients_are_unit_vectors_that_cancel() {
        let sum: DVec3 = GRADIENTS.iter().sum();
        assert!(sum.length() < 1e-12);
        assert!(GRADIENTS.iter().all(|g| (g.length() - 1.0).abs() < 1e-15));
    }

    #[test]
    fn values_have_mean_zero_and_use_the_range() {
        let noise = Perlin::new(5);
        let n = 200_000;
        let (mut sum, mut squares, mut least, mut most) = (0.0, 0.0, 0.0_f64, 0.0_f64);
        for v in points(n).map(|p| noise.at(p)) {
            (sum, squares) = (sum + v, squares + v * v);
            (least, most) = (least.min(v), most.max(v));
        }
        let (mean, deviation) = (sum / n as f64, (squares / n as f64).sqrt());
        // Neighbouring points are independent: four standard errors.
        assert!(mean.abs() < 4.0 * deviation / (n as f64).sqrt(), "mean {mean}");
        assert!((0.2..0.35).contains(&deviation), "deviation {deviation}");
        assert!(least > -1.0 && least < -0.7 && most < 1.0 && most > 0.7, "{least} to {most}");
    }

    #[test]
    fn integer_points_are_zero() {
        let noise = Perlin::new(1);
        for (x, y, z) in [(0.0, 0.0, 0.0), (-3.0, 7.0, 1.0), (1e9, -1e9, 0.0), (1e300, -1e300, 9e18)] {
            assert_eq!(noise.at(DVec3::new(x, y, z)), 0.0);
        }
        assert_eq!(noise.at(DVec3::new(f64::NAN, 0.5, 0.5)), 0.0);
        assert_eq!(noise.at(DVec3::new(0.5, f64::INFINITY, 0.5)), 0.0);
    }

    #[test]
    fn value_and_slope_are_continuous_across_cells() {
        let noise = Perlin::new(9);
        let h = 1e-5;
        for p in points(2000) {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                // Where the axis crosses a cell boundary, and anywhere.
                let wall = p - axis * (p.dot(axis) - p.dot(axis).floor());
                for q in [p, wall] {
                    let [a, b, c] = [-h, 0.0, h].map(|d| noise.at(q + axis * d));
                    assert!((c - a).abs() < 8.0 * h);
                    let (before, after) = ((b - a) / h, (c - b) / h);
                    assert!((before - after).abs() < 50.0 * h, "slopes {before}, {after} at {q}");
                }
            }
        }
    }

    #[test]
    fn seeds_and_octaves_differ() {
        let (a, b) = (Perlin::new(1), Perlin::new(2));
        let n = 20_000;
        let (ab, aa) = points(n).fold((0.0, 0.0), |(ab, aa), p| {
            let (x, y) = (a.at(p), b.at(p));
            (ab + x * y, aa + x * x)
        });
        assert!((ab / aa).abs() < 0.03, "correlation {}", ab / aa);
        let f = Fractal::new(1, 1, 2.0, 0.5);
        assert!(points(100).any(|p| f.fbm(p, 0.0) != Fractal::new(2, 1, 2.0, 0.5).fbm(p, 0.0)));
    }

    #[test]
    fn sums_stay_in_range() {
        for (octaves, lacunarity, gain) in [(1, 2.0, 0.5), (6, 2.0, 0.5), (16, 16.0, 1.0), (3, 1.0, 0.0)] {
            let f = Fractal::new(3, octaves, lacunarity, gain);
            for p in points(500) {
                assert!((-1.0..=1.0).contains(&f.fbm(p, 0.0)) && (0.0..=1.0).contains(&f.turbulence(p, 0.0)));
                assert!(f.fbm(1e17 * p, 0.0).is_finite());
            }
        }
    }

    #[test]
    fn the_lattice_does_not_show_in_a_slice() {
        // On the plane z = 0, plain noise is 0 at all integer points; a fractal sum, even of one octave, is not.
        let f = Fractal::new(0, 1, 2.0, 0.5);
        let square = |i: u32| {
            let v = f.fbm(DVec3::new(f64::from(i % 40), f64::from(i / 40), 0.0), 0.0);
            v * v
        };
        let deviation = ((0..1600).map(square).sum::<f64>() / 1600.0).sqrt();
        assert!(deviation > 0.2, "{deviation}");
    }

    #[test]
    fn bits_are_the_same_on_every_machine() {
        let p = DVec3::new(0.3, -1.7, 12.25);
        let f = Fractal::new(4, 5, 2.0, 0.5);
        let bits = [
            Perlin::new(0).at(p),
            Perlin::new(7).at(-1000.1 * p),
            Perlin::new(0).at(1e12 * DVec3::splat(1.000_000_000_000_3)),
            f.fbm(p, 0.0),
            f.turbulence(p, 0.0),
        ]
        .map(f64::to_bits);
        assert_eq!(bits.map(|b| format!("{b:016x}")), GOLDEN);
    }

    const GOLDEN: [&str; 5] =
        ["bfc24291617530ee", "bfc50e517ea88843", "3fd3e752e2a7389f", "bfa7fb5fa6d46132", "3fc3592ac0f6dd7c"];
}
