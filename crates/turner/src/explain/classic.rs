//! The ray tree of the classic integrator (Whitted 1980) as nodes.

use crate::color::Spectrum;
use crate::integrator::classic::{
    CutReason, CutRecord, HitRecord, LightTerm, RayEnd, RayKind, RayRecord, Seen, TreeRecord,
};
use crate::scene::Caster;

use super::model::{Kind, RayNode, SampleTree};
use super::names::Names;
use super::number::rays;
use super::term::{Term, color, fill, number, short, vector};

/// Adds the rays of a sample.
pub(super) fn grow(out: &mut SampleTree, names: &Names<'_>, tree: &TreeRecord) {
    out.unrecorded = tree.unwritten;
    if tree.rays.is_empty() {
        out.remarks.push("outside the image of the camera".to_owned());
    }
    if tree.dropped > 0 {
        let what = rays(tree.dropped);
        out.remarks.push(format!("{what} not traced: the integrator's `max_rays` was reached"));
    }
    let mut builder = Builder { out, names, ray_nodes: Vec::with_capacity(tree.rays.len()) };
    for ray in &tree.rays {
        builder.ray(ray);
    }
}

struct Builder<'a, 'n> {
    out: &'a mut SampleTree,
    names: &'a Names<'n>,
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

impl Builder<'_, '_> {
    fn ray(&mut self, ray: &RayRecord) {
        let parent = ray.parent.and_then(|p| self.ray_nodes.get(p as usize).copied());
        let mut node = RayNode::new(kind(ray.kind), parent, ray.origin, ray.direction);
        node.weight = Spectrum::grey(ray.weight as f32);
        let index = self.out.nodes.len();
        self.ray_nodes.push(index);
        if let RayEnd::Miss(miss) = &ray.end {
            node.target = seen(miss.seen).to_owned();
            node.contribution = Spectrum::BLACK + miss.contribution;
            self.out.parts.push((index, seen(miss.seen), miss.contribution));
            node.terms.push(Term::new("origin", vector(ray.origin)));
            node.terms.push(Term::new("direction", vector(ray.direction)));
        }
        let RayEnd::Hit(hit) = &ray.end else { return self.out.nodes.push(node) };
        surface(&mut node, self.names, ray, hit);
        // Contributions in place of rays that were not traced belong to their own nodes.
        let own = hit.emitted.into_iter().chain(hit.contribution);
        node.contribution = own.fold(Spectrum::BLACK, |sum, c| sum + c);
        self.out.nodes.push(node);
        let parts = [("emission", hit.emitted), ("local colour", hit.contribution)];
        for (what, part) in parts {
            self.out.parts.extend(part.map(|c| (index, what, c)));
        }
        for term in &hit.lights {
            self.out.nodes.push(light(self.names, index, hit, term));
        }
        for cut in &hit.cut {
            self.cut(index, hit, cut);
        }
    }

    fn cut(&mut self, parent: usize, hit: &HitRecord, cut: &CutRecord) {
        let mut node = RayNode::new(kind(cut.kind), Some(parent), hit.p, cut.direction);
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
        node.cut = Some(node.remark.clone());
        node.contribution = cut.contribution;
        self.out.parts.push((self.out.nodes.len(), "in place of an untraced ray", cut.contribution));
        self.out.nodes.push(node);
    }
}

fn surface(node: &mut RayNode, names: &Names<'_>, ray: &RayRecord, hit: &HitRecord) {
    node.to = Some(hit.p);
    node.distance = Some(hit.t);
    node.normal = Some(hit.ns);
    names.hit(node, hit.primitive, hit.shape, hit.material);
    node.surface = Some(hit.color);
    let [local, reflect, refract] = hit.weights;
    node.remark = match (hit.total_internal_reflection, refract > 0.0, hit.entering) {
        (true, ..) => "total internal reflection",
        (false, true, true) => "enters",
        (false, true, false) => "leaves",
        (false, false, false) => "hit from inside",
        (false, false, true) => "",
    }
    .to_owned();
    let rows = &mut node.terms;
    rows.push(Term::new("t", number(hit.t)));
    rows.push(Term::new("origin", vector(ray.origin)));
    rows.push(Term::new("direction", vector(ray.direction)));
    rows.push(Term::new(
        "hits",
        fill!("{}, uv ({}, {})", vector(hit.p), number(hit.uv[0]), number(hit.uv[1])),
    ));
    let tilted = match hit.ns {
        n if n == hit.ng => Vec::new(),
        n => fill!(", shading {}", vector(n)),
    };
    rows.push(Term::new("normal", fill!("{}{}", vector(hit.ng), tilted)));
    rows.push(Term::new("colour", color(hit.color)));
    let mut weights = fill!("local {}", number(local));
    if reflect > 0.0 {
        weights.extend(fill!(", reflected {}", number(reflect)));
    }
    if refract > 0.0 {
        weights.extend(fill!(", refracted {} (index {})", number(refract), number(hit.ior)));
    }
    rows.push(Term::new("weights", weights));
    if let Some(contribution) = hit.contribution {
        rows.push(Term::new("ambient", color(hit.ambient)));
        let lights: Spectrum = hit.lights.iter().fold(Spectrum::BLACK, |sum, l| sum + l.added);
        rows.push(Term::new("lights", color(lights)));
        let sum = fill!("{} = ambient + lights", color(hit.local));
        rows.push(Term::new("local", sum));
        let weight = number(ray.weight * local);
        rows.push(Term::new("adds", fill!("{} = local × {}", color(contribution), weight)));
    }
    if let Some(emitted) = hit.emitted.filter(|e| !e.is_black()) {
        rows.push(Term::new("emission", color(emitted)));
    }
}

fn light(names: &Names<'_>, parent: usize, hit: &HitRecord, term: &LightTerm) -> RayNode {
    let from = term.shadow.as_ref().map_or(hit.p, |s| s.origin);
    let mut node = RayNode::new(Kind::Shadow, Some(parent), from, term.to_light.normalize_or_zero());
    node.to = term.finite.then(|| hit.p + term.to_light);
    node.target = names.light(term.light);
    node.light = Some((term.light, term.added));
    node.traced = term.shadow.is_some();
    let occluders = term.shadow.as_ref().map_or(&[][..], |s| &s.casters);
    let transmittance = term.shadow.as_ref().map_or(Spectrum::WHITE, |s| s.through);
    node.open = term.reaches && term.n_dot_l > 0.0 && !transmittance.is_black();
    node.remark = if !term.reaches {
        "does not illuminate this point".to_owned()
    } else if term.n_dot_l <= 0.0 && term.highlight.is_black() {
        "behind the surface".to_owned()
    } else if transmittance.is_black() {
        format!("in shadow of {}", list(names, occluders))
    } else if transmittance != Spectrum::WHITE {
        format!("through {}: {}", list(names, occluders), color(transmittance))
    } else {
        "lit".to_owned()
    };
    if let Some(first) = occluders.first() {
        (node.primitive, node.shape) = (Some(first.primitive), first.shape);
    }
    if let (Some(first), Some(shadow)) = (occluders.first(), &term.shadow)
        && transmittance.is_black()
    {
        node.to = Some(shadow.origin + shadow.direction * first.t);
    }
    node.touches = occluders.iter().any(|c| names.touches(c.primitive, c.shape, c.material));
    node.transmittance = Some(transmittance);
    node.terms.push(Term::new("N·L", number(term.n_dot_l)));
    if term.r_dot_v != 0.0 {
        node.terms.push(Term::new("R·V", number(term.r_dot_v)));
    }
    node.terms.push(Term::new("intensity", color(term.intensity)));
    node.terms.push(Term::new("diffuse", color(term.diffuse)));
    if hit.coefficients[2] > 0.0 {
        node.terms.push(Term::new("highlight", color(term.highlight)));
    }
    node.terms.push(Term::new("adds", color(term.added)));
    if term.finite {
        let distance = term.to_light.length();
        node.distance = Some(distance);
        node.terms.push(Term::new("distance", short(distance)));
    }
    node
}

/// `screen`, or `pane and vase`.
pub fn list(names: &Names<'_>, occluders: &[Caster]) -> String {
    let mut listed: Vec<String> = occluders.iter().map(|c| names.object(c.primitive, c.shape)).collect();
    listed.dedup();
    match listed.len() {
        0 => "an object, grazed at its edge".to_owned(),
        1..=3 => listed.join(" and "),
        n => format!("{} and {} more", listed.get(..2).unwrap_or_default().join(", "), n - 2),
    }
}
