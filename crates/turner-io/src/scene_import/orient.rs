//! The orientation of triangles.

use turner::math::DVec3;
use turner::schema::MeshData;

/// Orients each triangle so that its geometric normal lies on the side of its shading normals. `reverse` flips
/// the shading normals first. A mesh without shading normals is flipped if `reverse` is set.
pub(crate) fn orient(data: &mut MeshData, reverse: bool) {
    if data.normals.is_empty() {
        if reverse {
            data.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        return;
    }
    if reverse {
        data.normals.iter_mut().flatten().for_each(|v| *v = -*v);
    }
    let corner = |i: u32| data.positions.get(i as usize).copied().unwrap_or_default();
    let normal = |i: u32| data.normals.get(i as usize).copied().unwrap_or_default();
    for t in &mut data.triangles {
        let [a, b, c] = t.map(|i| DVec3::from(corner(i).map(f64::from)));
        let flat = (b - a).cross(c - a);
        let shading = t.iter().fold(DVec3::ZERO, |sum, i| sum + DVec3::from(normal(*i).map(f64::from)));
        if flat.dot(shading) < 0.0 {
            t.swap(1, 2);
        }
    }
}
