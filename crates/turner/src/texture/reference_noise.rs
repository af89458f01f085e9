//! pbrt's noise textures, so that its scenes keep their own clouds, wrinkles, veins and dots.
//!
//! The noise is that of Perlin 2002, "Improving noise", with its permutation table. The sums are those of Pharr,
//! Jakob and Humphreys, "Physically Based Rendering", 3rd ed., §10.6; octaves finer than the footprint fade out.

use super::placement::{floor, smoothstep};
use super::prepare::{Kind, PrepareContext};
use super::{Mapping, Placement, TexturePoint, Textures};
use crate::color::Spectrum;
use crate::math::elementary::{ln, sin};
use crate::math::{DVec2, DVec3};
use crate::schema::{ColorSource, Range, SceneError, Transform, choice, params};

choice! {
    /// The pattern made from the noise.
    pub enum PerlinKind {
        /// The sum of octaves: clouds, negative as often as positive.
        Fbm = "fbm",
        /// The sum of the octaves' absolute values: creases.
        Wrinkled = "wrinkled",
        /// Waves whose height a coarser noise modulates.
        Windy = "windy",
        /// White stone with dark veins across y, displaced by noise. Its colours are its own, applied between `low`
        /// and `high`.
        Marble = "marble",
        /// Dots in about half of the squares of (s, t).
        Dots = "dots",
    }
}

params! {
    /// Perlin's reference noise, with the sums and constants of pbrt's textures. The colour is `low` + noise ·
    /// (`high` − `low`), not clamped where the noise is below 0 or above 1.
    pub struct PerlinDesc as "perlin" {
        /// The colour where the noise is 0.
        low: ColorSource = ColorSource::Constant(Spectrum::BLACK);
        /// The colour where the noise is 1.
        high: ColorSource = ColorSource::Constant(Spectrum::WHITE);
        /// The pattern made from the noise.
        kind: PerlinKind = PerlinKind::Fbm;
        /// Number of octaves of "fbm", "wrinkled" and "marble"; each has 1.99 times the frequency of the one before.
        octaves: u32 = 8, in Range::closed(1.0, 16.0);
        /// Amplitude ratio of successive octaves.
        gain: f64 = 0.5, in Range::UNIT;
        /// How far noise displaces the veins of "marble".
        variation: f64 = 0.2, in Range::closed(0.0, 1e6);
        /// Number of the largest features per unit of texture coordinates.
        density: f64 = 1.0;
        /// Where the texture coordinates come from.
        mapping: Mapping = Mapping::Solid;
        /// For `mapping = "triplanar"`: sharpness of the transitions between the three projections; higher is sharper.
        blend: f64 = 4.0, in Range::closed(1.0, 64.0);
        /// Translates, rotates or scales the noise.
        transform: Transform = Transform::IDENTITY;
    }
    example r##"[texture.wrinkles]
type = "perlin"
kind = "wrinkled"
density = 4

[[object]]
type = "sphere"
material = { color = "wrinkles" }
"##
}

/// The prepared texture.
#[derive(Clone, Debug)]
pub(super) struct Perlin {
    desc: PerlinDesc,
    placement: Placement,
}

impl Kind for PerlinDesc {
    type Prepared = Perlin;
    const MAX_INPUTS: u64 = 2;

    fn sources(&self, visit: &mut dyn FnMut(ColorSource)) {
        visit(self.low);
        visit(self.high);
    }

    fn mapping(&self) -> Mapping {
        self.mapping
    }

    fn triplanar(&self) -> Option<(f64, Transform)> {
        (self.mapping == Mapping::Triplanar).then_some((self.blend, self.transform))
    }

    fn prepare(&self, _: &mut PrepareContext<'_>) -> Result<Perlin, SceneError> {
        let desc = PerlinDesc { octaves: self.octaves.clamp(1, 16), ..self.clone() };
        Ok(Perlin { desc, placement: Placement::new(self.mapping, self.density, self.transform) })
    }
}

impl Perlin {
    pub(super) fn eval(&self, textures: &Textures, at: &TexturePoint<'_>) -> Spectrum {
        let d = &self.desc;
        let (p, width) = (self.placement.coordinates(at), self.placement.width(at));
        let (low, high) = (textures.color(d.low, at), textures.color(d.high, at));
        let value = match d.kind {
            PerlinKind::Fbm => fbm(p, width, d.gain, d.octaves),
            PerlinKind::Wrinkled => turbulence(p, width, d.gain, d.octaves),
            PerlinKind::Windy => fbm(0.1 * p, 0.1 * width, 0.5, 3).abs() * fbm(p, width, 0.5, 6),
            PerlinKind::Dots => f64::from(in_dot(DVec2::new(p.x, p.y))),
            PerlinKind::Marble => {
                let phase = p.y + d.variation * fbm(p, width, d.gain, d.octaves);
                let stone = stone(0.5 + 0.5 * sin(phase));
                return low + (high - low) * stone;
            }
        };
        low + (high - low) * value as f32
    }

    /// See [`Placement::spacing`].
    pub(super) fn spacing(&self, _: &Textures, at: &TexturePoint<'_>) -> Option<f64> {
        self.placement.spacing(at)
    }

    pub(super) fn memory(&self) -> usize {
        0
    }
}

/// The permutation of 0 to 255 of the reference implementation.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99,
    37, 240, 21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32,
    57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27,
    166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244,
    102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130,
    116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147,
    118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119,
    248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110,
    79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179,
    162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184, 84, 204, 176,
    115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195, 78,
    66, 215, 61, 156, 180,
];

/// The reference noise: about ±1, mean 0, 0 at integer coordinates; it repeats with period 256.
pub(crate) fn noise(p: DVec3) -> f64 {
    let cell = [p.x, p.y, p.z].map(floor);
    let d = p - DVec3::new(cell[0] as f64, cell[1] as f64, cell[2] as f64);
    let [x, y, z] = cell.map(|v| v as u8);
    let at = |i: usize| PERMUTATION.get(i & 255).map_or(0, |v| usize::from(*v));
    let corner = |i: u8, j: u8, k: u8| {
        // Sums beyond 255 wrap around.
        let hash = at(at(at(usize::from(x.wrapping_add(i))) + usize::from(y) + usize::from(j))
            + usize::from(z)
            + usize::from(k))
            & 15;
        let d = d - DVec3::new(f64::from(i), f64::from(j), f64::from(k));
        let odd = matches!(hash, 12 | 13);
        let u = if hash < 8 || odd { d.x } else { d.y };
        let v = if hash < 4 || odd { d.y } else { d.z };
        (if hash & 1 == 0 { u } else { -u }) + (if hash & 2 == 0 { v } else { -v })
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let lerp = |t: f64, a: f64, b: f64| a + t * (b - a);
    let (wx, wy, wz) = (fade(d.x), fade(d.y), fade(d.z));
    let row = |j, k| lerp(wx, corner(0, j, k), corner(1, j, k));
    let side = |k| lerp(wy, row(0, k), row(1, k));
    lerp(wz, side(0), side(1))
}

/// The number of octaves that a footprint of a width resolves completely, and the weight of the next one.
fn octaves(width: f64, max_octaves: u32) -> (u32, f64) {
    if width <= 0.0 {
        return (max_octaves, 0.0);
    }
    // A footprint of width 2^-(n + 1) keeps n octaves.
    let n = (-1.0 - ln(width) / std::f64::consts::LN_2).clamp(0.0, f64::from(max_octaves));
    let whole = n as u32;
    (whole, smoothstep(0.3, 0.7, n - f64::from(whole)))
}

fn fbm(p: DVec3, width: f64, gain: f64, max_octaves: u32) -> f64 {
    let (whole, part) = octaves(width, max_octaves);
    let (mut sum, mut scale, mut weight) = (0.0, 1.0, 1.0);
    for _ in 0..whole {
        sum += weight * noise(scale * p);
        scale *= 1.99;
        weight *= gain;
    }
    if part > 0.0 { sum + weight * part * noise(scale * p) } else { sum }
}

/// Mean absolute value of octaves that are too fine.
const MEAN_ABS: f64 = 0.2;

fn turbulence(p: DVec3, width: f64, gain: f64, max_octaves: u32) -> f64 {
    let (whole, part) = octaves(width, max_octaves);
    let (mut sum, mut scale, mut weight) = (0.0, 1.0, 1.0);
    for _ in 0..whole {
        sum += weight * noise(scale * p).abs();
        scale *= 1.99;
        weight *= gain;
    }
    // As in pbrt: one octave more than requested, and in addition the mean of the omitted ones.
    sum += weight * (MEAN_ABS + part * (noise(scale * p).abs() - MEAN_ABS));
    for _ in whole..max_octaves {
        sum += weight * MEAN_ABS;
        weight *= gain;
    }
    sum
}

/// Whether a point is in a dot: about every second square has one, of radius 0.35.
fn in_dot(p: DVec2) -> bool {
    const RADIUS: f64 = 0.35;
    const SHIFT: f64 = 0.5 - RADIUS;
    let cell = DVec2::new(floor(p.x + 0.5) as f64, floor(p.y + 0.5) as f64);
    let noise = |dx: f64, dy: f64| noise(DVec3::new(cell.x + dx, cell.y + dy, 0.5));
    if noise(0.5, 0.5) <= 0.0 {
        return false;
    }
    let center = cell + SHIFT * DVec2::new(noise(1.5, 2.8), noise(4.5, 9.8));
    (p - center).length_squared() < RADIUS * RADIUS
}

/// The colour of marble across its veins, `t` from 0 to 1: cubic Bézier curves with these control points.
fn stone(t: f64) -> Spectrum {
    const WHITE: Spectrum = Spectrum::new(0.58, 0.58, 0.6);
    const COLORS: [Spectrum; 9] = [
        WHITE,
        WHITE,
        WHITE,
        Spectrum::new(0.5, 0.5, 0.5),
        Spectrum::new(0.6, 0.59, 0.58),
        WHITE,
        WHITE,
        Spectrum::new(0.2, 0.2, 0.33),
        WHITE,
    ];
    let t = 6.0 * t.clamp(0.0, 1.0);
    let first = (t as usize).min(5);
    let t = (t - first as f64) as f32;
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| COLORS[(first + i).min(8)]);
    let s = 1.0 - t;
    (a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)) * 1.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_a_permutation() {
        let mut seen = PERMUTATION;
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(i, v)| i == usize::from(*v)));
    }

    #[test]
    fn noise_is_that_of_the_reference() {
        // Values from an independent implementation (pbrt-v4).
        for (p, expected) in [
            ([0.3, 0.4, 0.5], 0.0989154),
            ([1.7, -2.2, 3.9], -0.0264796),
            ([-0.1, 0.9, -5.3], 0.1692336),
            ([100.25, 200.75, 300.4], 0.1740233),
            ([255.5, 255.6, 255.7], -0.2404296),
        ] {
            let found = noise(DVec3::from(p));
            assert!((found - expected).abs() < 1e-5, "{p:?}: {found} for {expected}");
        }
        assert_eq!(noise(DVec3::new(3.0, -7.0, 200.0)), 0.0);
    }

    #[test]
    fn octaves_finer_than_the_footprint_give_way() {
        let p = DVec3::new(0.3, 1.7, -2.2);
        assert_eq!(octaves(0.0, 8), (8, 0.0));
        assert_eq!(octaves(0.125, 8).0, 2);
        assert_eq!(fbm(p, 1.0, 0.5, 8), 0.0);
        let sharp = turbulence(p, 0.0, 0.5, 8);
        assert!(sharp > 0.0 && (turbulence(p, 100.0, 0.5, 8) - 0.6).abs() < 0.01, "{sharp}");
    }

    #[test]
    fn dots_are_round_and_in_half_of_the_squares() {
        let inside = (0..40_000)
            .filter(|i| in_dot(DVec2::new(f64::from(i % 200) * 0.1 + 0.03, f64::from(i / 200) * 0.1 + 0.03)))
            .count();
        // π 0.35² of a square.
        let fraction = inside as f64 / 40_000.0 / 0.385;
        assert!((0.35..0.65).contains(&fraction), "{fraction}");
    }
}
