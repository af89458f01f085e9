//! A path as text: a paragraph for each surface, and the sum.

use turner::bsdf::Lobe;
use turner::color::Spectrum;
use turner::integrator::path::{
    EmissionRecord, End, EscapeRecord, LightRecord, Passage, ScatterRecord, VertexRecord,
};
use turner::math::DVec3;
use turner::scene::MaterialId;

use super::Explained;

/// Six digits.
fn number(v: f64) -> String {
    // Zero has no sign here.
    let v = v + 0.0;
    let scientific = format!("{v:.5e}");
    let exponent = scientific.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if !(-4..7).contains(&exponent) {
        return scientific;
    }
    let text = format!("{v:.*}", (5 - exponent).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn vector(v: DVec3) -> String {
    let [x, y, z] = v.to_array().map(number);
    format!("({x}, {y}, {z})")
}

fn color(s: Spectrum) -> String {
    let [r, g, b] = s.to_array().map(|v| number(f64::from(v)));
    format!("[{r}, {g}, {b}]")
}

/// With all digits that count.
fn exact(s: Spectrum) -> String {
    format!("[{}, {}, {}]", s.r, s.g, s.b)
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

fn pdf_beside_lights(pdf: Option<f64>) -> String {
    pdf.map_or("no light sampling beside it".to_owned(), |pdf| format!("pdf {}", number(pdf)))
}

pub(super) fn of(e: &Explained<'_>) -> String {
    let (path, scene) = (&e.path, &e.ready.scene);
    let mut out = format!(
        "{}: pixel {},{}, sample {} of {}, integrator \"{}\", seed {}\n",
        e.scene,
        path.id.x,
        path.id.y,
        path.id.index,
        scene.film.samples_per_pixel(),
        scene.integrator.type_name(),
        path.id.seed
    );
    let [column, row] = path.place.map(number);
    out += &format!("camera ray at ({column}, {row}) of the picture\n");
    out += &format!("  from {} towards {}\n", vector(path.origin), vector(path.direction));
    if path.time != 0.0 {
        out += &format!("  time {}\n", number(f64::from(path.time)));
    }
    for (i, vertex) in path.vertices.iter().enumerate() {
        e.vertex(&mut out, i + 1, vertex);
    }
    if let Some(escape) = &path.escape {
        escaped(&mut out, escape);
    }
    out += &format!("end: {}\n\n", end(path.end));
    for (what, part) in e.parts() {
        out += &format!("  {what:<20} {}\n", exact(part));
    }
    out += &format!("  {:<20} {}\n", "sum", exact(path.sum()));
    let equal = match (e.is_exact(), e.rendered.is_finite()) {
        (true, true) => "equal to the last bit",
        (_, false) => "no finite number: left out of the picture",
        (false, true) => "NOT EQUAL",
    };
    out += &format!("  {:<20} {}  {equal}\n", "sample as rendered", exact(e.rendered));
    out
}

fn end(end: End) -> &'static str {
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

impl Explained<'_> {
    /// What was added, in order, with what it was.
    fn parts(&self) -> Vec<(String, Spectrum)> {
        let mut parts = Vec::new();
        for (i, v) in self.path.vertices.iter().enumerate() {
            if let Some(e) = &v.emission {
                parts.push((format!("{} shines", i + 1), e.contribution));
            }
            if let Some(l) = v.light.as_ref().filter(|l| l.visible.is_some()) {
                parts.push((format!("{} lit", i + 1), l.contribution));
            }
        }
        parts.extend(self.path.escape.as_ref().map(|e| ("outside".to_owned(), e.contribution)));
        parts
    }

    fn material(&self, id: MaterialId) -> String {
        match self.name(id) {
            Some(name) => format!("\"{name}\""),
            None => format!("material {}", id.0),
        }
    }

    fn vertex(&self, out: &mut String, number_of: usize, v: &VertexRecord) {
        let side = if v.outside { "outside" } else { "inside" };
        let mut material = self.material(v.material);
        if let Some(chosen) = v.chosen {
            material += &format!(", of which {}", self.material(chosen));
        }
        *out += &format!(
            "{number_of}  t {}  {material}, {side}, primitive {} part {}\n",
            number(v.t),
            v.primitive,
            v.part
        );
        *out += &format!("   at {}, normal {}", vector(v.p), vector(v.ng));
        *out += &match v.ns == v.ng {
            true => "\n".to_owned(),
            false => format!(", shading normal {}\n", vector(v.ns)),
        };
        if !v.inside.is_empty() {
            let names: Vec<String> = v.inside.iter().map(|&id| self.material(id)).collect();
            let left = v.transmittance.map_or(String::new(), |left| format!(", which left {}", color(left)));
            *out += &format!("   through {}{left}\n", names.join(" and "));
        }
        *out += &format!("   throughput {}\n", color(v.throughput));
        match v.passage {
            Passage::Surface => {}
            Passage::Hole => *out += "   not there by chance: passed\n",
            Passage::Hidden => *out += "   within a solid that stands above it: passed\n",
            Passage::Pane => *out += "   a clear pane: passed straight\n",
        }
        if let Some(ior) = v.ior_around.filter(|&ior| ior != 1.0) {
            *out += &format!("   index of refraction around it {}\n", number(ior));
        }
        if let Some(band) = v.band {
            let carries = v.dispersed.map_or(String::new(), |t| format!(", now throughput {}", color(t)));
            *out += &format!("   band {}{carries}\n", ["red", "green", "blue"][usize::from(band.min(2))]);
        }
        if let Some(e) = &v.emission {
            shines(out, e);
        }
        if let Some(l) = &v.light {
            lit(out, l);
        }
        if let Some(s) = &v.scatter {
            scattered(out, s);
        }
    }
}

fn shines(out: &mut String, e: &EmissionRecord) {
    *out += &format!(
        "   shines {}; {}, light pdf {}, MIS weight {}\n     contributes {}\n",
        color(e.radiance),
        pdf_beside_lights(e.pdf),
        number(e.light_pdf),
        number(e.weight),
        color(e.contribution)
    );
}

fn lit(out: &mut String, l: &LightRecord) {
    let distance = if l.distance.is_finite() { number(l.distance) } else { "infinity".to_owned() };
    let kind = if l.is_delta { ", a point or direction" } else { "" };
    *out += &format!(
        "   light towards {}, distance {distance}, pdf {}{kind}\n     radiance {}\n",
        vector(l.direction),
        number(l.pdf),
        color(l.radiance)
    );
    *out += &format!(
        "     BSDF {}, pdf {}, cosine {}, MIS weight {}\n",
        color(l.bsdf),
        number(l.bsdf_pdf),
        number(l.cosine),
        number(l.weight)
    );
    if let Some(left) = l.transmittance {
        *out += &format!("     solids on the way leave {}\n", color(left));
    }
    *out += &match l.visible {
        None => "     contributes nothing\n".to_owned(),
        Some(visible) if visible.is_black() => format!("     in shadow; else {}\n", color(l.unshadowed)),
        Some(visible) => {
            let share = match visible == Spectrum::WHITE {
                true => "visible".to_owned(),
                false => format!("visible share {}", color(visible)),
            };
            format!("     {share}, contributes {}\n", color(l.contribution))
        }
    };
}

fn scattered(out: &mut String, s: &ScatterRecord) {
    let eta = if s.eta == 1.0 { String::new() } else { format!(", eta {}", number(s.eta)) };
    *out += &format!("   goes on by {} towards {}\n", lobe(&s.lobe), vector(s.direction));
    *out += &format!(
        "     BSDF {}, pdf {}, cosine {}{eta}, weight {}\n",
        color(s.bsdf),
        number(s.pdf),
        number(s.cosine),
        color(s.weight)
    );
    if let Some(r) = s.roulette {
        let lives = if r.number < r.survival { "survived" } else { "lost" };
        *out +=
            &format!("     Russian roulette {lives}: {} against {}\n", number(r.number), number(r.survival));
    }
}

fn escaped(out: &mut String, e: &EscapeRecord) {
    *out += &format!("outside, towards {}\n", vector(e.direction));
    if let Some(left) = e.transmittance {
        *out += &format!("   solids on the way leave {}\n", color(left));
    }
    *out += &format!("   throughput {}\n", color(e.throughput));
    for light in &e.lights {
        *out += &format!(
            "   light {}; {}, light pdf {}, MIS weight {}\n",
            color(light.radiance),
            pdf_beside_lights(e.pdf),
            number(light.light_pdf),
            number(light.weight)
        );
    }
    for (what, light) in [("background", e.background), ("ambient", e.ambient)] {
        if !light.is_black() {
            *out += &format!("   {what} {}\n", color(light));
        }
    }
    *out += &format!("   contributes {}\n", color(e.contribution));
}
