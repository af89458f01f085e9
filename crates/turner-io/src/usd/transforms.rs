//! The transforms of prims: `xformOpOrder` and its operations (UsdGeomXformable).
//!
//! USD multiplies row vectors by matrices from the left; the operations of the order are written from the outermost to
//! the innermost, so that the matrix for column vectors is their product in the order of the list.

use turner::math::{DAffine3, DMat3, DVec3};

use super::stage::{Prim, Stage};
use super::value::{Read, Value};

/// The transform of a prim to its parent, and whether it begins anew from the stage's space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    pub(super) transform: DAffine3,
    pub(super) resets: bool,
}

/// The transform of a prim at the stage's time.
pub(super) fn local(stage: &Stage<'_>, prim: &Prim) -> Read<Local> {
    let mut local = Local { transform: DAffine3::IDENTITY, resets: false };
    let Some(Value::Texts(order)) = stage.value(prim, "xformOpOrder")? else { return Ok(local) };
    for entry in &order {
        if entry == "!resetXformStack!" {
            local = Local { transform: DAffine3::IDENTITY, resets: true };
            continue;
        }
        let (is_inverse, name) = match entry.strip_prefix("!invert!") {
            Some(name) => (true, name),
            None => (false, entry.as_str()),
        };
        let kind = name.strip_prefix("xformOp:").and_then(|n| n.split(':').next()).unwrap_or_default();
        let Some(made) = stage.value(prim, name)?.and_then(|value| operation(kind, &value)) else { continue };
        local.transform *= if is_inverse { made.inverse() } else { made };
    }
    Ok(local)
}

/// The matrix of an operation; `None` if the value does not fit.
fn operation(kind: &str, value: &Value) -> Option<DAffine3> {
    let vector = || match value {
        Value::Vector(v) => v.first_chunk::<3>().filter(|_| v.len() == 3).map(|v| DVec3::from(*v)),
        _ => None,
    };
    let turn = |axis: char, degrees: f64| match axis {
        'X' => DMat3::from_rotation_x(degrees.to_radians()),
        'Y' => DMat3::from_rotation_y(degrees.to_radians()),
        _ => DMat3::from_rotation_z(degrees.to_radians()),
    };
    let along = |axis: char| match axis {
        'X' => DVec3::X,
        'Y' => DVec3::Y,
        _ => DVec3::Z,
    };
    Some(match kind {
        "translate" => DAffine3::from_translation(vector()?),
        "scale" => DAffine3::from_scale(vector()?),
        "orient" => match value {
            Value::Vector(q) => DAffine3::from_mat3(rotation(q.first_chunk::<4>().copied()?)),
            _ => return None,
        },
        "transform" => match value {
            Value::Vector(m) => matrix(m)?,
            _ => return None,
        },
        "rotateX" | "rotateY" | "rotateZ" => DAffine3::from_mat3(turn(kind.chars().last()?, value.real()?)),
        "translateX" | "translateY" | "translateZ" => {
            DAffine3::from_translation(along(kind.chars().last()?) * value.real()?)
        }
        "scaleX" | "scaleY" | "scaleZ" => {
            let axis = along(kind.chars().last()?);
            DAffine3::from_scale(DVec3::ONE + axis * (value.real()? - 1.0))
        }
        "rotateXYZ" | "rotateXZY" | "rotateYXZ" | "rotateYZX" | "rotateZXY" | "rotateZYX" => {
            let angles = vector()?;
            // The first axis turns first.
            let turned = kind
                .strip_prefix("rotate")?
                .chars()
                .fold(DMat3::IDENTITY, |m, axis| turn(axis, angles.dot(along(axis))) * m);
            DAffine3::from_mat3(turned)
        }
        _ => return None,
    })
}

/// The matrix of sixteen numbers, whose last row of four is the translation.
pub(super) fn matrix(m: &[f64]) -> Option<DAffine3> {
    let m = m.first_chunk::<16>()?;
    let row = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
    Some(DAffine3 { matrix3: DMat3::from_cols(row(0), row(1), row(2)), translation: row(3) })
}

/// The matrix of a quaternion (w, x, y, z) of any length; one of length 0 is no rotation.
pub(super) fn rotation([w, x, y, z]: [f64; 4]) -> DMat3 {
    let length = (w * w + x * x + y * y + z * z).sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return DMat3::IDENTITY;
    }
    let [w, x, y, z] = [w, x, y, z].map(|v| v / length);
    DMat3::from_cols(
        DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        DVec3::new(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        DVec3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
}
