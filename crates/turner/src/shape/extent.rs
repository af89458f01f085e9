//! How far the triangles of a mesh reach, and which of them can be shown.

use super::triangle_mesh::{SkippedTriangles, area_normal, wide};
use crate::math::Bounds;
use crate::schema::MeshData;

/// What there is to show of some triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub(crate) bounds: Bounds,
    /// Half the areas of the triangles' boxes, in all.
    pub(super) areas: f64,
    pub(super) left_out: SkippedTriangles,
}

/// Whether a triangle of finite corners has no area that can be hit.
fn is_flat(v: &[[f32; 3]; 3]) -> bool {
    let area = area_normal(v).length_squared();
    !(area > 0.0 && area < f64::INFINITY)
}

fn is_finite(v: &[[f32; 3]; 3]) -> bool {
    v.iter().flatten().all(|x| x.is_finite())
}

/// Whether a triangle can be hit.
pub(super) fn is_shown(v: &[[f32; 3]; 3]) -> bool {
    is_finite(v) && !is_flat(v)
}

impl Extent {
    pub(crate) const EMPTY: Extent =
        Extent { bounds: Bounds::EMPTY, areas: 0.0, left_out: SkippedTriangles { non_finite: 0, flat: 0 } };

    /// Of some triangles, their corners by number.
    pub(crate) fn of(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Extent {
        let mut extent = Extent::EMPTY;
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for t in triangles {
            let v = t.map(|i| positions[i as usize]);
            if !is_finite(&v) {
                // The tree leaves it out by itself.
                extent.left_out.non_finite += 1;
                continue;
            }
            if is_flat(&v) {
                extent.left_out.flat += 1;
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

    /// Of both.
    pub(crate) fn union(&self, other: &Extent) -> Extent {
        let SkippedTriangles { non_finite, flat } = other.left_out;
        Extent {
            bounds: self.bounds.union(&other.bounds),
            areas: self.areas + other.areas,
            left_out: SkippedTriangles {
                non_finite: self.left_out.non_finite + non_finite,
                flat: self.left_out.flat + flat,
            },
        }
    }
}

/// The triangles of a mesh, flat ones as triangles of one corner, which trees leave out.
pub(super) fn without_flat(data: &MeshData) -> Vec<[u32; 3]> {
    let corners = |t: &[u32; 3]| t.map(|i| data.positions[i as usize]);
    let shown = |t: &[u32; 3]| {
        let v = corners(t);
        if is_finite(&v) && is_flat(&v) { [t[0]; 3] } else { *t }
    };
    data.triangles.iter().map(shown).collect()
}
