//! A sample of the path tracer as nodes: a chain of rays, with the shadow rays of next-event estimation at each vertex.
//!
//! ```text
//! camera ray ──> vertex ── BSDF sample ──> vertex ── BSDF sample ──> …
//!                  └─ shadow ray (NEE)       └─ shadow ray (NEE)
//! ```

use turner::color::Spectrum;
use turner::integrator::path::{End, Passage};
use turner::math::DVec3;

use super::classic::list;
use super::model::{Kind, Node, SampleTree};
use super::number::{color, number, vector};
use super::record::path::{
    Emission, Equiangular, Escape, Light, Lobe, MediumSegment, Path, Scatter, Shared, Surface, Vertex,
};

pub(super) fn end(end: End) -> &'static str {
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
    match (lobe.delta, lobe.transmission, lobe.diffuse) {
        (true, false, _) => "specular reflection",
        (true, true, _) => "specular transmission",
        (false, false, true) => "diffuse reflection",
        (false, true, true) => "diffuse transmission",
        (false, false, false) => "glossy reflection",
        (false, true, false) => "glossy transmission",
    }
}

fn kind_of(lobe: &Lobe) -> Kind {
    match (lobe.delta, lobe.transmission, lobe.diffuse) {
        (true, true, _) | (false, true, false) => Kind::Refracted,
        (true, false, _) => Kind::Reflected,
        (false, _, true) => Kind::Diffuse,
        (false, false, false) => Kind::Glossy,
    }
}

/// Adds the rays of a sample's path.
pub(super) fn grow(out: &mut SampleTree, path: &Path<'_>) {
    out.remarks.push(format!("the path ends: {}", end(path.end)));
    let (mut parent, mut kind) = (None, Kind::Camera);
    let shared_from = path.shared.as_ref().and_then(|s| s.from);
    // The weight of the radiance that leaves the first shared vertex.
    let own = path.shared.iter().flat_map(|s| &s.paths).find(|p| p.own).map(|p| p.weight);
    let own = own.unwrap_or(Spectrum::BLACK);
    let mut nodes = Vec::new();
    for (number, v) in path.vertices.iter().enumerate() {
        let index = out.nodes.len();
        nodes.push(index);
        vertex(
            out,
            Node::new(kind, parent, v.origin, v.direction),
            v,
            shared_from.filter(|&from| number >= from).map(|_| own),
        );
        parent = Some(index);
        kind = match (&v.scatter, v.passage) {
            (Some(s), Passage::Surface | Passage::Medium | Passage::Exit) => kind_of(&s.lobe),
            _ => Kind::Straight,
        };
    }
    if let Some(e) = &path.escape {
        escape(out, Node::new(kind, parent, e.origin, e.direction), e, shared_from.map(|_| own));
    }
    if let Some(shared) = &path.shared {
        donors(out, path, shared, &nodes);
    }
}

/// Adds the ray to a vertex and its shadow rays. `own` is the weight of the sample's own path where it is shared: its
/// contribution is then part of the sum over the group.
fn vertex(out: &mut SampleTree, mut node: Node, v: &Vertex<'_>, own: Option<Spectrum>) {
    let (index, parts) = (out.nodes.len(), out.parts.len());
    match &v.surface {
        Some(s) => surface(&mut node, v, s),
        None => in_medium(&mut node, v),
    }
    let mut equiangular = None;
    if let Some(segment) = &v.medium_segment {
        through_medium(&mut node, segment);
        add(out, &mut node, "emission of the medium", segment.emission);
        equiangular = segment.equiangular.as_ref();
    }
    node.touches = v.touches;
    let of = v.surface.as_ref();
    add(out, &mut node, "emission", of.and_then(|s| s.emission.as_ref()).map(|e| e.contribution));
    add(out, &mut node, "photons", of.and_then(|s| s.photons.as_ref()).map(|p| p.contribution));
    add(out, &mut node, "next-event estimation in a medium", sampled_in_medium(equiangular));
    let sampled = v.light.as_ref().filter(|l| l.is_traced());
    add(out, &mut node, "next-event estimation", sampled.map(|l| l.contribution));
    if let Some(own) = own {
        // The contribution comes from the sum over the group: see `donors`.
        out.parts.truncate(parts);
        node.contribution = node.contribution * own;
    }
    out.nodes.push(node);
    if let Some(Equiangular { t, light: l }) = equiangular {
        out.nodes.push(light(index, v.origin + v.direction * *t, l));
    }
    if let Some(l) = &v.light {
        out.nodes.push(light(index, v.position, l));
    }
}

/// Adds a contribution of the node that is pushed next, without its descendants.
fn add(out: &mut SampleTree, node: &mut Node, what: &'static str, part: Option<Spectrum>) {
    if let Some(part) = part {
        out.parts.push((out.nodes.len(), what, part));
        node.contribution += part;
    }
}

/// Adds the ray that leaves the scene; `own` as for vertices.
fn escape(out: &mut SampleTree, mut node: Node, e: &Escape<'_>, own: Option<Spectrum>) {
    node.target = "background".to_owned();
    node.weight = e.throughput;
    node.contribution = e.contribution;
    let mut equiangular = None;
    if let Some(segment) = &e.medium_segment {
        through_medium(&mut node, segment);
        add(out, &mut node, "emission of the medium", segment.emission);
        equiangular = segment.equiangular.as_ref();
    }
    let rows = &mut node.rows;
    rows.push(("direction", vector(e.direction)));
    rows.push(("throughput", color(e.throughput)));
    if let Some(left) = e.transmittance {
        rows.push(("transmittance", color(left)));
    }
    for l in &e.lights {
        let pdf = e.pdf.map_or("none".to_owned(), number);
        rows.push(("environment radiance", color(l.radiance)));
        rows.push(("pdf", format!("{pdf}, light pdf {}", number(l.light_pdf))));
        rows.push(("MIS weight", number(l.mis_weight)));
    }
    for (what, light) in [("background", e.background), ("ambient", e.ambient)] {
        if !light.is_black() {
            rows.push((what, color(light)));
        }
    }
    rows.push(("adds", color(e.contribution)));
    let index = out.nodes.len();
    match own {
        Some(own) => node.contribution = e.contribution * own,
        None => out.parts.push((index, "background and infinite lights", e.contribution)),
    }
    add(out, &mut node, "next-event estimation in a medium", sampled_in_medium(equiangular));
    out.nodes.push(node);
    if let Some(Equiangular { t, light: l }) = equiangular {
        out.nodes.push(light(index, e.origin + e.direction * *t, l));
    }
}

/// Adds the contributions of the shared paths: the sample's own path is part of its tree, each path of a neighbour is a
/// ray to that path's second vertex. `nodes` are the nodes of the path's vertices.
fn donors(out: &mut SampleTree, path: &Path<'_>, shared: &Shared, nodes: &[usize]) {
    for part in &shared.paths {
        let weight = color(part.weight);
        if let Some(index) = shared.from.filter(|_| part.own).and_then(|from| nodes.get(from)) {
            out.parts.push((*index, "own path, shared", part.contribution));
            if let Some(node) = out.nodes.get_mut(*index) {
                let rows = &mut node.rows;
                rows.push((
                    "shared",
                    "from here on the path serves its group of pixels: contribution by weight".to_owned(),
                ));
                rows.push(("weight", weight));
                rows.push(("adds", color(part.contribution)));
            }
            continue;
        }
        let (Some(first), Some(&parent)) = (path.vertices.first(), nodes.first()) else { continue };
        let mut node = Node::new(
            Kind::Diffuse,
            Some(parent),
            first.position,
            (part.position - first.position).normalize_or_zero(),
        );
        node.to = Some(part.position);
        node.target = format!("the path of column {}, row {}", part.pixel[0], part.pixel[1]);
        node.remark = "shared".to_owned();
        node.weight = part.weight;
        node.contribution = part.contribution;
        let rows = &mut node.rows;
        rows.push(("hits", vector(part.position)));
        rows.push(("radiance", color(part.radiance)));
        rows.push(("weight", weight));
        rows.push(("adds", color(part.contribution)));
        out.parts.push((out.nodes.len(), "path of a neighbouring pixel", part.contribution));
        out.nodes.push(node);
    }
}

/// The contribution of the light sampled at the equiangular point of a medium segment.
fn sampled_in_medium(equiangular: Option<&Equiangular<'_>>) -> Option<Spectrum> {
    equiangular.filter(|s| s.light.is_traced()).map(|s| s.light.contribution)
}

fn through_medium(node: &mut Node, segment: &MediumSegment<'_>) {
    let whose = segment.solid.map_or("of the scene".to_owned(), |m| format!("inside {}", m.label()));
    let (length, weight) = (number(segment.length), color(segment.weight));
    node.rows.push(("medium", format!("{whose}, length {length}, weight {weight}")));
    if let Some(emission) = segment.emission {
        node.rows.push(("emission", color(emission)));
    }
}

fn in_medium(node: &mut Node, v: &Vertex<'_>) {
    node.to = Some(v.position);
    node.weight = v.throughput;
    node.target = "a medium".to_owned();
    node.remark = "scattered".to_owned();
    let rows = &mut node.rows;
    rows.push(("t", number(v.t)));
    rows.push(("origin", vector(v.origin)));
    rows.push(("direction", vector(v.direction)));
    rows.push(("position", vector(v.position)));
    rows.push(("throughput", color(v.throughput)));
    if let Some(s) = &v.scatter {
        let (pdf, towards) = (number(s.pdf), vector(s.direction));
        rows.push(("phase function sample", format!("direction {towards}, pdf {pdf}")));
        roulette(rows, s);
    }
}

fn surface(node: &mut Node, v: &Vertex<'_>, s: &Surface<'_>) {
    node.to = Some(v.position);
    node.weight = v.throughput;
    node.target = s.object.label();
    let chosen = s.chosen.map_or(String::new(), |c| format!(", mix chose {}", c.label()));
    node.material = Some(format!("{}{chosen}", s.material.label()));
    (node.primitive, node.shape) = (Some(s.object.primitive), s.object.shape);
    let transmits = v.scatter.as_ref().is_some_and(|s| s.lobe.transmission);
    let inside_mirror = v.scatter.as_ref().is_some_and(|s| s.lobe.delta && !s.lobe.transmission);
    node.remark = match (v.passage, s.outside) {
        (Passage::Hole, _) => "passes: transparent by stochastic alpha test",
        (Passage::Hidden, _) => "passes: inside a solid of higher priority",
        (Passage::Interface, true) => "enters a medium",
        (Passage::Interface, false) => "leaves a medium",
        (Passage::Medium, _) => "",
        (Passage::Exit, _) => "exits the translucent body",
        (Passage::Surface, _) if s.random_walk.is_some() => "hit from inside the translucent body",
        (Passage::Pane, _) => "passes: thin clear surface",
        (Passage::Surface, true) if transmits => "enters",
        (Passage::Surface, false) if transmits => "leaves",
        (Passage::Surface, false) if inside_mirror => "internal reflection",
        (Passage::Surface, false) => "hit from inside",
        (Passage::Surface, true) => "",
    }
    .to_owned();
    let rows = &mut node.rows;
    rows.push(("t", number(v.t)));
    rows.push(("origin", vector(v.origin)));
    rows.push(("direction", vector(v.direction)));
    rows.push(("hits", vector(v.position)));
    let tilted = match s.shading_normal {
        n if n == s.geometric_normal => String::new(),
        n => format!(", shading {}", vector(n)),
    };
    rows.push(("normal", format!("{}{tilted}", vector(s.geometric_normal))));
    if !v.inside.is_empty() {
        let inside: Vec<String> = v.inside.iter().map(|m| m.label()).collect();
        let left = v.transmittance.map_or(String::new(), |left| format!(", transmittance {}", color(left)));
        rows.push(("inside", format!("{}{left}", inside.join(" and "))));
    }
    if let Some(walk) = &s.random_walk {
        rows.push((
            "random walk",
            format!("{} steps, length {}, weight {}", walk.steps, number(walk.length), color(walk.weight)),
        ));
    }
    rows.push(("throughput", color(v.throughput)));
    if let Some(ior) = s.exterior_ior.filter(|&ior| ior != 1.0) {
        rows.push(("exterior IOR", number(ior)));
    }
    if let Some(band) = v.band {
        let carries = s.dispersed.map_or(String::new(), |t| format!(", new throughput {}", color(t)));
        rows.push((
            "dispersion",
            format!("{} only{carries}", ["red", "green", "blue"][usize::from(band.min(2))]),
        ));
    }
    if let Some(e) = &s.emission {
        emission(rows, e);
    }
    if let Some(p) = &s.photons {
        rows.push(("photons", format!("{} within {}", p.count, number(p.radius))));
        rows.push(("adds", color(p.contribution)));
    }
    if let Some(l) = v.light.as_ref().filter(|l| l.is_traced()) {
        rows.push(("next-event estimation", color(l.contribution)));
    }
    if let Some(s) = &v.scatter {
        bsdf_sample(rows, s);
    }
}

type Rows = Vec<(&'static str, String)>;

fn emission(rows: &mut Rows, e: &Emission) {
    let pdf = e.pdf.map_or("not sampled as a light".to_owned(), |p| format!("pdf {}", number(p)));
    let weight = format!("MIS weight {}", number(e.mis_weight));
    rows.push((
        "emission",
        format!("{}; {pdf}, light pdf {}, {weight}", color(e.radiance), number(e.light_pdf)),
    ));
    rows.push(("adds", color(e.contribution)));
}

fn bsdf_sample(rows: &mut Rows, s: &Scatter) {
    let eta = if s.eta == 1.0 { String::new() } else { format!(", eta {}", number(s.eta)) };
    rows.push(("BSDF sample", format!("{}, direction {}", lobe(&s.lobe), vector(s.direction))));
    let f = color(s.bsdf);
    let (pdf, cosine) = (number(s.pdf), number(s.cosine));
    rows.push(("BSDF value", format!("{f}, pdf {pdf}, cosine {cosine}{eta}, weight {}", color(s.weight))));
    roulette(rows, s);
}

fn roulette(rows: &mut Rows, s: &Scatter) {
    if let Some(r) = &s.roulette {
        let (random, survival) = (r.random_number, r.survival_probability);
        let outcome = if random < survival { "survives" } else { "terminates" };
        rows.push((
            "Russian roulette",
            format!("{outcome}: random number {}, survival probability {}", number(random), number(survival)),
        ));
    }
}

fn light(parent: usize, p: DVec3, l: &Light<'_>) -> Node {
    let from = l.shadow_origin.unwrap_or(p);
    let mut node = Node::new(Kind::Shadow, Some(parent), from, l.direction);
    node.to = l.distance.is_finite().then_some(p + l.direction * l.distance);
    if let (Some(first), Some(true)) = (l.occluders.first(), l.visibility.map(|v| v.is_black())) {
        // A shadow ray to a light at a finite distance is not normalised: t = 1 at the light.
        let along = node.to.map_or(l.direction, |to| to - from);
        node.to = Some(from + first.t * along);
    }
    node.target = "next-event estimation".to_owned();
    node.light = Some((0, l.contribution));
    node.traced = l.is_traced();
    node.open = l.visibility.is_some_and(|visibility| !visibility.is_black());
    node.remark = match l.visibility {
        None => "contributes nothing, no shadow ray".to_owned(),
        Some(visible) if visible.is_black() => format!("in shadow of {}", list(&l.occluders)),
        Some(visible) if visible == Spectrum::WHITE => "light visible".to_owned(),
        Some(visible) if l.occluders.is_empty() => format!("through a medium: {}", color(visible)),
        Some(visible) => format!("through {}: {}", list(&l.occluders), color(visible)),
    };
    if let Some(first) = l.occluders.first() {
        (node.primitive, node.shape) = (Some(first.object.primitive), first.object.shape);
    }
    node.touches = l.touches;
    let rows = &mut node.rows;
    rows.push(("direction", format!("{}, distance {}", vector(l.direction), number(l.distance))));
    let delta = if l.delta { " (delta light)" } else { "" };
    rows.push(("radiance", format!("{}, pdf {}{delta}", color(l.radiance), number(l.pdf))));
    let (f, pdf) = (color(l.bsdf), number(l.bsdf_pdf));
    rows.push(("BSDF value", format!("{f}, pdf {pdf}, cosine {}", number(l.cosine))));
    rows.push(("MIS weight", number(l.mis_weight)));
    if l.candidates > 1 {
        let weight = number(l.resampling_weight);
        rows.push(("candidates", format!("{}, resampling weight {weight}", l.candidates)));
    }
    if let Some(left) = l.transmittance {
        rows.push(("transmittance", color(left)));
    }
    rows.push(("unoccluded", color(l.unshadowed)));
    rows.push(("adds", color(l.contribution)));
    node
}
