//! One sample's path, as nodes: a chain of rays, with the lights that were sampled beside it.

use turner::bsdf::Lobe;
use turner::color::Spectrum;
use turner::integrator::path::{
    EmissionRecord, End, LightRecord, Passage, PathRecord, ScatterRecord, SharedRecord, VertexRecord,
    WayRecord,
};
use turner::math::DVec3;
use turner::render::SampleRecord;

use super::classic::casters_of;
use super::model::{Kind, Node, SampleTree};
use super::names::Names;
use super::number::{color, number, vector};

pub(super) fn end(end: End) -> &'static str {
    match end {
        End::Escaped => "it left the scene",
        End::Absorbed => "nothing is scattered further",
        End::Depth => "as many scatterings as the integrator allows",
        End::Transparency => "as many surfaces passed straight as the integrator allows",
        End::Roulette => "Russian roulette",
        End::Unlit => "the surface shows its colour without light",
        End::Vertices => "more surfaces than one path may meet",
        End::LeftOut => "the camera shows nothing there",
    }
}

fn lobe(lobe: &Lobe) -> &'static str {
    match (lobe.is_delta, lobe.is_transmission, lobe.is_diffuse) {
        (true, false, _) => "mirror reflection",
        (true, true, _) => "clear transmission",
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

/// A sample's path; `wanted` is what `--path-of` asks for.
pub(super) fn tree(
    names: &Names<'_>,
    path: &PathRecord,
    number: usize,
    sample: SampleRecord,
    wanted: Option<&str>,
) -> SampleTree {
    let mut out = SampleTree::new(number, sample, path.sum());
    out.remarks.push(format!("the path ends: {}", end(path.end)));
    let (mut parent, mut kind) = (None, Kind::Camera);
    let lent = path.shared.as_ref().and_then(|s| s.from);
    let own = path.shared.iter().flat_map(|s| &s.parts).find(|p| p.id == path.id).map(|p| p.share);
    let mut places = Vec::new();
    for (number, v) in path.vertices.iter().enumerate() {
        let place = out.nodes.len();
        places.push(place);
        let parts = out.parts.len();
        let mut node = Node::new(kind, parent, v.origin, v.direction);
        surface(names, &mut node, v);
        let mut second = None;
        if let Some(way) = &v.way {
            through_medium(names, &mut node, way);
            if let Some(shone) = way.emission {
                out.parts.push((place, "light of the medium", shone));
                node.contribution += shone;
            }
            second = way.second.as_ref();
        }
        node.touches = wanted.is_some_and(|w| names.is(w, v.primitive, v.shape, v.material));
        if let Some(e) = &v.emission {
            out.parts.push((place, "emission", e.contribution));
            node.contribution += e.contribution;
        }
        if let Some(p) = &v.photons {
            out.parts.push((place, "photons", p.contribution));
            node.contribution += p.contribution;
        }
        if let Some(light) = second_light(second) {
            out.parts.push((place, "light sampled on the way", light));
            node.contribution += light;
        }
        if let Some(l) = v.light.as_ref().filter(|l| l.visible.is_some()) {
            out.parts.push((place, "sampled light", l.contribution));
            node.contribution += l.contribution;
        }
        if lent.is_some_and(|from| number >= from) {
            // The sample gets its share of all of it, below.
            out.parts.truncate(parts);
            node.contribution = node.contribution * own.unwrap_or(Spectrum::BLACK);
        }
        out.nodes.push(node);
        if let Some((t, l)) = second {
            out.nodes.push(light(names, place, v.origin + v.direction * *t, l, wanted));
        }
        if let Some(l) = &v.light {
            out.nodes.push(light(names, place, v.p, l, wanted));
        }
        parent = Some(place);
        kind = match (&v.scatter, v.passage) {
            (Some(s), Passage::Surface | Passage::Medium | Passage::Exit) => kind_of(&s.lobe),
            _ => Kind::Straight,
        };
    }
    if let Some(e) = &path.escape {
        let mut node = Node::new(kind, parent, e.origin, e.direction);
        node.target = "outside".to_owned();
        node.weight = e.throughput;
        node.contribution = e.contribution;
        let mut second = None;
        if let Some(way) = &e.way {
            through_medium(names, &mut node, way);
            if let Some(shone) = way.emission {
                out.parts.push((out.nodes.len(), "light of the medium", shone));
                node.contribution += shone;
            }
            second = way.second.as_ref();
        }
        let rows = &mut node.rows;
        rows.push(("towards", vector(e.direction)));
        rows.push(("throughput", color(e.throughput)));
        if let Some(left) = e.transmittance {
            rows.push(("transmittance", color(left)));
        }
        for l in &e.lights {
            let pdf = e.pdf.map_or("none".to_owned(), number_of);
            rows.push(("light around", color(l.radiance)));
            rows.push(("pdf", format!("{pdf}, light pdf {}", number_of(l.light_pdf))));
            rows.push(("MIS weight", number_of(l.weight)));
        }
        for (what, light) in [("background", e.background), ("ambient", e.ambient)] {
            if !light.is_black() {
                rows.push((what, color(light)));
            }
        }
        rows.push(("adds", color(e.contribution)));
        let place = out.nodes.len();
        if lent.is_some() {
            node.contribution = e.contribution * own.unwrap_or(Spectrum::BLACK);
        } else {
            out.parts.push((place, "outside", e.contribution));
        }
        if let Some(light) = second_light(second) {
            out.parts.push((place, "light sampled on the way", light));
            node.contribution += light;
        }
        out.nodes.push(node);
        if let Some((t, l)) = second {
            out.nodes.push(light(names, place, e.origin + e.direction * *t, l, wanted));
        }
    }
    if let Some(shared) = &path.shared {
        group(&mut out, path, shared, &places);
    }
    out.add_up();
    out
}

/// What the paths of the group bring: the sample's own as part of its tree, each other one as a ray to where it is shared.
fn group(out: &mut SampleTree, path: &PathRecord, shared: &SharedRecord, places: &[usize]) {
    for part in &shared.parts {
        let share = color(part.share);
        if let Some(place) = shared.from.filter(|_| part.id == path.id).and_then(|from| places.get(from)) {
            out.parts.push((*place, "own path, shared", part.contribution));
            if let Some(node) = out.nodes.get_mut(*place) {
                let rows = &mut node.rows;
                rows.push((
                    "shared",
                    "from here on the path is one of the group's: what leaves, by share".to_owned(),
                ));
                rows.push(("share", share));
                rows.push(("adds", color(part.contribution)));
            }
            continue;
        }
        let (Some(first), Some(&parent)) = (path.vertices.first(), places.first()) else { continue };
        let mut node =
            Node::new(Kind::Diffuse, Some(parent), first.p, (part.p - first.p).normalize_or_zero());
        node.to = Some(part.p);
        node.target = format!("what the path of column {}, row {} found", part.id.x, part.id.y);
        node.remark = "shared".to_owned();
        node.weight = part.share;
        node.contribution = part.contribution;
        let rows = &mut node.rows;
        rows.push(("hits", vector(part.p)));
        rows.push(("radiance", color(part.radiance)));
        rows.push(("share", share));
        rows.push(("adds", color(part.contribution)));
        out.parts.push((out.nodes.len(), "path of a neighbour", part.contribution));
        out.nodes.push(node);
    }
}

/// What a light that was sampled on the way adds.
fn second_light(second: Option<&(f64, LightRecord)>) -> Option<Spectrum> {
    second.filter(|(_, l)| l.visible.is_some()).map(|(_, l)| l.contribution)
}

fn through_medium(names: &Names<'_>, node: &mut Node, way: &WayRecord) {
    let whose = way.solid.map_or("in the open".to_owned(), |id| format!("inside {}", names.material(id)));
    let (length, weight) = (number(way.length), color(way.weight));
    node.rows.push(("through a medium", format!("{whose}, length {length}, weight {weight}")));
    if let Some(shone) = way.emission {
        node.rows.push(("it shines", color(shone)));
    }
}

fn number_of(v: f64) -> String {
    number(v)
}

fn surface(names: &Names<'_>, node: &mut Node, v: &VertexRecord) {
    node.to = Some(v.p);
    node.weight = v.throughput;
    if v.passage == Passage::Medium {
        node.target = "a medium".to_owned();
        node.remark = "scattered by it".to_owned();
        let rows = &mut node.rows;
        rows.push(("t", number(v.t)));
        rows.push(("from", vector(v.origin)));
        rows.push(("towards", vector(v.direction)));
        rows.push(("at", vector(v.p)));
        rows.push(("throughput", color(v.throughput)));
        if let Some(s) = &v.scatter {
            let (pdf, towards) = (number(s.pdf), vector(s.direction));
            rows.push(("goes on by", format!("the phase function towards {towards}, pdf {pdf}")));
            gambled(rows, s);
        }
        return;
    }
    node.target = names.object(v.primitive, v.shape);
    let chosen = v.chosen.map_or(String::new(), |c| format!(", of which {}", names.material(c)));
    node.material = Some(format!("{}{chosen}", names.material(v.material)));
    (node.primitive, node.shape) = (Some(v.primitive), v.shape);
    let transmits = v.scatter.as_ref().is_some_and(|s| s.lobe.is_transmission);
    let inside_mirror = v.scatter.as_ref().is_some_and(|s| s.lobe.is_delta && !s.lobe.is_transmission);
    node.remark = match (v.passage, v.outside) {
        (Passage::Hole, _) => "not there by chance: passed",
        (Passage::Hidden, _) => "within a solid that stands above it: passed",
        (Passage::Boundary, true) => "enters a medium",
        (Passage::Boundary, false) => "leaves a medium",
        (Passage::Medium, _) => "",
        (Passage::Exit, _) => "comes out of the body",
        (Passage::Surface, _) if v.walk.is_some() => "met within the body",
        (Passage::Pane, _) => "a clear pane: passed straight",
        (Passage::Surface, true) if transmits => "enters",
        (Passage::Surface, false) if transmits => "leaves",
        (Passage::Surface, false) if inside_mirror => "reflected inside",
        (Passage::Surface, false) => "met from inside",
        (Passage::Surface, true) => "",
    }
    .to_owned();
    let rows = &mut node.rows;
    rows.push(("t", number(v.t)));
    rows.push(("from", vector(v.origin)));
    rows.push(("towards", vector(v.direction)));
    rows.push(("hits", vector(v.p)));
    let tilted = if v.ns == v.ng { String::new() } else { format!(", shading {}", vector(v.ns)) };
    rows.push(("normal", format!("{}{tilted}", vector(v.ng))));
    if !v.inside.is_empty() {
        let inside: Vec<String> = v.inside.iter().map(|&id| names.material(id)).collect();
        let left = v.transmittance.map_or(String::new(), |left| format!(", which left {}", color(left)));
        rows.push(("through", format!("{}{left}", inside.join(" and "))));
    }
    if let Some(walk) = v.walk {
        rows.push((
            "walk inside",
            format!("{} steps, length {}, weight {}", walk.steps, number(walk.length), color(walk.weight)),
        ));
    }
    rows.push(("throughput", color(v.throughput)));
    if let Some(ior) = v.ior_around.filter(|&ior| ior != 1.0) {
        rows.push(("index around", number(ior)));
    }
    if let Some(band) = v.band {
        let carries = v.dispersed.map_or(String::new(), |t| format!(", now throughput {}", color(t)));
        rows.push(("band", format!("{}{carries}", ["red", "green", "blue"][usize::from(band.min(2))])));
    }
    if let Some(e) = &v.emission {
        shines(rows, e);
    }
    if let Some(p) = &v.photons {
        rows.push(("photons", format!("{} within {}", p.count, number(p.radius))));
        rows.push(("add", color(p.contribution)));
    }
    if let Some(l) = v.light.as_ref().filter(|l| l.visible.is_some()) {
        rows.push(("lit", color(l.contribution)));
    }
    if let Some(s) = &v.scatter {
        scattered(rows, s);
    }
}

type Rows = Vec<(&'static str, String)>;

fn shines(rows: &mut Rows, e: &EmissionRecord) {
    let pdf = e.pdf.map_or("no light sampling beside it".to_owned(), |p| format!("pdf {}", number(p)));
    let weight = format!("MIS weight {}", number(e.weight));
    rows.push((
        "shines",
        format!("{}; {pdf}, light pdf {}, {weight}", color(e.radiance), number(e.light_pdf)),
    ));
    rows.push(("adds", color(e.contribution)));
}

fn scattered(rows: &mut Rows, s: &ScatterRecord) {
    let eta = if s.eta == 1.0 { String::new() } else { format!(", eta {}", number(s.eta)) };
    rows.push(("goes on by", format!("{} towards {}", lobe(&s.lobe), vector(s.direction))));
    let f = color(s.bsdf);
    let (pdf, cosine) = (number(s.pdf), number(s.cosine));
    rows.push(("BSDF", format!("{f}, pdf {pdf}, cosine {cosine}{eta}, weight {}", color(s.weight))));
    gambled(rows, s);
}

fn gambled(rows: &mut Rows, s: &ScatterRecord) {
    if let Some(r) = s.roulette {
        let lives = if r.number < r.survival { "survived" } else { "lost" };
        rows.push(("roulette", format!("{lives}: {} against {}", number(r.number), number(r.survival))));
    }
}

fn light(names: &Names<'_>, parent: usize, p: DVec3, l: &LightRecord, wanted: Option<&str>) -> Node {
    let from = l.shadow_origin.unwrap_or(p);
    let mut node = Node::new(Kind::Shadow, Some(parent), from, l.direction);
    node.to = l.distance.is_finite().then_some(p + l.direction * l.distance);
    if let (Some(first), Some(true)) = (l.casters.first(), l.visible.map(|v| v.is_black())) {
        // Along rays to lights that have a place t is 1 there.
        let way = node.to.map_or(l.direction, |to| to - from);
        node.to = Some(from + first.t * way);
    }
    node.target = "sampled light".to_owned();
    node.light = Some((0, l.contribution));
    node.traced = l.visible.is_some();
    node.open = l.visible.is_some_and(|visible| !visible.is_black());
    node.remark = match l.visible {
        None => "brings nothing".to_owned(),
        Some(visible) if visible.is_black() => format!("in shadow of {}", casters_of(names, &l.casters)),
        Some(visible) if visible == Spectrum::WHITE => "visible".to_owned(),
        Some(visible) if l.casters.is_empty() => format!("through a medium: {}", color(visible)),
        Some(visible) => format!("through {}: {}", casters_of(names, &l.casters), color(visible)),
    };
    if let Some(first) = l.casters.first() {
        (node.primitive, node.shape) = (Some(first.primitive), first.shape);
    }
    node.touches =
        wanted.is_some_and(|w| l.casters.iter().any(|c| names.is(w, c.primitive, c.shape, c.material)));
    let rows = &mut node.rows;
    rows.push(("towards", format!("{}, distance {}", vector(l.direction), number(l.distance))));
    let delta = if l.is_delta { " (a point or a direction)" } else { "" };
    rows.push(("radiance", format!("{}, pdf {}{delta}", color(l.radiance), number(l.pdf))));
    let (f, pdf) = (color(l.bsdf), number(l.bsdf_pdf));
    rows.push(("BSDF", format!("{f}, pdf {pdf}, cosine {}", number(l.cosine))));
    rows.push(("MIS weight", number(l.weight)));
    if l.candidates > 1 {
        rows.push(("chosen", format!("of {} lights, counts {}", l.candidates, number(f64::from(l.counts)))));
    }
    if let Some(left) = l.transmittance {
        rows.push(("transmittance", color(left)));
    }
    rows.push(("unshadowed", color(l.unshadowed)));
    rows.push(("adds", color(l.contribution)));
    node
}
