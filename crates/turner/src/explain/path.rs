//! A sample of the path tracer as nodes: a chain of rays, with the shadow rays of next-event estimation at each vertex.
//!
//! ```text
//! camera ray ──> vertex ── BSDF sample ──> vertex ── BSDF sample ──> …
//!                  └─ shadow ray (NEE)       └─ shadow ray (NEE)
//! ```

use crate::bsdf::Lobe;
use crate::color::Spectrum;
use crate::integrator::path::{
    DonorPart, EmissionRecord, End, EscapeRecord, LightRecord, MediumSegmentRecord, Passage, PathRecord,
    ScatterRecord, SharedRecord, VertexRecord,
};
use crate::math::DVec3;

use super::classic::list;
use super::model::{Kind, RayNode, SampleTree};
use super::names::Names;
use super::term::{Piece, Term, color, fill, number, vector};

/// Why a path ended, in words.
pub fn end(end: End) -> &'static str {
    match end {
        End::Escaped => "it leaves the scene",
        End::Absorbed => "it is absorbed",
        End::Depth => "`max_depth` is reached",
        End::Transparency => "`max_transparent` is reached",
        End::Roulette => "Russian roulette",
        End::Unlit => "the surface is unlit",
        End::Vertices => "the limit on vertices per path is reached",
        End::OutsideField => "outside the image of the camera",
    }
}

fn lobe(lobe: &Lobe) -> &'static str {
    match (lobe.is_delta, lobe.is_transmission, lobe.is_diffuse) {
        (true, false, _) => "specular reflection",
        (true, true, _) => "specular transmission",
        (false, false, true) => "diffuse reflection",
        (false, true, true) => "diffuse transmission",
        (false, false, false) => "glossy reflection",
        (false, true, false) => "glossy transmission",
    }
}

fn kind_of(lobe: &Lobe) -> Kind {
    match (lobe.is_delta, lobe.is_transmission, lobe.is_diffuse) {
        (true, true, _) | (false, true, false) => Kind::Refracted,
        (true, false, _) => Kind::Reflected,
        (false, _, true) => Kind::Diffuse,
        (false, false, false) => Kind::Glossy,
    }
}

/// Adds the rays of a sample's path.
pub(super) fn grow(out: &mut SampleTree, names: &Names<'_>, path: &PathRecord) {
    out.remarks.push(format!("the path ends: {}", end(path.end)));
    let (mut parent, mut kind) = (None, Kind::Camera);
    let shared = path.shared.as_ref().and_then(|s| Some((s.from?, s.until.unwrap_or(usize::MAX))));
    // The weights of the light of the first shared vertex, and of the light that arrives there.
    let weight_of = |parts: [DonorPart; 2]| {
        let own = path.shared.iter().flat_map(|s| &s.parts);
        let part = own.filter(|p| p.id == path.id).find(|p| parts.contains(&p.part));
        part.map_or(Spectrum::BLACK, |p| p.share)
    };
    let direct = weight_of([DonorPart::Radiance, DonorPart::Direct]);
    let next = weight_of([DonorPart::Radiance, DonorPart::Next]);
    let own = |number: usize| {
        let (from, until) = shared?;
        (from..until).contains(&number).then_some(if number == from { direct } else { next })
    };
    let mut nodes = Vec::new();
    for (number, v) in path.vertices.iter().enumerate() {
        let index = out.nodes.len();
        nodes.push(index);
        vertex((out, names), RayNode::new(kind, parent, v.origin, v.direction), v, own(number));
        parent = Some(index);
        kind = match (&v.scatter, v.passage) {
            (Some(s), Passage::Surface | Passage::Medium | Passage::Exit) => kind_of(&s.lobe),
            _ => Kind::Straight,
        };
    }
    if let Some(e) = &path.escape {
        escape((out, names), RayNode::new(kind, parent, e.origin, e.direction), e, own(path.vertices.len()));
    }
    if let Some(shared) = &path.shared {
        donors(out, path, shared, &nodes);
    }
}

/// Adds the ray to a vertex and its shadow rays. `own` is the weight of the sample's own path where it is shared: its
/// contribution is then part of the sum over the group.
fn vertex(
    (out, names): (&mut SampleTree, &Names<'_>),
    mut node: RayNode,
    v: &VertexRecord,
    own: Option<Spectrum>,
) {
    let (index, parts) = (out.nodes.len(), out.parts.len());
    let is_surface = v.passage != Passage::Medium;
    if is_surface {
        surface(&mut node, names, v);
    } else {
        in_medium(&mut node, v);
    }
    let mut equiangular = None;
    if let Some(segment) = &v.way {
        through_medium(&mut node, names, segment);
        add(out, &mut node, "emission of the medium", segment.emission);
        equiangular = segment.second.as_ref();
    }
    node.touches = names.touches(v.primitive, v.shape, v.material);
    let of = Some(v).filter(|_| is_surface);
    add(out, &mut node, "emission", of.and_then(|s| s.emission.as_ref()).map(|e| e.contribution));
    add(out, &mut node, "photons", of.and_then(|s| s.photons.as_ref()).map(|p| p.contribution));
    add(out, &mut node, "next-event estimation in a medium", sampled_in_medium(equiangular));
    for light in v.lights.iter().filter(|light| is_traced(light)) {
        add(out, &mut node, "next-event estimation", Some(light.contribution));
    }
    if let Some(own) = own {
        // The contribution comes from the sum over the group: see `donors`.
        out.parts.truncate(parts);
        node.contribution = node.contribution * own;
    }
    out.nodes.push(node);
    if let Some((t, l)) = equiangular {
        out.nodes.push(light(names, index, v.origin + v.direction * *t, l));
    }
    out.nodes.extend(v.lights.iter().map(|l| light(names, index, v.p, l)));
}

/// Adds a contribution of the node that is pushed next, without its descendants.
fn add(out: &mut SampleTree, node: &mut RayNode, what: &'static str, part: Option<Spectrum>) {
    if let Some(part) = part {
        out.parts.push((out.nodes.len(), what, part));
        node.contribution += part;
    }
}

/// Adds the ray that leaves the scene; `own` as for vertices.
fn escape(
    (out, names): (&mut SampleTree, &Names<'_>),
    mut node: RayNode,
    e: &EscapeRecord,
    own: Option<Spectrum>,
) {
    node.target = "background".to_owned();
    node.weight = e.throughput;
    node.contribution = e.contribution;
    let mut equiangular = None;
    if let Some(segment) = &e.way {
        through_medium(&mut node, names, segment);
        add(out, &mut node, "emission of the medium", segment.emission);
        equiangular = segment.second.as_ref();
    }
    let rows = &mut node.terms;
    rows.push(Term::new("direction", vector(e.direction)));
    rows.push(Term::new("throughput", color(e.throughput)));
    if let Some(left) = e.transmittance {
        rows.push(Term::new("transmittance", color(left)));
    }
    for l in &e.lights {
        let pdf = e.pdf.map_or(Piece::Text("none".to_owned()), number);
        rows.push(Term::new("environment radiance", color(l.radiance)));
        rows.push(Term::new("pdf", fill!("{}, light pdf {}", pdf, number(l.light_pdf))));
        rows.push(Term::new("MIS weight", number(l.weight)));
    }
    for (what, light) in [("background", e.background), ("ambient", e.ambient)] {
        if !light.is_black() {
            rows.push(Term::new(what, color(light)));
        }
    }
    rows.push(Term::new("adds", color(e.contribution)));
    let index = out.nodes.len();
    match own {
        Some(own) => node.contribution = e.contribution * own,
        None => out.parts.push((index, "background and infinite lights", e.contribution)),
    }
    add(out, &mut node, "next-event estimation in a medium", sampled_in_medium(equiangular));
    out.nodes.push(node);
    if let Some((t, l)) = equiangular {
        out.nodes.push(light(names, index, e.origin + e.direction * *t, l));
    }
}

/// What a part of the sample's own shared path is called.
fn own_part(part: DonorPart) -> &'static str {
    match part {
        DonorPart::Radiance => "own path, shared",
        DonorPart::Direct => "own path, shared: direct light",
        DonorPart::Next => "own path, shared: light from the next vertex",
    }
}

/// Adds the contributions of the shared paths: the sample's own path is part of its tree, each path of a neighbour is a
/// ray to that path's second vertex. `nodes` are the nodes of the path's vertices.
fn donors(out: &mut SampleTree, path: &PathRecord, shared: &SharedRecord, nodes: &[usize]) {
    for part in &shared.parts {
        let weight = color(part.share);
        if let Some(index) = shared.from.filter(|_| part.id == path.id).and_then(|from| nodes.get(from)) {
            out.parts.push((*index, own_part(part.part), part.contribution));
            if let Some(node) = out.nodes.get_mut(*index) {
                let rows = &mut node.terms;
                rows.push(Term::new(
                    "shared",
                    "from here on the path serves its group of pixels: contribution by weight".to_owned(),
                ));
                rows.push(Term::new("weight", weight));
                rows.push(Term::new("adds", color(part.contribution)));
            }
            continue;
        }
        let (Some(first), Some(&parent)) = (path.vertices.first(), nodes.first()) else { continue };
        let mut node =
            RayNode::new(Kind::Diffuse, Some(parent), first.p, (part.p - first.p).normalize_or_zero());
        node.to = Some(part.p);
        node.target = format!("the path of column {}, row {}", part.id.x, part.id.y);
        node.remark = "shared".to_owned();
        node.weight = part.share;
        node.contribution = part.contribution;
        let rows = &mut node.terms;
        rows.push(Term::new("hits", vector(part.p)));
        let what = match part.part {
            DonorPart::Radiance => "radiance",
            DonorPart::Direct => "direct light",
            DonorPart::Next => "light from the next vertex",
        };
        rows.push(Term::new(what, color(part.radiance)));
        rows.push(Term::new("weight", weight));
        rows.push(Term::new("adds", color(part.contribution)));
        out.parts.push((out.nodes.len(), "path of a neighbouring pixel", part.contribution));
        out.nodes.push(node);
    }
}

/// The contribution of the light sampled at the equiangular point of a medium segment.
fn sampled_in_medium(equiangular: Option<&(f64, LightRecord)>) -> Option<Spectrum> {
    equiangular.filter(|(_, l)| is_traced(l)).map(|(_, l)| l.contribution)
}

fn through_medium(node: &mut RayNode, names: &Names<'_>, segment: &MediumSegmentRecord) {
    let whose = segment.solid.map_or("of the scene".to_owned(), |m| format!("inside {}", names.material(m)));
    let (length, weight) = (number(segment.length), color(segment.weight));
    node.terms.push(Term::new("medium", fill!("{}, length {}, weight {}", whose, length, weight)));
    if let Some(emission) = segment.emission {
        node.terms.push(Term::new("emission", color(emission)));
    }
}

fn in_medium(node: &mut RayNode, v: &VertexRecord) {
    node.to = Some(v.p);
    node.weight = v.throughput;
    node.target = "a medium".to_owned();
    node.remark = "scattered".to_owned();
    let rows = &mut node.terms;
    rows.push(Term::new("t", number(v.t)));
    rows.push(Term::new("origin", vector(v.origin)));
    rows.push(Term::new("direction", vector(v.direction)));
    rows.push(Term::new("position", vector(v.p)));
    rows.push(Term::new("throughput", color(v.throughput)));
    if let Some(s) = &v.scatter {
        let (pdf, towards) = (number(s.pdf), vector(s.direction));
        rows.push(Term::new("phase function sample", fill!("direction {}, pdf {}", towards, pdf)));
        roulette(rows, s);
    }
}

fn surface(node: &mut RayNode, names: &Names<'_>, v: &VertexRecord) {
    node.to = Some(v.p);
    node.weight = v.throughput;
    node.distance = Some(v.t);
    node.normal = Some(v.ns);
    names.hit(node, v.primitive, v.shape, v.material);
    if let (Some(material), Some(chosen)) = (&mut node.material, v.chosen) {
        *material += &format!(", mix chose {}", names.material(chosen));
    }
    let transmits = v.scatter.as_ref().is_some_and(|s| s.lobe.is_transmission);
    let inside_mirror = v.scatter.as_ref().is_some_and(|s| s.lobe.is_delta && !s.lobe.is_transmission);
    node.remark = match (v.passage, v.outside) {
        (Passage::Hole, _) => "passes: transparent by stochastic alpha test",
        (Passage::Hidden, _) => "passes: inside a solid of higher priority",
        (Passage::Interface, true) => "enters a medium",
        (Passage::Interface, false) => "leaves a medium",
        (Passage::Medium, _) => "",
        (Passage::Exit, _) => "exits the translucent body",
        (Passage::Surface, _) if v.walk.is_some() => "hit from inside the translucent body",
        (Passage::Pane, _) => "passes: thin clear surface",
        (Passage::Surface, true) if transmits => "enters",
        (Passage::Surface, false) if transmits => "leaves",
        (Passage::Surface, false) if inside_mirror => "internal reflection",
        (Passage::Surface, false) => "hit from inside",
        (Passage::Surface, true) => "",
    }
    .to_owned();
    let rows = &mut node.terms;
    rows.push(Term::new("t", number(v.t)));
    rows.push(Term::new("origin", vector(v.origin)));
    rows.push(Term::new("direction", vector(v.direction)));
    rows.push(Term::new("hits", vector(v.p)));
    let tilted = match v.ns {
        n if n == v.ng => Vec::new(),
        n => fill!(", shading {}", vector(n)),
    };
    rows.push(Term::new("normal", fill!("{}{}", vector(v.ng), tilted)));
    if !v.inside.is_empty() {
        let inside: Vec<String> = v.inside.iter().map(|&m| names.material(m)).collect();
        let left = v.transmittance.map_or(Vec::new(), |left| fill!(", transmittance {}", color(left)));
        rows.push(Term::new("inside", fill!("{}{}", inside.join(" and "), left)));
    }
    if let Some(walk) = &v.walk {
        rows.push(Term::new(
            "random walk",
            fill!(
                "{} steps, length {}, weight {}",
                walk.steps.to_string(),
                number(walk.length),
                color(walk.weight)
            ),
        ));
    }
    rows.push(Term::new("throughput", color(v.throughput)));
    if let Some(ior) = v.ior_around.filter(|&ior| ior != 1.0) {
        rows.push(Term::new("exterior IOR", number(ior)));
    }
    if let Some(band) = v.band {
        let carries = v.dispersed.map_or(Vec::new(), |t| fill!(", new throughput {}", color(t)));
        rows.push(Term::new(
            "dispersion",
            fill!("{} only{}", ["red", "green", "blue"][usize::from(band.min(2))], carries),
        ));
    }
    if let Some(e) = &v.emission {
        emission(rows, e);
    }
    if let Some(p) = &v.photons {
        rows.push(Term::new("photons", fill!("{} within {}", p.count.to_string(), number(p.radius))));
        rows.push(Term::new("adds", color(p.contribution)));
    }
    for l in v.lights.iter().filter(|l| is_traced(l)) {
        rows.push(Term::new("next-event estimation", color(l.contribution)));
    }
    if let Some(s) = &v.scatter {
        bsdf_sample(rows, s);
    }
}

type Rows = Vec<Term>;

fn emission(rows: &mut Rows, e: &EmissionRecord) {
    let pdf =
        e.pdf.map_or(vec![Piece::Text("not sampled as a light".to_owned())], |p| fill!("pdf {}", number(p)));
    let weight = fill!("MIS weight {}", number(e.weight));
    rows.push(Term::new(
        "emission",
        fill!("{}; {}, light pdf {}, {}", color(e.radiance), pdf, number(e.light_pdf), weight),
    ));
    rows.push(Term::new("adds", color(e.contribution)));
}

fn bsdf_sample(rows: &mut Rows, s: &ScatterRecord) {
    let eta = if s.eta == 1.0 { Vec::new() } else { fill!(", eta {}", number(s.eta)) };
    rows.push(Term::new("BSDF sample", fill!("{}, direction {}", lobe(&s.lobe), vector(s.direction))));
    let f = color(s.bsdf);
    let (pdf, cosine) = (number(s.pdf), number(s.cosine));
    rows.push(Term::new(
        "BSDF value",
        fill!("{}, pdf {}, cosine {}{}, weight {}", f, pdf, cosine, eta, color(s.weight)),
    ));
    roulette(rows, s);
}

fn roulette(rows: &mut Rows, s: &ScatterRecord) {
    if let Some(r) = &s.roulette {
        let (random, survival) = (r.number, r.survival);
        let outcome = if random < survival { "survives" } else { "terminates" };
        rows.push(Term::new(
            "Russian roulette",
            fill!("{}: random number {}, survival probability {}", outcome, number(random), number(survival)),
        ));
    }
}

fn light(names: &Names<'_>, parent: usize, p: DVec3, l: &LightRecord) -> RayNode {
    let from = l.shadow_origin.unwrap_or(p);
    let mut node = RayNode::new(Kind::Shadow, Some(parent), from, l.direction);
    node.to = l.distance.is_finite().then_some(p + l.direction * l.distance);
    if let (Some(first), Some(true)) = (l.casters.first(), l.visible.map(|v| v.is_black())) {
        // A shadow ray to a light at a finite distance is not normalised: t = 1 at the light.
        let along = node.to.map_or(l.direction, |to| to - from);
        node.to = Some(from + first.t * along);
    }
    node.target = "next-event estimation".to_owned();
    node.light = Some((0, l.contribution));
    node.traced = is_traced(l);
    node.open = l.visible.is_some_and(|visibility| !visibility.is_black());
    node.remark = match l.visible {
        None => "contributes nothing, no shadow ray".to_owned(),
        Some(visible) if visible.is_black() => format!("in shadow of {}", list(names, &l.casters)),
        Some(visible) if visible == Spectrum::WHITE => "light visible".to_owned(),
        Some(visible) if l.casters.is_empty() => format!("through a medium: {}", color(visible)),
        Some(visible) => format!("through {}: {}", list(names, &l.casters), color(visible)),
    };
    if let Some(first) = l.casters.first() {
        (node.primitive, node.shape) = (Some(first.primitive), first.shape);
    }
    node.touches = l.casters.iter().any(|c| names.touches(c.primitive, c.shape, c.material));
    node.transmittance = l.visible;
    node.distance = Some(l.distance).filter(|d| d.is_finite());
    let rows = &mut node.terms;
    rows.push(Term::new("direction", fill!("{}, distance {}", vector(l.direction), number(l.distance))));
    let delta = if l.is_delta { " (delta light)" } else { "" };
    rows.push(Term::new("radiance", fill!("{}, pdf {}{}", color(l.radiance), number(l.pdf), delta)));
    let (f, pdf) = (color(l.bsdf), number(l.bsdf_pdf));
    rows.push(Term::new("BSDF value", fill!("{}, pdf {}, cosine {}", f, pdf, number(l.cosine))));
    rows.push(Term::new("MIS weight", number(l.weight)));
    if l.candidates > 1 {
        let weight = number(f64::from(l.counts));
        rows.push(Term::new(
            "candidates",
            fill!("{}, resampling weight {}", l.candidates.to_string(), weight),
        ));
    }
    if let Some(left) = l.transmittance {
        rows.push(Term::new("transmittance", color(left)));
    }
    rows.push(Term::new("unoccluded", color(l.unshadowed)));
    rows.push(Term::new("adds", color(l.contribution)));
    node
}

/// Whether a shadow ray was traced: only if the unoccluded contribution is not zero.
fn is_traced(l: &LightRecord) -> bool {
    l.visible.is_some()
}
