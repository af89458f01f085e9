//! Value noise in two and three dimensions.

use super::random::hash;

/// The value at a lattice point, in -1..1.
fn lattice(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    let low = u64::from(x as u32) | u64::from(y as u32) << 32;
    let high = u64::from(z as u32) | u64::from(seed) << 32;
    let bits = hash(low ^ high.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    (bits >> 40) as f32 / (1 << 23) as f32 - 1.0
}

/// The cell of a coordinate, and the smoothed position in it (quintic fade, Perlin 2002).
fn cell(x: f32) -> (i32, f32) {
    let floor = x.floor();
    let t = x - floor;
    (floor as i32, t * t * t * (t * (t * 6.0 - 15.0) + 10.0))
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Value noise: smooth, about -1..1, features of size 1.
pub(super) fn noise3([x, y, z]: [f32; 3], seed: u32) -> f32 {
    let ((x, u), (y, v), (z, w)) = (cell(x), cell(y), cell(z));
    let edge = |y, z| mix(lattice(x, y, z, seed), lattice(x.wrapping_add(1), y, z, seed), u);
    let face = |z| mix(edge(y, z), edge(y.wrapping_add(1), z), v);
    mix(face(z), face(z.wrapping_add(1)), w)
}

/// Value noise in two dimensions.
pub(super) fn noise2([x, y]: [f32; 2], seed: u32) -> f32 {
    let ((x, u), (y, v)) = (cell(x), cell(y));
    let edge = |y| mix(lattice(x, y, 0, seed), lattice(x.wrapping_add(1), y, 0, seed), u);
    mix(edge(y), edge(y.wrapping_add(1)), v)
}

/// Fractal noise: each octave has twice the frequency and half the amplitude.
pub(super) fn fractal3(p: [f32; 3], octaves: u32, seed: u32) -> f32 {
    octaves_of(octaves, |octave, scale| noise3(p.map(|x| x * scale), seed.wrapping_add(octave)))
}

/// [`fractal3`] in two dimensions.
pub(super) fn fractal2(p: [f32; 2], octaves: u32, seed: u32) -> f32 {
    octaves_of(octaves, |octave, scale| noise2(p.map(|x| x * scale), seed.wrapping_add(octave)))
}

fn octaves_of(octaves: u32, noise: impl Fn(u32, f32) -> f32) -> f32 {
    // Not exactly 2, so that the lattices do not coincide.
    const FINER: f32 = 2.03;
    let (mut sum, mut scale, mut strength) = (0.0, 1.0, 1.0);
    for octave in 0..octaves {
        sum += strength * noise(octave, scale);
        scale *= FINER;
        strength *= 0.5;
    }
    sum
}
