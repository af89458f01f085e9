//! Integrators that show what a ray meets first: that, and what they show of it.

use turner::color::Spectrum;
use turner::render::{SampleRecord, camera_ray};

use super::model::{Kind, Node, SampleTree};
use super::names::Names;
use super::number::{exact, number, vector};

pub(super) fn tree(
    names: &Names<'_>,
    number_of: usize,
    sample: SampleRecord,
    wanted: Option<&str>,
) -> SampleTree {
    let scene = names.scene;
    let shown = sample.radiance.color;
    let mut out = SampleTree::new(number_of, sample, shown);
    out.parts.push((0, "shown", shown));
    let integrator = scene.integrator.type_name();
    let Some(ray) = camera_ray(scene, sample.id, sample.place) else {
        out.remarks.push("the camera shows nothing here".to_owned());
        return out;
    };
    let mut node = Node::new(Kind::Camera, None, ray.origin, ray.direction);
    node.contribution = shown;
    node.weight = Spectrum::WHITE;
    let what = match scene.intersect(&ray) {
        Some(hit) => {
            let surface = scene.surface(&ray, &hit);
            let (primitive, shape) = (scene.primitive_id(&hit), scene.shape_word(&hit));
            node.to = Some(surface.p);
            node.target = names.object(primitive, shape);
            node.material = Some(names.material(surface.material));
            (node.primitive, node.shape) = (Some(primitive), shape);
            node.touches = wanted.is_some_and(|w| names.is(w, primitive, shape, surface.material));
            let uv = scene.texture_point(&surface).uv;
            node.rows = vec![
                ("t", number(hit.shape.t)),
                ("from", vector(ray.origin)),
                ("towards", vector(ray.direction)),
                ("hits", format!("{}, uv ({}, {})", vector(surface.p), number(uv.x), number(uv.y))),
                ("normal", vector(surface.ng)),
            ];
            if surface.ns != surface.ng {
                node.rows.push(("shading normal", vector(surface.ns)));
            }
            format!("at the first surface, {} away", number(hit.shape.t))
        }
        None => {
            node.target = "nothing".to_owned();
            "where no surface is".to_owned()
        }
    };
    out.remarks.push(format!("\"{integrator}\" shows {} {what}", exact(shown)));
    out.nodes.push(node);
    out.add_up();
    out
}
