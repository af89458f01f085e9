//! Similarity transforms: rotation, uniform scale, translation.

use crate::math::DAffine3;

/// The scale factor of a similarity transform; `None` for other transforms.
pub(crate) fn similarity(to_world: &DAffine3) -> Option<f64> {
    let m = to_world.matrix3;
    let l2 = m.x_axis.length_squared();
    let even = |v: f64| (v - l2).abs() <= 1e-9 * l2;
    let square = |v: f64| v.abs() <= 1e-9 * l2;
    let similar = even(m.y_axis.length_squared())
        && even(m.z_axis.length_squared())
        && square(m.x_axis.dot(m.y_axis))
        && square(m.y_axis.dot(m.z_axis))
        && square(m.z_axis.dot(m.x_axis));
    similar.then_some(l2.sqrt())
}
