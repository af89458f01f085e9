//! A transform as position, rotation and scale.

use egui::{DragValue, Ui};
use turner::math::elementary::{asin, atan2};
use turner::math::{DAffine3, DVec3};
use turner::schema::transform::rotation;

use super::name_number;

/// Position, rotation about x, y and z in degrees (in this order), scale along the object's axes. `None` for transforms
/// with shear, which these do not describe.
pub(crate) fn decompose(m: &DAffine3) -> Option<[DVec3; 3]> {
    let columns = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis];
    let mut scale = DVec3::from_array(columns.map(|c| c.length()));
    if m.matrix3.determinant() < 0.0 {
        scale.z = -scale.z;
    }
    let [x, y, z] = [columns[0] / scale.x, columns[1] / scale.y, columns[2] / scale.z];
    if x.dot(y).abs() > 1e-6 || y.dot(z).abs() > 1e-6 || x.dot(z).abs() > 1e-6 || !m.is_finite() {
        return None;
    }
    // R = Rz Ry Rx: its first column is (cz cy, sz cy, -sy), its last row (-sy, cy sx, cy cx).
    let sin_y = (-x.z).clamp(-1.0, 1.0);
    let angles = if sin_y.abs() < 1.0 - 1e-9 {
        DVec3::new(atan2(y.z, z.z), asin(sin_y), atan2(x.y, x.x))
    } else {
        DVec3::new(atan2(-z.y, y.y), asin(sin_y), 0.0)
    };
    // No angle of -0.
    let degrees = angles.to_array().map(|angle| angle.to_degrees() + 0.0);
    Some([m.translation, DVec3::from_array(degrees), scale])
}

/// The transform of position, rotation in degrees and scale.
pub(crate) fn compose([position, degrees, scale]: [DVec3; 3]) -> DAffine3 {
    let turned =
        rotation(DVec3::Z, degrees.z) * rotation(DVec3::Y, degrees.y) * rotation(DVec3::X, degrees.x);
    DAffine3::from_translation(position) * DAffine3::from_mat3(turned) * DAffine3::from_scale(scale)
}

/// Edits the transform of an object. Returns the new one if it changed.
pub(crate) fn edit(ui: &mut Ui, m: &DAffine3) -> Option<DAffine3> {
    edit_named(ui, m, "")
}

/// The same for a transform whose widgets have the name of its key, too.
pub(crate) fn edit_named(ui: &mut Ui, m: &DAffine3, key: &str) -> Option<DAffine3> {
    let key = if key.is_empty() { String::new() } else { format!("{key}, ") };
    let Some(mut parts) = decompose(m) else { return matrix(ui, m, &key) };
    let mut changed = false;
    let rows = [("Position", 0.01), ("Rotation (degrees)", 0.5), ("Scale", 0.01)];
    for (part, (name, speed)) in parts.iter_mut().zip(rows) {
        ui.label(name);
        ui.horizontal(|ui| {
            for (value, axis) in [(&mut part.x, "x"), (&mut part.y, "y"), (&mut part.z, "z")] {
                let speed =
                    if name == "Rotation (degrees)" { speed } else { (value.abs() * speed).max(speed * 0.5) };
                let response = ui.add(DragValue::new(&mut *value).speed(speed).max_decimals(4));
                let label = format!("{key}{name}, {axis}");
                name_number(&response, &label, *value);
                changed |= response.changed();
            }
        });
        ui.end_row();
    }
    let smallest = parts[2].abs().min_element();
    (changed && smallest > 1e-9).then(|| compose(parts))
}

/// A transform with shear, as the rows of its matrix.
fn matrix(ui: &mut Ui, m: &DAffine3, key: &str) -> Option<DAffine3> {
    let mut columns = m.to_cols_array_2d();
    let mut changed = false;
    for row in 0..3 {
        ui.label(format!("Row {}", row + 1));
        ui.horizontal(|ui| {
            for (column, values) in columns.iter_mut().enumerate() {
                let response = ui.add(DragValue::new(&mut values[row]).speed(0.005).max_decimals(4));
                name_number(&response, &format!("{key}row {}, column {}", row + 1, column + 1), values[row]);
                changed |= response.changed();
            }
        });
        ui.end_row();
    }
    let new = DAffine3::from_cols_array_2d(&columns);
    (changed && new.matrix3.determinant().abs() > 1e-12).then_some(new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_transform_give_it_back() {
        let angles = [-170.0, -90.0, -35.0, 0.0, 20.0, 90.0, 145.0];
        for x in angles {
            for y in angles {
                for z in angles {
                    let parts = [DVec3::new(1.0, 2.0, -3.0), DVec3::new(x, y, z), DVec3::new(0.5, 2.0, 1.5)];
                    let m = compose(parts);
                    let again = compose(decompose(&m).unwrap());
                    assert!(m.abs_diff_eq(again, 1e-9), "{x} {y} {z}\n{m:?}\n{again:?}");
                }
            }
        }
    }

    #[test]
    fn mirrors_stay_mirrors_and_shear_is_refused() {
        let m = DAffine3::from_scale(DVec3::new(1.0, 1.0, -2.0));
        assert!(m.abs_diff_eq(compose(decompose(&m).unwrap()), 1e-12));
        let mut shear = DAffine3::IDENTITY;
        shear.matrix3.x_axis.y = 0.5;
        assert!(decompose(&shear).is_none());
    }
}
