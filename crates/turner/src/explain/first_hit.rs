//! Debug views: the camera ray, its first hit, and the value shown.

use crate::color::Spectrum;

use super::model::{Kind, RayNode, SampleTree};
use super::names::Names;
use super::number::exact;
use super::replay::FirstHit;
use super::term::{Term, fill, number, vector};

/// Adds the camera ray.
pub(super) fn grow(out: &mut SampleTree, names: &Names<'_>, first: &FirstHit) {
    let shown = out.rendered;
    out.parts.push((0, "shown", shown));
    let Some((origin, direction)) = first.camera else {
        out.remarks.push("outside the image of the camera".to_owned());
        return;
    };
    let mut node = RayNode::new(Kind::Camera, None, origin, direction);
    node.contribution = shown;
    node.weight = Spectrum::WHITE;
    let what = match &first.hit {
        Some(hit) => {
            node.to = Some(hit.position);
            node.distance = Some(hit.t);
            node.normal = Some(hit.shading_normal);
            names.hit(&mut node, hit.primitive, hit.shape, hit.material);
            let [u, v] = hit.uv.map(number);
            node.terms = vec![
                Term::new("t", number(hit.t)),
                Term::new("origin", vector(origin)),
                Term::new("direction", vector(direction)),
                Term::new("hits", fill!("{}, uv ({}, {})", vector(hit.position), u, v)),
                Term::new("normal", vector(hit.geometric_normal)),
            ];
            if hit.shading_normal != hit.geometric_normal {
                node.terms.push(Term::new("shading normal", vector(hit.shading_normal)));
            }
            format!("at the first hit, distance {}", number(hit.t))
        }
        None => {
            node.target = "nothing".to_owned();
            "where the ray hits no surface".to_owned()
        }
    };
    let integrator = names.desc.integrator.type_name();
    out.remarks.push(format!("\"{integrator}\" shows {} {what}", exact(shown)));
    out.nodes.push(node);
}
