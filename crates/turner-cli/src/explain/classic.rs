//! The ray tree of the classic integrator, as nodes.

use turner::color::Spectrum;
use turner::integrator::classic::{
    Caster, HitRecord, LightTerm, RayEnd, RayKind, RayRecord, Seen, TreeRecord,
};
use turner::render::SampleRecord;

use super::model::{Kind, Node, SampleTree};
use super::names::Names;
use super::number::{color, number, rays, short, vector};

/// A sample's tree; `wanted` is what `--path-of` asks for.
pub(super) fn tree(
    names: &Names<'_>,
    record: &TreeRecord,
    number: usize,
    sample: SampleRecord,
    wanted: Option<&str>,
) -> SampleTree {
    let mut out = SampleTree::new(number, sample, record.sum());
    out.unwritten = record.unwritten;
    if record.rays.is_empty() {
        out.remarks.push("the camera shows nothing here".to_owned());
    }
    if record.dropped > 0 {
        let what = rays(record.dropped);
        out.remarks.push(format!("{what} not traced: the integrator's `max_rays` was reached"));
    }
    let mut builder = Builder { names, wanted, out, places: Vec::with_capacity(record.rays.len()) };
    for ray in &record.rays {
        builder.ray(ray);
    }
    builder.out.add_up();
    builder.out
}

struct Builder<'a> {
    names: &'a Names<'a>,
    wanted: Option<&'a str>,
    out: SampleTree,
    /// The node of each ray.
    places: Vec<usize>,
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
        Seen::Surroundings => "background",
        Seen::Lights => "a directional light",
        Seen::Ambient => "ambient light",
        Seen::Nothing => "nothing",
        Seen::Transparent => "transparent background",
    }
}

impl Builder<'_> {
    fn ray(&mut self, ray: &RayRecord) {
        let parent = ray.parent.and_then(|p| self.places.get(p as usize).copied());
        let mut node = Node::new(kind(ray.kind), parent, ray.origin, ray.direction);
        node.weight = Spectrum::grey(ray.weight as f32);
        node.contribution = ray.contributions().fold(Spectrum::BLACK, |sum, c| sum + c);
        let place = self.out.nodes.len();
        self.places.push(place);
        match &ray.end {
            RayEnd::Miss(miss) => {
                node.target = seen(miss.seen).to_owned();
                self.out.parts.push((place, seen(miss.seen), miss.contribution));
                node.rows.push(("from", vector(ray.origin)));
                node.rows.push(("towards", vector(ray.direction)));
                self.out.nodes.push(node);
            }
            RayEnd::Hit(hit) => {
                self.surface(&mut node, ray, hit);
                // What rays that were not traced would have brought is theirs.
                let own = hit.emitted.into_iter().chain(hit.contribution);
                node.contribution = own.fold(Spectrum::BLACK, |sum, c| sum + c);
                self.out.nodes.push(node);
                let parts = [("emission", hit.emitted), ("local colour", hit.contribution)];
                for (what, part) in parts {
                    self.out.parts.extend(part.map(|c| (place, what, c)));
                }
                for term in &hit.lights {
                    self.light(place, hit, term);
                }
                for cut in &hit.cut {
                    let mut node = Node::new(kind(cut.kind), Some(place), hit.p, cut.direction);
                    node.weight = Spectrum::grey(cut.weight as f32);
                    node.traced = false;
                    node.target = match cut.seen {
                        Seen::Nothing => "not traced".to_owned(),
                        other => format!("not traced: {} stands for it", seen(other)),
                    };
                    node.remark = match cut.reason {
                        turner::integrator::classic::CutReason::Depth => "as deep as `max_depth` allows",
                        turner::integrator::classic::CutReason::Count => "as many rays as `max_rays` allows",
                    }
                    .to_owned();
                    node.contribution = cut.contribution;
                    self.out.parts.push((self.out.nodes.len(), "in place of a ray", cut.contribution));
                    self.out.nodes.push(node);
                }
            }
        }
    }

    fn surface(&self, node: &mut Node, ray: &RayRecord, hit: &HitRecord) {
        let names = self.names;
        node.to = Some(hit.p);
        node.target = names.object(hit.primitive, hit.shape);
        node.material = Some(names.material(hit.material));
        (node.primitive, node.shape) = (Some(hit.primitive), hit.shape);
        node.touches = self.wanted.is_some_and(|w| names.is(w, hit.primitive, hit.shape, hit.material));
        node.surface = Some(hit.color);
        let [local, reflect, refract] = hit.weights;
        node.remark = match (hit.total_internal_reflection, refract > 0.0, hit.entering) {
            (true, ..) => "total internal reflection",
            (false, true, true) => "enters",
            (false, true, false) => "leaves",
            (false, false, false) => "met from inside",
            (false, false, true) => "",
        }
        .to_owned();
        let rows = &mut node.rows;
        rows.push(("t", number(hit.t)));
        rows.push(("from", vector(ray.origin)));
        rows.push(("towards", vector(ray.direction)));
        rows.push(("hits", format!("{}, uv ({}, {})", vector(hit.p), number(hit.uv[0]), number(hit.uv[1]))));
        let tilted = if hit.ns == hit.ng { String::new() } else { format!(", shading {}", vector(hit.ns)) };
        rows.push(("normal", format!("{}{tilted}", vector(hit.ng))));
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
            let share = number(ray.weight * local);
            rows.push(("adds", format!("{} = local × {share}", color(contribution))));
        }
        if let Some(emitted) = hit.emitted.filter(|e| !e.is_black()) {
            rows.push(("shines", color(emitted)));
        }
    }

    fn light(&mut self, parent: usize, hit: &HitRecord, term: &LightTerm) {
        let names = self.names;
        let from = term.shadow.as_ref().map_or(hit.p, |s| s.origin);
        let mut node = Node::new(Kind::Shadow, Some(parent), from, term.to_light.normalize_or_zero());
        node.to = term.finite.then_some(hit.p + term.to_light);
        node.target = names.light(term.light);
        node.light = Some((term.light, term.added));
        node.traced = term.shadow.is_some();
        let casters = term.shadow.as_ref().map_or(&[][..], |s| &s.casters);
        let through = term.shadow.as_ref().map_or(Spectrum::WHITE, |s| s.through);
        node.open = term.reaches && term.n_dot_l > 0.0 && !through.is_black();
        node.remark = if !term.reaches {
            "does not reach".to_owned()
        } else if term.n_dot_l <= 0.0 && term.highlight.is_black() {
            "behind the surface".to_owned()
        } else if through.is_black() {
            format!("in shadow of {}", self.casters(casters))
        } else if through != Spectrum::WHITE {
            format!("through {}: {}", self.casters(casters), color(through))
        } else {
            "lit".to_owned()
        };
        if let Some(first) = casters.first() {
            (node.primitive, node.shape) = (Some(first.primitive), first.shape);
        }
        if let (Some(first), Some(shadow)) = (casters.first(), &term.shadow)
            && through.is_black()
        {
            node.to = Some(shadow.origin + shadow.direction * first.t);
        }
        node.touches = self
            .wanted
            .is_some_and(|w| casters.iter().any(|c| names.is(w, c.primitive, c.shape, c.material)));
        node.rows.push(("N·L", number(term.n_dot_l)));
        if term.r_dot_v != 0.0 {
            node.rows.push(("R·V", number(term.r_dot_v)));
        }
        node.rows.push(("intensity", color(term.intensity)));
        node.rows.push(("diffuse", color(term.diffuse)));
        if hit.coefficients[2] > 0.0 {
            node.rows.push(("highlight", color(term.highlight)));
        }
        node.rows.push(("adds", color(term.added)));
        if term.finite {
            node.rows.push(("distance", short(term.to_light.length())));
        }
        self.out.nodes.push(node);
    }

    /// `screen`, or `pane and vase`.
    fn casters(&self, casters: &[Caster]) -> String {
        casters_of(self.names, casters)
    }
}

pub(super) fn casters_of(names: &Names<'_>, casters: &[Caster]) -> String {
    let mut listed: Vec<String> = casters.iter().map(|c| names.object(c.primitive, c.shape)).collect();
    listed.dedup();
    match listed.len() {
        0 => "something at its very edge".to_owned(),
        1..=3 => listed.join(" and "),
        n => format!("{} and {} more", listed.get(..2).unwrap_or_default().join(", "), n - 2),
    }
}
