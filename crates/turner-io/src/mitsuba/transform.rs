//! Transforms: a list of steps that are applied in order, to column vectors.

use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::ErrorCode;
use turner::schema::transform::rotation;

use super::document::{Document, Node};
use super::params::numbers;
use crate::assets::printable;
use crate::scene_import::report::Fault;
use crate::scene_import::unknown;

/// Most steps of one transform.
const MAX_STEPS: usize = 4096;

/// The transform of an element `transform`.
pub(super) fn of(document: &Document, node: &Node) -> Result<DAffine3, Fault> {
    let mut all = DAffine3::IDENTITY;
    if node.children.len() > MAX_STEPS {
        let message = format!("more than {MAX_STEPS} steps of a transform");
        return Err(Fault::at(node.place, ErrorCode::TooLarge, message));
    }
    for step in node.children.iter().filter_map(|c| document.node(*c)) {
        all = one(step)? * all;
    }
    if all.is_finite() {
        return Ok(all);
    }
    Err(Fault::at(node.place, ErrorCode::Transform, "the numbers of a transform are too large"))
}

fn one(step: &Node) -> Result<DAffine3, Fault> {
    let bad = |problem: &str| Fault::at(step.place, ErrorCode::Transform, problem.to_owned());
    Ok(match step.tag.as_str() {
        "translate" => DAffine3::from_translation(vector(step, 0.0)?),
        "scale" => DAffine3::from_scale(vector(step, 1.0)?),
        "rotate" => {
            let axis = vector(step, 0.0)?.try_normalize();
            let axis = axis.ok_or_else(|| bad("the axis of a rotation must not be zero"))?;
            let angle = attribute(step, "angle")?.unwrap_or(0.0);
            DAffine3::from_mat3(rotation(axis, angle))
        }
        "lookat" => {
            let point = |key: &str, or: DVec3| match step.attribute(key) {
                None => Ok(or),
                Some(text) => triple(text).ok_or_else(|| bad(&format!("{key}: expected three numbers"))),
            };
            let origin = point("origin", DVec3::ZERO)?;
            let target = point("target", DVec3::Z)?;
            let up = point("up", DVec3::ZERO)?;
            let forward = (target - origin).try_normalize();
            let forward = forward.ok_or_else(|| bad("origin and target of a lookat are equal"))?;
            // Without an up vector any will do.
            let up = if up == DVec3::ZERO { turner::math::Frame::from_z(forward).y } else { up };
            let left = up.cross(forward).try_normalize();
            let left = left.ok_or_else(|| bad("up is parallel to the viewing direction of a lookat"))?;
            let matrix = DMat3::from_cols(left, forward.cross(left), forward);
            DAffine3::from_mat3_translation(matrix, origin)
        }
        "matrix" => {
            let text = step.attribute("value").unwrap_or_default();
            let m = numbers(text, 16).ok_or_else(|| bad("a matrix needs 16 or 9 numbers"))?;
            match m[..] {
                [a, b, c, d, e, f, g, h, i] => DAffine3::from_mat3(rows([[a, b, c], [d, e, f], [g, h, i]])),
                [a, b, c, x, d, e, f, y, g, h, i, z, p, q, r, w] => {
                    if [p, q, r].iter().any(|v| v.abs() > 1e-6 * w.abs()) || w == 0.0 {
                        return Err(bad("a matrix whose last row is not 0 0 0 1"));
                    }
                    let matrix = rows([[a, b, c], [d, e, f], [g, h, i]]) * w.recip();
                    DAffine3::from_mat3_translation(matrix, DVec3::new(x, y, z) / w)
                }
                _ => return Err(bad(&format!("a matrix of {} numbers; expected 16 or 9", m.len()))),
            }
        }
        other => {
            let all = ["translate", "rotate", "scale", "matrix", "lookat"];
            return Err(unknown("step of a transform", other, &all).or_at(step.place));
        }
    })
}

fn rows(r: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols(DVec3::from(r[0]), DVec3::from(r[1]), DVec3::from(r[2])).transpose()
}

/// Three numbers, or one for all.
pub(super) fn triple(text: &str) -> Option<DVec3> {
    match numbers(text, 3)?[..] {
        [x, y, z] => Some(DVec3::new(x, y, z)),
        [v] => Some(DVec3::splat(v)),
        _ => None,
    }
}

fn attribute(node: &Node, key: &str) -> Result<Option<f64>, Fault> {
    let Some(text) = node.attribute(key) else { return Ok(None) };
    super::params::number(text).map(Some).ok_or_else(|| {
        let message = format!("{key} is \"{}\"; expected a number", printable(text));
        Fault::at(node.place, ErrorCode::WrongType, message)
    })
}

/// `value="x, y, z"`, or x, y and z with the default `or`.
pub(super) fn vector(node: &Node, or: f64) -> Result<DVec3, Fault> {
    if let Some(text) = node.attribute("value") {
        return triple(text).ok_or_else(|| {
            let message = format!("\"{}\": expected three numbers", printable(text));
            Fault::at(node.place, ErrorCode::WrongType, message)
        });
    }
    let part = |key| attribute(node, key).map(|v| v.unwrap_or(or));
    Ok(DVec3::new(part("x")?, part("y")?, part("z")?))
}
