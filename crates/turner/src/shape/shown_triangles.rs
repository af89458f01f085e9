//! Which triangles of a mesh can be shown.

use super::triangle_mesh::{LeftOut, area_normal, wide};
use crate::math::Bounds;
use crate::schema::MeshData;

/// What there is to show: bounds, areas, what is left out, and the list without flat triangles if there are any.
pub(super) struct Shown {
    pub(super) bounds: Bounds,
    /// Half the areas of the triangles' boxes, in all.
    pub(super) areas: f64,
    pub(super) left_out: LeftOut,
    pub(super) triangles: Option<Vec<[u32; 3]>>,
}

impl Shown {
    pub(super) fn of(data: &MeshData) -> Shown {
        let mut shown =
            Shown { bounds: Bounds::EMPTY, areas: 0.0, left_out: LeftOut::default(), triangles: None };
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (i, t) in data.triangles.iter().enumerate() {
            let v = t.map(|i| data.positions[i as usize]);
            if !v.iter().flatten().all(|x| x.is_finite()) {
                // The tree leaves it out by itself.
                shown.left_out.non_finite += 1;
                continue;
            }
            let area = area_normal(&v).length_squared();
            if !(area > 0.0 && area < f64::INFINITY) {
                shown.left_out.flat += 1;
                // A triangle of one corner, which the tree leaves out.
                shown.triangles.get_or_insert_with(|| data.triangles.clone())[i] = [t[0]; 3];
                continue;
            }
            let [x, y, z] = [0, 1, 2].map(|axis| {
                let [a, b, c] = v.map(|corner| corner[axis]);
                f64::from(a.max(b).max(c)) - f64::from(a.min(b).min(c))
            });
            shown.areas += x * y + y * z + z * x;
            for v in v {
                for axis in 0..3 {
                    min[axis] = min[axis].min(v[axis]);
                    max[axis] = max[axis].max(v[axis]);
                }
            }
        }
        if min[0] <= max[0] {
            shown.bounds = Bounds::new(wide(min), wide(max));
        }
        shown
    }
}
