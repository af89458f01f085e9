//! One sample's path, as nodes: a chain of rays, with the lights that were sampled beside it.

use turner::color::Spectrum;
use turner::integrator::path::{End, Passage};
use turner::math::DVec3;

use super::classic::casters_of;
use super::model::{Kind, Node, SampleTree};
use super::number::{color, number, vector};
use super::record::path::{
    Emission, Escape, Light, Lobe, Path, Scatter, Second, Shared, Surface, Vertex, Way,
};

pub(super) fn end(end: End) -> &'static str {
    match end {
        End::Escaped => "it leaves the scene",
        End::Absorbed => "the light is absorbed",
        End::Depth => "`max_depth` is reached",
        End::Transparency => "`max_transparent` is reached",
        End::Roulette => "Russian roulette",
        End::Unlit => "the surface is unlit",
        End::Vertices => "the limit on surfaces per path is reached",
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
    let lent = path.shared.as_ref().and_then(|s| s.from);
    // What leaves the surface that is shared counts by this.
    let own = path.shared.iter().flat_map(|s| &s.paths).find(|p| p.own).map(|p| p.share);
    let own = own.unwrap_or(Spectrum::BLACK);
    let mut places = Vec::new();
    for (number, v) in path.vertices.iter().enumerate() {
        let place = out.nodes.len();
        places.push(place);
        vertex(
            out,
            Node::new(kind, parent, v.origin, v.direction),
            v,
            lent.filter(|&from| number >= from).map(|_| own),
        );
        parent = Some(place);
        kind = match (&v.scatter, v.passage) {
            (Some(s), Passage::Surface | Passage::Medium | Passage::Exit) => kind_of(&s.lobe),
            _ => Kind::Straight,
        };
    }
    if let Some(e) = &path.escape {
        escape(out, Node::new(kind, parent, e.origin, e.direction), e, lent.map(|_| own));
    }
    if let Some(shared) = &path.shared {
        group(out, path, shared, &places);
    }
}

/// Adds the ray to a vertex, and those to its lights. With `own` the sample gets its share of all of it with its group.
fn vertex(out: &mut SampleTree, mut node: Node, v: &Vertex<'_>, own: Option<Spectrum>) {
    let (place, parts) = (out.nodes.len(), out.parts.len());
    match &v.surface {
        Some(s) => surface(&mut node, v, s),
        None => in_medium(&mut node, v),
    }
    let mut second = None;
    if let Some(way) = &v.way {
        through_medium(&mut node, way);
        add(out, &mut node, "emission of the medium", way.emission);
        second = way.second.as_ref();
    }
    node.touches = v.touches;
    let of = v.surface.as_ref();
    add(out, &mut node, "emission", of.and_then(|s| s.emission.as_ref()).map(|e| e.contribution));
    add(out, &mut node, "photons", of.and_then(|s| s.photons.as_ref()).map(|p| p.contribution));
    add(out, &mut node, "light sampled in a medium", second_light(second));
    let sampled = v.light.as_ref().filter(|l| l.is_traced());
    add(out, &mut node, "sampled light", sampled.map(|l| l.contribution));
    if let Some(own) = own {
        // The sample gets its share of all of it with its group.
        out.parts.truncate(parts);
        node.contribution = node.contribution * own;
    }
    out.nodes.push(node);
    if let Some(Second { t, light: l }) = second {
        out.nodes.push(light(place, v.origin + v.direction * *t, l));
    }
    if let Some(l) = &v.light {
        out.nodes.push(light(place, v.position, l));
    }
}

/// Adds what the next node brings by itself.
fn add(out: &mut SampleTree, node: &mut Node, what: &'static str, part: Option<Spectrum>) {
    if let Some(part) = part {
        out.parts.push((out.nodes.len(), what, part));
        node.contribution += part;
    }
}

/// Adds the ray that leaves the scene; `own` as for vertices.
fn escape(out: &mut SampleTree, mut node: Node, e: &Escape<'_>, own: Option<Spectrum>) {
    node.target = "outside".to_owned();
    node.weight = e.throughput;
    node.contribution = e.contribution;
    let mut second = None;
    if let Some(way) = &e.way {
        through_medium(&mut node, way);
        add(out, &mut node, "emission of the medium", way.emission);
        second = way.second.as_ref();
    }
    let rows = &mut node.rows;
    rows.push(("towards", vector(e.direction)));
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
    let place = out.nodes.len();
    match own {
        Some(own) => node.contribution = e.contribution * own,
        None => out.parts.push((place, "outside", e.contribution)),
    }
    add(out, &mut node, "light sampled in a medium", second_light(second));
    out.nodes.push(node);
    if let Some(Second { t, light: l }) = second {
        out.nodes.push(light(place, e.origin + e.direction * *t, l));
    }
}

/// What the paths of the group bring: the sample's own as part of its tree, each other one as a ray to where it is shared.
fn group(out: &mut SampleTree, path: &Path<'_>, shared: &Shared, places: &[usize]) {
    for part in &shared.paths {
        let share = color(part.share);
        if let Some(place) = shared.from.filter(|_| part.own).and_then(|from| places.get(from)) {
            out.parts.push((*place, "own path, shared", part.contribution));
            if let Some(node) = out.nodes.get_mut(*place) {
                let rows = &mut node.rows;
                rows.push((
                    "shared",
                    "from here on the path belongs to its group: contribution by weight".to_owned(),
                ));
                rows.push(("weight", share));
                rows.push(("adds", color(part.contribution)));
            }
            continue;
        }
        let (Some(first), Some(&parent)) = (path.vertices.first(), places.first()) else { continue };
        let mut node = Node::new(
            Kind::Diffuse,
            Some(parent),
            first.position,
            (part.position - first.position).normalize_or_zero(),
        );
        node.to = Some(part.position);
        node.target = format!("the path of column {}, row {}", part.pixel[0], part.pixel[1]);
        node.remark = "shared".to_owned();
        node.weight = part.share;
        node.contribution = part.contribution;
        let rows = &mut node.rows;
        rows.push(("hits", vector(part.position)));
        rows.push(("radiance", color(part.radiance)));
        rows.push(("weight", share));
        rows.push(("adds", color(part.contribution)));
        out.parts.push((out.nodes.len(), "path of a neighbour", part.contribution));
        out.nodes.push(node);
    }
}

/// What a light that was sampled on the way adds.
fn second_light(second: Option<&Second<'_>>) -> Option<Spectrum> {
    second.filter(|s| s.light.is_traced()).map(|s| s.light.contribution)
}

fn through_medium(node: &mut Node, way: &Way<'_>) {
    let whose = way.inside.map_or("outside all objects".to_owned(), |m| format!("inside {}", m.label()));
    let (length, weight) = (number(way.length), color(way.weight));
    node.rows.push(("through a medium", format!("{whose}, length {length}, weight {weight}")));
    if let Some(shone) = way.emission {
        node.rows.push(("emission", color(shone)));
    }
}

fn in_medium(node: &mut Node, v: &Vertex<'_>) {
    node.to = Some(v.position);
    node.weight = v.throughput;
    node.target = "a medium".to_owned();
    node.remark = "scattered".to_owned();
    let rows = &mut node.rows;
    rows.push(("t", number(v.t)));
    rows.push(("from", vector(v.origin)));
    rows.push(("towards", vector(v.direction)));
    rows.push(("at", vector(v.position)));
    rows.push(("throughput", color(v.throughput)));
    if let Some(s) = &v.scatter {
        let (pdf, towards) = (number(s.pdf), vector(s.direction));
        rows.push(("continues by", format!("the phase function towards {towards}, pdf {pdf}")));
        gambled(rows, s);
    }
}

fn surface(node: &mut Node, v: &Vertex<'_>, s: &Surface<'_>) {
    node.to = Some(v.position);
    node.weight = v.throughput;
    node.target = s.object.label();
    let chosen = s.chosen.map_or(String::new(), |c| format!(", of which {}", c.label()));
    node.material = Some(format!("{}{chosen}", s.material.label()));
    (node.primitive, node.shape) = (Some(s.object.primitive), s.object.shape);
    let transmits = v.scatter.as_ref().is_some_and(|s| s.lobe.transmission);
    let inside_mirror = v.scatter.as_ref().is_some_and(|s| s.lobe.delta && !s.lobe.transmission);
    node.remark = match (v.passage, s.outside) {
        (Passage::Hole, _) => "transparent by stochastic opacity: passed",
        (Passage::Hidden, _) => "inside a solid of higher priority: passed",
        (Passage::Boundary, true) => "enters a medium",
        (Passage::Boundary, false) => "leaves a medium",
        (Passage::Medium, _) => "",
        (Passage::Exit, _) => "leaves the body",
        (Passage::Surface, _) if s.walk.is_some() => "hit inside the body",
        (Passage::Pane, _) => "a thin clear surface: passed straight",
        (Passage::Surface, true) if transmits => "enters",
        (Passage::Surface, false) if transmits => "leaves",
        (Passage::Surface, false) if inside_mirror => "reflected inside",
        (Passage::Surface, false) => "hit from inside",
        (Passage::Surface, true) => "",
    }
    .to_owned();
    let rows = &mut node.rows;
    rows.push(("t", number(v.t)));
    rows.push(("from", vector(v.origin)));
    rows.push(("towards", vector(v.direction)));
    rows.push(("hits", vector(v.position)));
    let tilted = match s.shading_normal {
        n if n == s.geometric_normal => String::new(),
        n => format!(", shading {}", vector(n)),
    };
    rows.push(("normal", format!("{}{tilted}", vector(s.geometric_normal))));
    if !v.inside.is_empty() {
        let inside: Vec<String> = v.inside.iter().map(|m| m.label()).collect();
        let left = v.transmittance.map_or(String::new(), |left| format!(", transmittance {}", color(left)));
        rows.push(("through", format!("{}{left}", inside.join(" and "))));
    }
    if let Some(walk) = &s.walk {
        rows.push((
            "walk inside",
            format!("{} steps, length {}, weight {}", walk.steps, number(walk.length), color(walk.weight)),
        ));
    }
    rows.push(("throughput", color(v.throughput)));
    if let Some(ior) = s.ior_around.filter(|&ior| ior != 1.0) {
        rows.push(("outer index of refraction", number(ior)));
    }
    if let Some(band) = v.band {
        let carries = s.dispersed.map_or(String::new(), |t| format!(", now throughput {}", color(t)));
        rows.push(("band", format!("{}{carries}", ["red", "green", "blue"][usize::from(band.min(2))])));
    }
    if let Some(e) = &s.emission {
        shines(rows, e);
    }
    if let Some(p) = &s.photons {
        rows.push(("photons", format!("{} within {}", p.count, number(p.radius))));
        rows.push(("add", color(p.contribution)));
    }
    if let Some(l) = v.light.as_ref().filter(|l| l.is_traced()) {
        rows.push(("lit", color(l.contribution)));
    }
    if let Some(s) = &v.scatter {
        scattered(rows, s);
    }
}

type Rows = Vec<(&'static str, String)>;

fn shines(rows: &mut Rows, e: &Emission) {
    let pdf = e.pdf.map_or("not sampled as a light".to_owned(), |p| format!("pdf {}", number(p)));
    let weight = format!("MIS weight {}", number(e.mis_weight));
    rows.push((
        "emission",
        format!("{}; {pdf}, light pdf {}, {weight}", color(e.radiance), number(e.light_pdf)),
    ));
    rows.push(("adds", color(e.contribution)));
}

fn scattered(rows: &mut Rows, s: &Scatter) {
    let eta = if s.eta == 1.0 { String::new() } else { format!(", eta {}", number(s.eta)) };
    rows.push(("continues by", format!("{} towards {}", lobe(&s.lobe), vector(s.direction))));
    let f = color(s.bsdf);
    let (pdf, cosine) = (number(s.pdf), number(s.cosine));
    rows.push(("BSDF", format!("{f}, pdf {pdf}, cosine {cosine}{eta}, weight {}", color(s.weight))));
    gambled(rows, s);
}

fn gambled(rows: &mut Rows, s: &Scatter) {
    if let Some(r) = &s.roulette {
        let lives = if r.number < r.survival { "survived" } else { "terminated" };
        rows.push(("roulette", format!("{lives}: {} against {}", number(r.number), number(r.survival))));
    }
}

fn light(parent: usize, p: DVec3, l: &Light<'_>) -> Node {
    let from = l.shadow_origin.unwrap_or(p);
    let mut node = Node::new(Kind::Shadow, Some(parent), from, l.direction);
    node.to = l.distance.is_finite().then_some(p + l.direction * l.distance);
    if let (Some(first), Some(true)) = (l.by.first(), l.visible.map(|v| v.is_black())) {
        // Along rays to lights that have a place t is 1 there.
        let way = node.to.map_or(l.direction, |to| to - from);
        node.to = Some(from + first.t * way);
    }
    node.target = "sampled light".to_owned();
    node.light = Some((0, l.contribution));
    node.traced = l.is_traced();
    node.open = l.visible.is_some_and(|visible| !visible.is_black());
    node.remark = match l.visible {
        None => "contributes nothing".to_owned(),
        Some(visible) if visible.is_black() => format!("in shadow of {}", casters_of(&l.by)),
        Some(visible) if visible == Spectrum::WHITE => "visible".to_owned(),
        Some(visible) if l.by.is_empty() => format!("through a medium: {}", color(visible)),
        Some(visible) => format!("through {}: {}", casters_of(&l.by), color(visible)),
    };
    if let Some(first) = l.by.first() {
        (node.primitive, node.shape) = (Some(first.object.primitive), first.object.shape);
    }
    node.touches = l.touches;
    let rows = &mut node.rows;
    rows.push(("towards", format!("{}, distance {}", vector(l.direction), number(l.distance))));
    let delta = if l.delta { " (a point or a direction)" } else { "" };
    rows.push(("radiance", format!("{}, pdf {}{delta}", color(l.radiance), number(l.pdf))));
    let (f, pdf) = (color(l.bsdf), number(l.bsdf_pdf));
    rows.push(("BSDF", format!("{f}, pdf {pdf}, cosine {}", number(l.cosine))));
    rows.push(("MIS weight", number(l.mis_weight)));
    if l.candidates > 1 {
        rows.push(("chosen", format!("of {} lights, counts {}", l.candidates, number(l.counts))));
    }
    if let Some(left) = l.transmittance {
        rows.push(("transmittance", color(left)));
    }
    rows.push(("unshadowed", color(l.unshadowed)));
    rows.push(("adds", color(l.contribution)));
    node
}
