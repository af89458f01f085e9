//! Pixels that are not traced: those between four neighbours on one plane surface.

use crate::color::Spectrum;
use crate::preview::buffers::Sample;

/// The largest relative difference of colours that counts as none.
const COLOR: f32 = 0.03;
/// The same for distances from a plane.
const PLANE: f32 = 0.002;
/// Least cosine between normals.
const COSINE: f32 = 0.98;

fn alike(a: Spectrum, b: Spectrum) -> bool {
    let near = |a: f32, b: f32| (a - b).abs() <= COLOR * a.abs().max(b.abs()) + 1e-4;
    near(a.r, b.r) && near(a.g, b.g) && near(a.b, b.b)
}

/// Whether two samples show the same surface in the same way.
fn same(a: &Sample, b: &Sample) -> bool {
    let cosine = a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1] + a.normal[2] * b.normal[2];
    a.object == b.object
        && a.key == b.key
        && a.alpha == b.alpha
        && a.is_catcher == b.is_catcher
        && a.roughness == b.roughness
        && (cosine >= COSINE || a.length == f32::INFINITY && b.length == f32::INFINITY)
        && alike(a.albedo, b.albedo)
        && alike(a.seen, b.seen)
        && alike(a.bounced, b.bounced)
}

/// Whether the middle of two points lies between two others in the same plane.
fn is_flat(a: f32, b: f32, other: f32) -> bool {
    let (middle, other) = (0.5 / a + 0.5 / b, 1.0 / other);
    (middle - other).abs() <= PLANE * middle.abs().max(other)
}

/// The sample between neighbours to the left and right, above and below; `None` if it must be traced.
pub(super) fn between(neighbours: [Option<&Sample>; 4]) -> Option<Sample> {
    let [left, right, above, below] = neighbours;
    let (a, b) = match (left, right, above, below) {
        (Some(a), Some(b), ..) | (_, _, Some(a), Some(b)) => (a, b),
        _ => return None,
    };
    for other in neighbours.into_iter().flatten() {
        if !same(a, other) || !(is_flat(a.length, b.length, other.length) || is_end(a, b, other)) {
            return None;
        }
    }
    if let [Some(l), Some(r), Some(u), Some(d)] = neighbours {
        let (across, along) = (0.5 / l.length + 0.5 / r.length, 0.5 / u.length + 0.5 / d.length);
        if (across - along).abs() > PLANE * across.max(along) {
            return None;
        }
    }
    let mix = |x: Spectrum, y: Spectrum| (x + y) * 0.5;
    let length = 2.0 / (1.0 / a.length + 1.0 / b.length);
    Some(Sample {
        seen: mix(a.seen, b.seen),
        bounced: mix(a.bounced, b.bounced),
        albedo: mix(a.albedo, b.albedo),
        direct: Spectrum::BLACK,
        gloss: Spectrum::BLACK,
        is_lit: false,
        indirect: Spectrum::BLACK,
        second: Spectrum::BLACK,
        normal: std::array::from_fn(|i| 0.5 * (a.normal[i] + b.normal[i])),
        length,
        depth: 2.0 / (1.0 / a.depth + 1.0 / b.depth),
        first_normal: std::array::from_fn(|i| 0.5 * (a.first_normal[i] + b.first_normal[i])),
        ..*a
    })
}

/// Whether `other` is one of the two points, or no point has a distance.
fn is_end(a: &Sample, b: &Sample, other: &Sample) -> bool {
    std::ptr::eq(a, other) || std::ptr::eq(b, other) || a.length == f32::INFINITY || is_near(a, b, other)
}

/// Whether the distance of `other` is about that of the two points: where only three neighbours are known.
fn is_near(a: &Sample, b: &Sample, other: &Sample) -> bool {
    let middle = 0.5 / a.length + 0.5 / b.length;
    (1.0 / other.length - middle).abs() <= 10.0 * PLANE * middle
}
