//! Debug views: the camera ray, its first hit, and the value shown.

use turner::color::Spectrum;

use super::model::{Kind, Node, SampleTree};
use super::number::{exact, number, vector};
use super::record::FirstHit;

/// Adds the camera ray.
pub(super) fn grow(out: &mut SampleTree, integrator: &str, first: &FirstHit<'_>) {
    let shown = out.rendered;
    out.parts.push((0, "shown", shown));
    let Some(ray) = &first.camera else {
        out.remarks.push("outside the image of the camera".to_owned());
        return;
    };
    let mut node = Node::new(Kind::Camera, None, ray.origin, ray.direction);
    node.contribution = shown;
    node.weight = Spectrum::WHITE;
    let what = match &first.hit {
        Some(hit) => {
            node.to = Some(hit.position);
            node.target = hit.object.label();
            node.material = Some(hit.material.label());
            (node.primitive, node.shape) = (Some(hit.object.primitive), hit.object.shape);
            node.touches = hit.touches;
            let [u, v] = hit.uv.map(number);
            node.rows = vec![
                ("t", number(hit.t)),
                ("origin", vector(ray.origin)),
                ("direction", vector(ray.direction)),
                ("hits", format!("{}, uv ({u}, {v})", vector(hit.position))),
                ("normal", vector(hit.geometric_normal)),
            ];
            if hit.shading_normal != hit.geometric_normal {
                node.rows.push(("shading normal", vector(hit.shading_normal)));
            }
            format!("at the first hit, distance {}", number(hit.t))
        }
        None => {
            node.target = "nothing".to_owned();
            "where the ray hits no surface".to_owned()
        }
    };
    out.remarks.push(format!("\"{integrator}\" shows {} {what}", exact(shown)));
    out.nodes.push(node);
}
