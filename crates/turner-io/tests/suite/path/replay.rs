//! A sample replayed is the sample rendered, and its parts are its sum.

use turner::color::Spectrum;
use turner::description::SceneDesc;
use turner::film::PixelSum;
use turner::integrator::path::{End, Passage, PathRecord, VertexRecord, replay};
use turner::integrator::{Caustics, IntegratorDesc, Prepared, Radiance};
use turner::render::sample;
use turner::schema::PrepareOptions;

use crate::classic::common::{describe, render_with};

const WIDTH: u32 = 24;
const HEIGHT: u32 = 16;

fn film(more: &str) -> String {
    format!(
        "film = {{ width = {WIDTH}, height = {HEIGHT}, antialias = \"monte-carlo\", samples = 4, {more} }}\n"
    )
}

const CAMERA: &str = "camera = { position = [0, 1.5, 5], look_at = [0, 0.7, 0], fov = 45 }\n";
const LAMP: &str = "{ type = \"box\", min = [-1, 3, -1], max = [1, 3.2, 1], material = { type = \"emissive\", strength = 5 } }";
const MIRROR: &str =
    "{ type = \"principled\", base_metalness = 1, base_color = [0.9, 0.6, 0.3], specular_roughness = 0.3 }";
const FLOOR: &str =
    "{ type = \"plane\", material = { type = \"matte\", color = { type = \"chessboard\" } } }";

/// Scenes with all that paths may meet, each with what must occur in some path of it.
fn scenes() -> Vec<(&'static str, String, Occurs)> {
    let path = "integrator = { type = \"path\", rr_start = 1 }\n";
    let base = format!("{}{CAMERA}", film(""));
    vec![
        (
            "nested glass",
            format!(
                "{base}{path}object = [{FLOOR}, {LAMP},\n\
                 {{ type = \"sphere\", center = [0, 1, 0], radius = 1, material = {{ type = \"dielectric\", ior = 1.5 }} }},\n\
                 {{ type = \"sphere\", center = [0, 1, 0.3], radius = 0.8, material = {{ type = \"principled\", transmission_weight = 1, \
                 specular_ior = 1.33, specular_roughness = 0, transmission_color = [0.3, 0.6, 0.9], transmission_depth = 0.5 }} }}]\n"
            ),
            |p| p.vertices.iter().any(|v| v.passage == Passage::Hidden || v.transmittance.is_some()),
        ),
        (
            "hidden boundaries",
            format!(
                "{base}{path}object = [{FLOOR}, {LAMP},\n\
                 {{ type = \"sphere\", center = [0, 1, 0], radius = 1, material = {{ type = \"dielectric\", ior = 1.5 }} }},\n\
                 {{ type = \"sphere\", center = [0.5, 1, 0], radius = 0.8, material = {{ type = \"dielectric\", ior = 1.3, roughness = 0.2 }} }}]\n"
            ),
            |p| p.vertices.iter().any(|v| v.passage == Passage::Hidden),
        ),
        (
            "environment",
            format!(
                "{base}{path}light = [{{ type = \"environment\" }}, {{ type = \"ambient\", intensity = 0.1 }}, \
                 {{ type = \"directional\", direction = [-1, -2, -1], angle = 3 }}]\nobject = [{FLOOR},\n\
                 {{ type = \"sphere\", center = [0, 1, 0], material = {{ type = \"metal\", roughness = 0.3 }} }}]\n"
            ),
            |p| {
                let mixed = |w: f64| w > 0.0 && w < 1.0;
                p.escape.as_ref().is_some_and(|e| e.pdf.is_some() && e.lights.iter().any(|l| mixed(l.weight)))
            },
        ),
        (
            "rough mirrors under several lights",
            format!(
                "{base}integrator = {{ type = \"path\", caustics = \"off\" }}\nlight = [{{ type = \"environment\" }}, \
                 {{ type = \"point\", position = [-2, 2, 3], intensity = 9, attenuation = \"inverse-square\" }}]\nmaterial.mirror = {MIRROR}\n\
                 object = [{LAMP}, {{ type = \"sphere\", center = [1.5, 1, 1], radius = 0.3, material = {{ type = \"emissive\", strength = 9 }} }},\n\
                 {{ type = \"sphere\", center = [-0.6, 0.7, 0], radius = 0.7, material = \"mirror\" }},\n\
                 {{ type = \"mesh\", positions = [[-3, 0, -3], [3, 0, -3], [3, 0, 3], [-3, 0, 3]], triangles = [[0, 2, 1], [0, 3, 2]], material = \"mirror\" }}]\n"
            ),
            |p| {
                let several = |v: &VertexRecord| v.light.as_ref().is_some_and(|l| l.candidates > 1 && l.counts > 1.0);
                let found = |v: &VertexRecord| v.emission.as_ref().is_some_and(|e| e.weight > 0.0 && e.weight < 1.0);
                p.vertices.iter().any(several) && p.vertices.iter().any(found)
            },
        ),
        (
            "a mesh with textures",
            format!(
                "{base}{path}object = [{LAMP}, {{ type = \"mesh\", positions = [[-2, 0, -2], [2, 0, -2], [2, 0.5, 2], [-2, 0, 2]], \
                 normals = [[0, 1, 0], [0.3, 1, 0], [0, 1, 0.3], [0, 1, 0]], uvs = [[0, 0], [1, 0], [1, 1], [0, 1]], \
                 triangles = [[0, 2, 1], [0, 3, 2]], material = {{ type = \"principled\", base_color = {{ type = \"chessboard\" }}, \
                 specular_roughness = {{ type = \"marble\" }}, coat_weight = 0.5 }} }}]\n"
            ),
            |p| p.vertices.iter().any(|v| v.ns != v.ng && v.scatter.is_some_and(|s| s.terminator < 1.0)),
        ),
        (
            "mixes and holes",
            format!(
                "{base}{path}light = [{{ type = \"point\", position = [2, 3, 4], intensity = 20, attenuation = \"inverse-square\" }}]\n\
                 object = [{FLOOR}, {LAMP},\n\
                 {{ type = \"sphere\", center = [-1, 1, 0], material = {{ type = \"mix\", materials = [{{ type = \"matte\" }}, \
                 {{ type = \"metal\" }}, {{ type = \"emissive\", strength = 2 }}], weights = [0.3, 0.3] }} }},\n\
                 {{ type = \"rectangle\", center = [0, 1, 2], edge_u = [8, 0, 0.3], edge_v = [0, 4, 0], material = {{ type = \"principled\", \
                 alpha_mode = \"blend\", opacity = 0.4 }} }}]\n"
            ),
            |p| {
                p.vertices.iter().any(|v| v.chosen.is_some())
                    && p.vertices.iter().any(|v| v.passage == Passage::Hole)
            },
        ),
        (
            "panes",
            format!(
                "{base}{path}object = [{FLOOR}, {LAMP},\n\
                 {{ type = \"rectangle\", center = [0, 1.5, 2], edge_u = [9, 0, 0], edge_v = [0, 5, 0], material = {{ type = \"dielectric\", \
                 thin = true, color = [0.9, 0.6, 0.3] }} }},\n\
                 {{ type = \"rectangle\", center = [0, 2, 0], edge_u = [9, 0, 0], edge_v = [0, 0, 9], material = {{ type = \"dielectric\", thin = true }} }}]\n"
            ),
            |p| {
                p.vertices.iter().any(|v| v.passage == Passage::Pane)
                    && p.vertices.iter().any(|v| {
                        let visible = v.light.as_ref().and_then(|l| l.visible);
                        visible.is_some_and(|s| !s.is_black() && s != Spectrum::WHITE)
                    })
            },
        ),
        (
            "dispersion",
            format!(
                "{base}{path}background.color = [0.2, 0.4, 0.6]\nobject = [{FLOOR}, {LAMP}, {{ type = \"sphere\", center = [0, 1, 0], \
                 material = {{ type = \"principled\", transmission_weight = 1, specular_roughness = 0, transmission_dispersion_scale = 2 }} }}]\n"
            ),
            |p| p.vertices.iter().any(|v| v.dispersed.is_some()),
        ),
        (
            "clamp, lens, motion, a transparent background",
            format!(
                "{}camera = {{ type = \"thin-lens\", position = [0, 1.5, 5], look_at = [0, 0.7, 0], fov = 45, focus = 5, lens_radius = 0.1 }}\n\
                 integrator = {{ type = \"path\", clamp_indirect = 0.05, max_depth = 4 }}\nbackground.transparent = true\n\
                 object = [{LAMP}, {{ type = \"sphere\", center = [0, 1, 0], motion = {{ translate = [1, 0, 0] }}, material = {{ type = \"matte\" }} }},\n\
                 {{ type = \"box\", min = [-2, -0.1, -2], max = [2, 0, 2], material = {{ type = \"matte\" }} }}]\n",
                film("shutter = [0.2, 0.9], filter = \"gaussian\"")
            ),
            |p| p.end == End::Depth && p.time > 0.0,
        ),
        (
            "flat triangles of plain materials",
            format!(
                "{base}{path}light = [{{ type = \"environment\" }}]\nobject = [{LAMP}, {FLOOR}, {}]\n",
                plain_meshes()
            ),
            |p| p.vertices.len() > 3 && p.vertices.iter().any(|v| v.transmittance.is_some()),
        ),
        (
            "the same under many lamps, with a clamp and limits",
            format!(
                "{base}integrator = {{ type = \"path\", rr_start = 2, max_depth = 5, max_diffuse = 3, max_glossy = 2, clamp_indirect = 0.5 }}\n\
                 object = [{}, {}]\n",
                plain_meshes(),
                (0..80)
                    .map(|i| {
                        format!(
                            "{{ type = \"sphere\", center = [{}, 3, {}], radius = 0.05, material = {{ type = \"emissive\", strength = 20 }} }}",
                            i % 10 - 5,
                            i / 10 - 4
                        )
                    })
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
            |p| p.end == End::Depth && p.vertices.len() > 3,
        ),
        (
            "direct",
            format!(
                "{base}integrator = {{ type = \"direct\" }}\nobject = [{FLOOR}, {LAMP},\n\
                 {{ type = \"sphere\", center = [0, 1, 0], material = {{ type = \"metal\", roughness = 0 }} }},\n\
                 {{ type = \"sphere\", center = [1.5, 1, 1], radius = 0.5, material = {{ type = \"principled\", unlit = true }} }}]\n"
            ),
            |p| p.end == End::Unlit && p.vertices.len() > 1,
        ),
        (
            "lights by chance alone",
            format!(
                "{base}integrator = {{ type = \"path\", light_sampling = \"bsdf\" }}\nobject = [{FLOOR}, {LAMP}]\n"
            ),
            |p| {
                p.vertices.len() > 1 && p.vertices.iter().any(|v| v.emission.is_some_and(|e| e.weight == 1.0))
            },
        ),
        (
            "media",
            format!(
                "{base}{path}background.medium = {{ extinction = 0.05, albedo = [0.9, 0.8, 0.7], emission = 0.01 }}\nobject = [{FLOOR}, {LAMP},\n\
                 {{ type = \"sphere\", center = [1, 1, 0], medium = {{ scattering = [2, 1, 3], anisotropy = 0.5 }} }},\n\
                 {{ type = \"sphere\", center = [-1, 1, 0], material = {{ type = \"dielectric\", interior = {{ scattering = 1, absorption = [0, 0.5, 1] }} }} }}]\n"
            ),
            |p| {
                let way = |v: &VertexRecord| {
                    v.way.as_ref().is_some_and(|w| w.emission.is_some() && w.second.is_some())
                };
                p.vertices.iter().any(|v| v.passage == Passage::Medium && v.light.is_some())
                    && p.vertices.iter().any(way)
                    && p.vertices.iter().any(|v| v.passage == Passage::Boundary)
            },
        ),
        (
            "wax",
            format!(
                "{base}{path}light = [{{ type = \"point\", position = [2, 3, 4], intensity = 20, attenuation = \"inverse-square\" }}]\n\
                 object = [{FLOOR}, {LAMP},\n\
                 {{ type = \"sphere\", center = [0, 1, 0], material = {{ type = \"principled\", subsurface_weight = 0.8, subsurface_radius = 0.1, \
                 subsurface_color = {{ type = \"marble\" }}, coat_weight = 0.5, coat_color = [1, 0.8, 0.6], subsurface_scatter_anisotropy = 0.5 }} }},\n\
                 {{ type = \"sphere\", center = [0.6, 1, 0], radius = 0.2, material = {{ type = \"emissive\", strength = 3 }} }},\n\
                 {{ type = \"box\", min = [-1.5, 0, 1], max = [-0.5, 1, 1.5], material = {{ type = \"mix\", materials = [{{ type = \"matte\" }}, \
                 {{ type = \"principled\", subsurface_weight = 1 }}] }} }}]\n"
            ),
            |p| {
                p.vertices.iter().any(|v| v.passage == Passage::Exit && v.light.is_some())
                    && p.vertices.iter().any(|v| v.walk.is_some_and(|w| w.steps > 5))
            },
        ),
        (
            "a fisheye",
            format!(
                "{}camera = {{ type = \"fisheye\", position = [0, 1.5, 5], look_at = [0, 0.7, 0] }}\n{path}object = [{FLOOR}, {LAMP}]\n",
                film("")
            ),
            |p| p.end == End::LeftOut,
        ),
    ]
}

/// Meshes with the normals of their triangles, most of them in one tree: moved, turned and mirrored; Lambert's reflection, thin and not, rough mirrors.
/// One is within coloured glass, one has smooth normals.
fn plain_meshes() -> String {
    let sheet = |at: &str, material: &str| {
        format!(
            "{{ type = \"mesh\", positions = [[-2, 0, -2], [2, 0, -2], [2, 0.5, 2], [-2, 0, 2]], triangles = [[0, 2, 1], [0, 3, 2]], \
             {at} material = {{ {material} }} }}"
        )
    };
    let mirror = "type = \"principled\", base_weight = 0, specular_ior = 0, specular_color = [0.9, 0.7, 0.5], specular_roughness = 0.4";
    [
        sheet("", "type = \"matte\", color = [0.8, 0.6, 0.3]"),
        sheet(
            "transform = [{ scale = [-0.3, 0.5, 0.4] }, { rotate = [70, 20, 0] }, { translate = [-1, 1, 0] }],",
            "type = \"matte\"",
        ),
        sheet("transform = [{ rotate = [0, 0, 80] }, { translate = [2, 1, 0] }],", mirror),
        sheet("transform = [{ scale = 0.1 }, { translate = [0.7, 1, 1] }],", "type = \"matte\""),
        sheet(
            "smooth = true, transform = [{ scale = 0.2 }, { translate = [1.5, 0.5, 1] }],",
            "type = \"principled\", thin_walled = true, specular_weight = 0, base_color = [0.2, 0.6, 0.9]",
        ),
        sheet(
            "transform = [{ scale = 0.2 }, { translate = [-1.5, 0.5, 1] }],",
            "type = \"principled\", thin_walled = true, specular_weight = 0, base_color = [0.2, 0.6, 0.9]",
        ),
        "{ type = \"sphere\", center = [0.7, 1, 1], radius = 0.5, material = { type = \"principled\", transmission_weight = 1, \
         specular_roughness = 0, transmission_color = [0.3, 0.6, 0.9], transmission_depth = 0.5 } }"
            .into(),
    ]
    .join(", ")
}

type Occurs = fn(&PathRecord) -> bool;

fn bits(s: Spectrum) -> [u32; 3] {
    s.to_array().map(f32::to_bits)
}

fn prepared(desc: &SceneDesc) -> Prepared {
    desc.prepare(&PrepareOptions { threads: 1, ..Default::default() }).unwrap()
}

/// Pixels all over the picture, others for each scene.
fn places(salt: u32) -> impl Iterator<Item = (u32, u32)> {
    let mut state = salt.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((state >> 8) % WIDTH, (state >> 20) % HEIGHT)
    })
}

/// The scene with another way to find caustics; light paths bring to the picture what is in no sample.
fn with_caustics(text: &str, caustics: Caustics) -> SceneDesc {
    let mut desc = describe(text);
    if let IntegratorDesc::Path(path) = &mut desc.integrator {
        path.caustics = caustics;
        path.photon_radius = Some(1.0);
    }
    desc
}

#[test]
fn samples_of_the_picture_are_sums_of_their_records() {
    for (i, (name, text, occurs)) in scenes().into_iter().enumerate() {
        let desc = with_caustics(&text, Caustics::Off);
        let scene = prepared(&desc);
        let picture = render_with(&desc, 2, u32::MAX).0;
        let mut occurred = false;
        for (x, y) in places(i as u32).take(150) {
            // The pixel is made of its four samples.
            let mut pixel = PixelSum::default();
            for index in 0..4 {
                let (path, rendered) = sample_and_record(&scene, (x, y, index), name);
                assert!(pixel.add_or_leave_out(rendered.color, rendered.alpha));
                occurred |= occurs(&path);
                check(&path, name);
            }
            let [r, g, b, a] = pixel.mean().unwrap();
            let shown = picture.linear[(y * WIDTH + x) as usize];
            assert_eq!([r, g, b, a].map(f32::to_bits), shown.map(f32::to_bits), "{name}: {x},{y}");
        }
        assert!(occurred, "{name}: nothing of the kind was met");
    }
}

fn sample_and_record(scene: &Prepared, (x, y, index): (u32, u32, u32), name: &str) -> (PathRecord, Radiance) {
    let path = replay(scene, x, y, index).unwrap();
    let rendered = sample(scene, x, y, index).unwrap();
    let at = format!("{name}: {x},{y} sample {index}: {path:?}");
    assert_eq!(bits(path.sum()), bits(rendered.color), "{at}");
    assert_eq!(path.radiance, rendered, "{at}");
    (path, rendered)
}

/// Weighed with light paths, and with what photons bring.
#[test]
fn samples_beside_light_paths_are_sums_of_their_records() {
    let mut gathered = 0;
    for (i, (name, text, _)) in scenes().into_iter().enumerate() {
        for caustics in [Caustics::LightTracing, Caustics::Full] {
            let scene = prepared(&with_caustics(&text, caustics));
            for (x, y) in places(i as u32).take(if i < 2 { 300 } else { 40 }) {
                let (path, _) = sample_and_record(&scene, (x, y, 1), name);
                gathered += path.vertices.iter().filter(|v| v.photons.is_some_and(|p| p.count > 0)).count();
            }
        }
    }
    assert!(gathered > 4, "{gathered}");
}

/// Whether `found` is `expected` but for a few roundings.
fn near(found: Spectrum, expected: Spectrum) -> bool {
    let pairs = found.to_array().into_iter().zip(expected.to_array());
    pairs.into_iter().all(|(f, e)| (f - e).abs() <= 2e-6 * f.abs().max(e.abs()) + 1e-30)
}

/// The power heuristic; a density that is infinitely small beside the other has no weight.
fn heuristic(pdf: f64, other: f64) -> f64 {
    let (a, b) = (pdf / pdf.max(other), other / pdf.max(other));
    a * a / (a * a + b * b)
}

/// The numbers of a record belong together: each is what the others say.
fn check(path: &PathRecord, at: &str) {
    // Only scenes that are called so have a clamp.
    let clamped = at.contains("clamp");
    let by_chance = at.starts_with("lights by chance");
    let mut carried = Spectrum::WHITE;
    for (i, v) in path.vertices.iter().enumerate() {
        let way = v.way.as_ref();
        let reaches = carried * v.transmittance.unwrap_or(Spectrum::WHITE);
        let reaches = way.map_or(reaches, |w| reaches * w.weight);
        if let Some((_, l)) = way.and_then(|w| w.second.as_ref())
            && let Some(visible) = l.visible
        {
            assert!(near(l.contribution, l.unshadowed * visible), "second light {i} {at}");
        }
        let reaches = v.walk.map_or(reaches, |w| reaches * w.weight);
        let beside = way.map_or(0.0, |w| w.beside);
        assert!(near(v.throughput, reaches), "throughput {i} {at}");
        let way = v.p - v.origin;
        // A walk that is too long comes out where it went in.
        assert!(v.walk.is_some() || (way.length() - v.t).abs() < 1e-5 * (1.0 + v.t), "t {i} {at}");
        if let Some(e) = &v.emission {
            let expected = v.throughput * e.radiance * e.weight as f32;
            assert!(clamped || near(e.contribution, expected), "emission {i} {at}");
            match e.pdf {
                Some(pdf) if e.light_pdf > 0.0 && !by_chance => {
                    assert!(
                        (e.weight - heuristic(pdf, e.light_pdf)).abs() < 1e-9,
                        "emission's weight {i} {at}"
                    );
                }
                _ => assert_eq!(e.weight, 1.0, "{at}"),
            }
        }
        // From here on one band stands for all, if it was chosen here.
        let onward = v.dispersed.unwrap_or(v.throughput);
        if let Some(l) = v.light.as_ref().filter(|l| l.visible.is_some()) {
            let through = l.transmittance.unwrap_or(Spectrum::WHITE);
            let counts = f64::from(l.counts);
            let expected = l.bsdf * l.radiance * (counts * l.weight * l.cosine / l.pdf) as f32 * through;
            let is = near(l.unshadowed, onward * expected);
            assert!(clamped || is, "light {i} {at}");
            assert!(near(l.contribution, l.unshadowed * l.visible.unwrap()), "visible light {i} {at}");
            let found = if l.is_delta { 0.0 } else { l.bsdf_pdf / l.pdf };
            let weight = if v.passage == Passage::Medium {
                1.0 / (1.0 + beside * beside + found * found)
            } else if l.is_delta {
                1.0
            } else {
                heuristic(l.pdf, l.bsdf_pdf)
            };
            assert!((l.weight - weight).abs() < 1e-9, "light's weight {i} {at}");
        }
        carried = onward;
        if let Some(s) = &v.scatter {
            let survival = s.roulette.map_or(1.0, |r| if r.number < r.survival { r.survival } else { 1.0 });
            let expected = onward * s.weight * (1.0 / survival) as f32;
            assert!(near(s.throughput, expected), "scattering {i} {at}");
            carried = s.throughput;
            if let Some(next) = path.vertices.get(i + 1).filter(|next| next.walk.is_none()) {
                assert_eq!(next.direction, s.direction, "{at}");
            }
        }
    }
    let lost = path.vertices.last().and_then(|v| v.scatter?.roulette).is_some_and(|r| r.number >= r.survival);
    assert_eq!(path.end == End::Roulette, lost, "{at}");
    if let Some(e) = &path.escape {
        assert_eq!(path.end, End::Escaped);
        let reaches = carried * e.transmittance.unwrap_or(Spectrum::WHITE);
        let reaches = e.way.as_ref().map_or(reaches, |w| reaches * w.weight);
        assert!(near(e.throughput, reaches), "outside {at}");
        let found = e.lights.iter().fold(e.background + e.ambient, |s, l| s + l.radiance * l.weight as f32);
        assert!(clamped || near(e.contribution, e.throughput * found), "found outside {at}");
    }
}

#[test]
fn what_cannot_be_replayed_is_said() {
    let text = format!("{}{CAMERA}", film(""));
    let path = prepared(&describe(&format!("{text}integrator.type = \"path\"\n")));
    let message = |scene: &Prepared, x, y, i| {
        let e = replay(scene, x, y, i).unwrap_err();
        format!("{} {}; {}", e.code.as_str(), e.message, e.help.unwrap())
    };
    assert!(message(&path, WIDTH, 0, 0).contains("no pixel in column 24, row 0: the picture has 24x16"));
    assert!(message(&path, 0, HEIGHT, 0).starts_with("E0105"));
    assert!(message(&path, 0, 0, 4).contains("no sample 4: samples of a pixel are numbered 0 to 3"));
    let adaptive = text.replace("monte-carlo", "adaptive") + "integrator.type = \"path\"\n";
    assert!(message(&prepared(&describe(&adaptive)), 0, 0, 0).contains("have no numbers"));
    for other in ["classic", "normals"] {
        let scene = prepared(&describe(&format!("{text}integrator.type = \"{other}\"\n")));
        let said = message(&scene, 0, 0, 0);
        assert!(said.starts_with("E0107") && said.contains(&format!("\"{other}\"")), "{said}");
        // Its samples can be had alone nevertheless.
        assert!(sample(&scene, 3, 2, 1).unwrap().alpha == 1.0);
    }
}
