//! The bounds of a mesh's triangles, and which triangles rays can hit.

use super::triangle_mesh::{SkippedTriangles, area_normal, wide};
use crate::math::Bounds;
use crate::schema::MeshData;

/// Bounds, box areas and skipped triangles of a set of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) bounds: Bounds,
    /// Sum of the half surface areas of the triangles' bounding boxes.
    pub(super) areas: f64,
    pub(super) skipped: SkippedTriangles,
}

/// Whether a triangle with finite vertices is degenerate: no area that a ray can hit.
fn is_flat(v: &[[f32; 3]; 3]) -> bool {
    let area = area_normal(v).length_squared();
    !(area > 0.0 && area < f64::INFINITY)
}

fn is_finite(v: &[[f32; 3]; 3]) -> bool {
    v.iter().flatten().all(|x| x.is_finite())
}

/// Whether a ray can hit the triangle.
pub(super) fn is_hittable(v: &[[f32; 3]; 3]) -> bool {
    is_finite(v) && !is_flat(v)
}

impl Extent {
    pub(crate) const EMPTY: Extent =
        Extent { bounds: Bounds::EMPTY, areas: 0.0, skipped: SkippedTriangles { non_finite: 0, flat: 0 } };

    /// The extent of indexed triangles.
    pub(crate) fn of(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Extent {
        let mut extent = Extent::EMPTY;
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for t in triangles {
            let v = t.map(|i| positions[i as usize]);
            if !is_finite(&v) {
                // The tree skips it, too.
                extent.skipped.non_finite += 1;
                continue;
            }
            if is_flat(&v) {
                extent.skipped.flat += 1;
                continue;
            }
            let [x, y, z] = [0, 1, 2].map(|axis| {
                let [a, b, c] = v.map(|corner| corner[axis]);
                f64::from(a.max(b).max(c)) - f64::from(a.min(b).min(c))
            });
            extent.areas += x * y + y * z + z * x;
            for v in v {
                for axis in 0..3 {
                    min[axis] = min[axis].min(v[axis]);
                    max[axis] = max[axis].max(v[axis]);
                }
            }
        }
        if min[0] <= max[0] {
            extent.bounds = Bounds::new(wide(min), wide(max));
        }
        extent
    }

    /// The extent of both sets together.
    pub(crate) fn union(&self, other: &Extent) -> Extent {
        let SkippedTriangles { non_finite, flat } = other.skipped;
        Extent {
            bounds: self.bounds.union(&other.bounds),
            areas: self.areas + other.areas,
            skipped: SkippedTriangles {
                non_finite: self.skipped.non_finite + non_finite,
                flat: self.skipped.flat + flat,
            },
        }
    }
}

/// The triangles of a mesh, with degenerate ones replaced by [i, i, i], which tree builders skip.
pub(super) fn without_flat(data: &MeshData) -> Vec<[u32; 3]> {
    let corners = |t: &[u32; 3]| t.map(|i| data.positions[i as usize]);
    let hittable = |t: &[u32; 3]| {
        let v = corners(t);
        if is_finite(&v) && is_flat(&v) { [t[0]; 3] } else { *t }
    };
    data.triangles.iter().map(hittable).collect()
}
