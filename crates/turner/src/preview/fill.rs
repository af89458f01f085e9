//! Pixels that are not traced: those between four neighbours on one plane surface.

use crate::color::Spectrum;
use crate::preview::buffers::Sample;

/// The largest relative difference of colours that counts as none.
const COLOR: f32 = 0.03;
/// The same for distances from a plane.
const PLANE: f32 = 0.002;
/// The same where the plane is unknown.
const EDGE: f32 = 0.02;
/// Least cosine between normals.
const COSINE: f32 = 0.98;

#[inline]
fn alike(a: Spectrum, b: Spectrum) -> bool {
    if a == b {
        return true;
    }
    let near = |a: f32, b: f32| (a - b).abs() <= COLOR * a.abs().max(b.abs()) + 1e-4;
    near(a.r, b.r) && near(a.g, b.g) && near(a.b, b.b)
}

/// Whether two samples show the same surface in the same way.
fn same(a: &Sample, b: &Sample) -> bool {
    let cosine = a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1] + a.normal[2] * b.normal[2];
    a.object == b.object
        && a.key == b.key
        && (cosine >= COSINE || a.near == 0.0 && b.near == 0.0)
        && a.roughness == b.roughness
        && a.alpha == b.alpha
        && a.is_catcher == b.is_catcher
        && alike(a.albedo, b.albedo)
        && alike(a.seen, b.seen)
        && alike(a.bounced, b.bounced)
}

/// The sample between neighbours to the left and right, above and below; `None` if it must be traced.
#[inline]
pub(super) fn between(neighbours: [Option<&Sample>; 4]) -> Option<Sample> {
    let [left, right, above, below] = neighbours;
    let (a, b) = match (left, right, above, below) {
        (Some(a), Some(b), ..) | (_, _, Some(a), Some(b)) => (a, b),
        _ => return None,
    };
    if !neighbours.into_iter().flatten().all(|other| same(a, other)) {
        return None;
    }
    let middle = 0.5 * (a.near + b.near);
    let is_flat = match neighbours {
        [Some(_), Some(_), Some(u), Some(d)] => (0.5 * (u.near + d.near) - middle).abs() <= PLANE * middle,
        // At the edge of a group one neighbour is unknown.
        _ => neighbours.into_iter().flatten().all(|other| (other.near - middle).abs() <= EDGE * middle),
    };
    if !is_flat {
        return None;
    }
    let mix = |x: Spectrum, y: Spectrum| (x + y) * 0.5;
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
        near: middle,
        first_near: 0.5 * (a.first_near + b.first_near),
        ..*a
    })
}
