//! The ray tree of the classic integrator (Whitted 1980) as nodes.

use turner::color::Spectrum;
use turner::integrator::classic::{CutReason, RayKind, Seen};

use super::model::{Kind, Node, SampleTree};
use super::number::{color, number, rays, short, vector};
use super::record::classic::{Cut, Hit, Light, Occluder, Ray, Tree};

/// Adds the rays of a sample.
pub(super) fn grow(out: &mut SampleTree, tree: &Tree<'_>) {
    out.unrecorded = tree.unrecorded_rays;
    if tree.rays.is_empty() {
        out.remarks.push("outside the image of the camera".to_owned());
    }
    if tree.dropped_rays > 0 {
        let what = rays(tree.dropped_rays);
        out.remarks.push(format!("{what} not traced: the integrator's `max_rays` was reached"));
    }
    let mut builder = Builder { out, ray_nodes: Vec::with_capacity(tree.rays.len()) };
    for ray in &tree.rays {
        builder.ray(ray);
    }
}

struct Builder<'a> {
    out: &'a mut SampleTree,
    /// The node of each ray.
    ray_nodes: Vec<usize>,
}

fn kind(kind: RayKind) -> Kind {
    match kind {
        RayKind::Camera => Kind::Camera,
        RayKind::Reflected => Kind::Reflected,
        RayKind::Refracted => Kind::Refracted,
    }
}

fn seen(seen: Seen) -> &'static str {
    match seen {
        Seen::Background => "background",
        Seen::Lights => "a directional light",
        Seen::Ambient => "ambient light",
        Seen::Nothing => "nothing",
        Seen::Transparent => "transparent background",
    }
}

impl Builder<'_> {
    fn ray(&mut self, ray: &Ray<'_>) {
        let parent = ray.parent.and_then(|p| self.ray_nodes.get(p as usize).copied());
        let mut node = Node::new(kind(ray.kind), parent, ray.origin, ray.direction);
        node.weight = Spectrum::grey(ray.weight as f32);
        let index = self.out.nodes.len();
        self.ray_nodes.push(index);
        if let Some(miss) = &ray.miss {
            node.target = seen(miss.seen).to_owned();
            node.contribution = Spectrum::BLACK + miss.contribution;
            self.out.parts.push((index, seen(miss.seen), miss.contribution));
            node.rows.push(("origin", vector(ray.origin)));
            node.rows.push(("direction", vector(ray.direction)));
        }
        let Some(hit) = &ray.hit else { return self.out.nodes.push(node) };
        surface(&mut node, ray, hit);
        // Contributions in place of rays that were not traced belong to their own nodes.
        let own = hit.emission.into_iter().chain(hit.contribution);
        node.contribution = own.fold(Spectrum::BLACK, |sum, c| sum + c);
        self.out.nodes.push(node);
        let parts = [("emission", hit.emission), ("local colour", hit.contribution)];
        for (what, part) in parts {
            self.out.parts.extend(part.map(|c| (index, what, c)));
        }
        for term in &hit.lights {
            self.out.nodes.push(light(index, hit, term));
        }
        for cut in &hit.not_traced {
            self.cut(index, hit, cut);
        }
    }

    fn cut(&mut self, parent: usize, hit: &Hit<'_>, cut: &Cut) {
        let mut node = Node::new(kind(cut.kind), Some(parent), hit.position, cut.direction);
        node.weight = Spectrum::grey(cut.weight as f32);
        node.traced = false;
        node.target = match cut.seen {
            Seen::Nothing => "not traced".to_owned(),
            other => format!("not traced: replaced by {}", seen(other)),
        };
        node.remark = match cut.reason {
            CutReason::Depth => "`max_depth` is reached",
            CutReason::Count => "`max_rays` is reached",
        }
        .to_owned();
        node.contribution = cut.contribution;
        self.out.parts.push((self.out.nodes.len(), "in place of an untraced ray", cut.contribution));
        self.out.nodes.push(node);
    }
}

fn surface(node: &mut Node, ray: &Ray<'_>, hit: &Hit<'_>) {
    node.to = Some(hit.position);
    node.target = hit.object.label();
    node.material = Some(hit.material.label());
    (node.primitive, node.shape) = (Some(hit.object.primitive), hit.object.shape);
    node.touches = hit.touches;
    node.surface = Some(hit.color);
    let [local, reflect, refract] = [hit.k_local, hit.k_reflect, hit.k_refract];
    node.remark = match (hit.total_internal_reflection, refract > 0.0, hit.entering) {
        (true, ..) => "total internal reflection",
        (false, true, true) => "enters",
        (false, true, false) => "leaves",
        (false, false, false) => "hit from inside",
        (false, false, true) => "",
    }
    .to_owned();
    let rows = &mut node.rows;
    rows.push(("t", number(hit.t)));
    rows.push(("origin", vector(ray.origin)));
    rows.push(("direction", vector(ray.direction)));
    rows.push((
        "hits",
        format!("{}, uv ({}, {})", vector(hit.position), number(hit.uv[0]), number(hit.uv[1])),
    ));
    let tilted = match hit.shading_normal {
        n if n == hit.geometric_normal => String::new(),
        n => format!(", shading {}", vector(n)),
    };
    rows.push(("normal", format!("{}{tilted}", vector(hit.geometric_normal))));
    rows.push(("colour", color(hit.color)));
    let mut weights = format!("local {}", number(local));
    if reflect > 0.0 {
        weights += &format!(", reflected {}", number(reflect));
    }
    if refract > 0.0 {
        weights += &format!(", refracted {} (index {})", number(refract), number(hit.ior));
    }
    rows.push(("weights", weights));
    if let Some(contribution) = hit.contribution {
        rows.push(("ambient", color(hit.ambient)));
        let lights: Spectrum = hit.lights.iter().fold(Spectrum::BLACK, |sum, l| sum + l.added);
        rows.push(("lights", color(lights)));
        let sum = format!("{} = ambient + lights", color(hit.local));
        rows.push(("local", sum));
        let weight = number(ray.weight * local);
        rows.push(("adds", format!("{} = local × {weight}", color(contribution))));
    }
    if let Some(emitted) = hit.emission.filter(|e| !e.is_black()) {
        rows.push(("emission", color(emitted)));
    }
}

fn light(parent: usize, hit: &Hit<'_>, term: &Light<'_>) -> Node {
    let from = term.shadow.as_ref().map_or(hit.position, |s| s.origin);
    let mut node = Node::new(Kind::Shadow, Some(parent), from, term.to_light.normalize_or_zero());
    node.to = term.distance.map(|_| hit.position + term.to_light);
    node.target = term.name.clone();
    node.light = Some((term.light, term.added));
    node.traced = term.shadow.is_some();
    let occluders = term.shadow.as_ref().map_or(&[][..], |s| &s.occluders);
    let transmittance = term.shadow.as_ref().map_or(Spectrum::WHITE, |s| s.transmittance);
    node.open = term.reaches && term.n_dot_l > 0.0 && !transmittance.is_black();
    node.remark = if !term.reaches {
        "does not illuminate this point".to_owned()
    } else if term.n_dot_l <= 0.0 && term.highlight.is_black() {
        "behind the surface".to_owned()
    } else if transmittance.is_black() {
        format!("in shadow of {}", list(occluders))
    } else if transmittance != Spectrum::WHITE {
        format!("through {}: {}", list(occluders), color(transmittance))
    } else {
        "lit".to_owned()
    };
    if let Some(first) = occluders.first() {
        (node.primitive, node.shape) = (Some(first.object.primitive), first.object.shape);
    }
    if let (Some(first), Some(shadow)) = (occluders.first(), &term.shadow)
        && transmittance.is_black()
    {
        node.to = Some(shadow.origin + shadow.direction * first.t);
    }
    node.touches = term.touches;
    node.rows.push(("N·L", number(term.n_dot_l)));
    if term.r_dot_v != 0.0 {
        node.rows.push(("R·V", number(term.r_dot_v)));
    }
    node.rows.push(("intensity", color(term.intensity)));
    node.rows.push(("diffuse", color(term.diffuse)));
    if hit.ks > 0.0 {
        node.rows.push(("highlight", color(term.highlight)));
    }
    node.rows.push(("adds", color(term.added)));
    if let Some(distance) = term.distance {
        node.rows.push(("distance", short(distance)));
    }
    node
}

/// `screen`, or `pane and vase`.
pub(super) fn list(occluders: &[Occluder<'_>]) -> String {
    let mut listed: Vec<String> = occluders.iter().map(|c| c.object.label()).collect();
    listed.dedup();
    match listed.len() {
        0 => "an object, grazed at its edge".to_owned(),
        1..=3 => listed.join(" and "),
        n => format!("{} and {} more", listed.get(..2).unwrap_or_default().join(", "), n - 2),
    }
}
