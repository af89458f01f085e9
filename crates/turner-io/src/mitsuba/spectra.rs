//! Colours: `rgb`, numbers, spectra by wavelength, black bodies; converted as in Mitsuba's RGB mode.

use turner::color::{Spectrum, srgb_decode};
use turner::schema::ErrorCode;

use super::assembly::Assembly;
use super::params::{Object, number, numbers};
use crate::assets::printable;
use crate::scene_import::report::Fault;
use crate::scene_import::{Place, unknown};
use crate::spectral::{self, Sampled};

/// Largest spectrum file, bytes.
const MAX_SPD: u64 = 1 << 24;
/// Most numbers of a spectrum in the scene file.
const MAX_POINTS: usize = 1 << 16;

/// The colour of light with equal power at all wavelengths, per unit of power. It is not white.
const EQUAL_ENERGY: Spectrum = Spectrum::new(1.204_8, 0.948_29, 0.908_91);

/// What a colour is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    /// A fraction of light, 0 to 1.
    Albedo,
    /// A coefficient of any size.
    Unbounded,
    /// Light.
    Light,
}

/// The elements that are colours.
pub(super) const COLORS: &[&str] = &["float", "integer", "rgb", "srgb", "color", "spectrum", "blackbody"];

/// A spectrum or a colour.
enum Curve {
    Rgb(Spectrum),
    Sampled(Sampled),
}

/// The colour of the element `node`, which is one of [`COLORS`].
pub(super) fn color(scene: &mut Assembly<'_>, node: usize, role: Role) -> Result<Spectrum, Fault> {
    let object = Object::new(&scene.document, node)?;
    let c = match curve(scene, &object, role)? {
        Curve::Rgb(c) => c,
        Curve::Sampled(s) if role == Role::Light => s.light() * s.power() as f32,
        Curve::Sampled(s) => s.reflectance(),
    };
    let most = if role == Role::Albedo { 1.0 } else { 1e15 };
    if c.to_array().iter().any(|v| *v < 0.0 || *v > most * 1.0001) {
        scene.report.doubtful(object.place, "a colour has a value out of range: clamped");
    }
    Ok(c.map(|v| v.clamp(0.0, most)))
}

/// The sampled spectrum of an element, if it has one.
pub(super) fn sampled(scene: &mut Assembly<'_>, node: usize) -> Result<Option<Sampled>, Fault> {
    let object = Object::new(&scene.document, node)?;
    Ok(match curve(scene, &object, Role::Unbounded)? {
        Curve::Rgb(_) => None,
        Curve::Sampled(s) => Some(s),
    })
}

fn bad(object: &Object, what: &str) -> Fault {
    Fault::at(object.place, ErrorCode::WrongType, what.to_owned())
}

fn curve(scene: &mut Assembly<'_>, object: &Object, role: Role) -> Result<Curve, Fault> {
    let document = object.document.clone();
    let Some(node) = document.node(object.node) else { return Ok(Curve::Rgb(Spectrum::BLACK)) };
    let value = node.attribute("value");
    let even = |v: f64| match role {
        Role::Light => EQUAL_ENERGY * v as f32,
        _ => Spectrum::grey(v as f32),
    };
    match (node.tag.as_str(), value) {
        ("float" | "integer", Some(text)) => {
            let v = number(text).ok_or_else(|| bad(object, "expected a number"))?;
            Ok(Curve::Rgb(Spectrum::grey(v as f32)))
        }
        ("rgb" | "srgb" | "color", Some(text)) => rgb(text, node.tag == "srgb")
            .map(Curve::Rgb)
            .ok_or_else(|| bad(object, "expected three numbers or #rrggbb")),
        ("spectrum", _) if !object.kind.is_empty() => plugin(scene, object, role),
        ("spectrum", None) if node.attribute("filename").is_some() => {
            let name = node.attribute("filename").unwrap_or_default();
            of_file(scene, name, object.place).map(Curve::Sampled)
        }
        ("spectrum", Some(text)) => {
            if let Some(v) = number(text) {
                return Ok(Curve::Rgb(even(v)));
            }
            if text.contains(':') {
                let text = text.replace(':', " ");
                let list = numbers(&text, MAX_POINTS).and_then(|v| Sampled::of_pairs(&v));
                return list
                    .map(Curve::Sampled)
                    .ok_or_else(|| bad(object, "expected wavelength:value pairs, ascending"));
            }
            rgb(text, false)
                .map(Curve::Rgb)
                .ok_or_else(|| bad(object, "expected a number or wavelength:value pairs"))
        }
        ("blackbody", _) => {
            let kelvin = node.attribute("temperature").unwrap_or_default().trim_end_matches(['K', 'k', ' ']);
            let kelvin = number(kelvin).ok_or_else(|| bad(object, "expected a temperature"))?;
            let scale = node.attribute("scale").and_then(number).unwrap_or(1.0);
            Ok(Curve::Rgb(black_body(kelvin, scale)))
        }
        (tag, _) => Err(bad(object, &format!("<{}> is not a colour, or has no value", printable(tag)))),
    }
}

/// The light of a black body in W/(m²·sr·nm), as a colour.
fn black_body(kelvin: f64, scale: f64) -> Spectrum {
    let power = (spectral::blackbody_power(kelvin) * scale).clamp(0.0, 1e15);
    spectral::blackbody(kelvin) * power as f32
}

fn plugin(scene: &mut Assembly<'_>, object: &Object, role: Role) -> Result<Curve, Fault> {
    let curve = match object.kind.as_str() {
        "uniform" => {
            object.pass(&["lambda_min", "lambda_max"]);
            let v = object.float("value")?.unwrap_or(1.0);
            Curve::Rgb(if role == Role::Light { EQUAL_ENERGY * v as f32 } else { Spectrum::grey(v as f32) })
        }
        "rawconstant" | "srgb" => {
            let Some((_, node)) = object.find(if object.kind == "srgb" { "color" } else { "value" }) else {
                return Ok(Curve::Rgb(Spectrum::grey(0.5)));
            };
            let text = node.attribute("value").unwrap_or_default();
            Curve::Rgb(rgb(text, false).ok_or_else(|| bad(object, "expected one or three numbers"))?)
        }
        "d65" => {
            let scale = object.float("scale")?.unwrap_or(1.0) as f32;
            let color = match object.find("color") {
                Some((child, _)) => color(scene, child, Role::Unbounded)?,
                None => Spectrum::WHITE,
            };
            Curve::Rgb(color * scale)
        }
        "blackbody" => {
            let kelvin = object.float("temperature")?;
            let kelvin = kelvin.ok_or_else(|| bad(object, "a blackbody needs a temperature"))?;
            object.pass(&["wavelength_min", "wavelength_max"]);
            Curve::Rgb(black_body(kelvin, object.float("scale")?.unwrap_or(1.0)))
        }
        "regular" | "irregular" => {
            if let Some(name) = object.string("filename")? {
                let name = name.to_owned();
                Curve::Sampled(of_file(scene, &name, object.place)?)
            } else {
                let list = |name: &'static str| -> Result<Vec<f64>, Fault> {
                    let text = object.string(name)?.unwrap_or_default();
                    numbers(text, MAX_POINTS).ok_or_else(|| bad(object, &format!("{name}: expected numbers")))
                };
                let values = list("values")?;
                let wavelengths = if object.kind == "irregular" {
                    list("wavelengths")?
                } else {
                    let from = object.float("wavelength_min")?.unwrap_or(360.0);
                    let to = object.float("wavelength_max")?.unwrap_or(830.0);
                    let steps = values.len().saturating_sub(1).max(1) as f64;
                    (0..values.len()).map(|i| from + (to - from) * i as f64 / steps).collect()
                };
                let pairs: Vec<f64> = wavelengths.iter().zip(&values).flat_map(|(w, v)| [*w, *v]).collect();
                let found = Sampled::of_pairs(&pairs).filter(|_| wavelengths.len() == values.len());
                Curve::Sampled(
                    found.ok_or_else(|| bad(object, "expected as many ascending wavelengths as values"))?,
                )
            }
        }
        other => {
            let all = ["uniform", "d65", "blackbody", "regular", "irregular", "srgb", "rawconstant"];
            return Err(unknown("spectrum", other, &all).or_at(object.place));
        }
    };
    object.finish(&mut scene.report);
    Ok(curve)
}

fn of_file(scene: &mut Assembly<'_>, name: &str, place: Place) -> Result<Sampled, Fault> {
    let (_, bytes) = scene.read(name, MAX_SPD, place)?;
    Sampled::of_text(&String::from_utf8_lossy(&bytes)).ok_or_else(|| {
        let message = format!("{}: expected lines of a wavelength and a value, ascending", printable(name));
        Fault::at(place, ErrorCode::File, message)
    })
}

/// One or three linear numbers, or `#rrggbb`.
fn rgb(text: &str, is_display: bool) -> Option<Spectrum> {
    if let Some(hex) = text.trim().strip_prefix('#') {
        let v = u32::from_str_radix(hex, 16).ok().filter(|_| hex.len() == 6)?;
        let part = |shift: u32| srgb_decode(((v >> shift) & 0xff) as f32 / 255.0);
        return Some(Spectrum::new(part(16), part(8), part(0)));
    }
    let c = match numbers(text, 3)?[..] {
        [v] => Spectrum::grey(v as f32),
        [r, g, b] => Spectrum::new(r as f32, g as f32, b as f32),
        _ => return None,
    };
    Some(if is_display { c.map(|v| srgb_decode(v.clamp(0.0, 1.0))) } else { c })
}

/// Indices of refraction by name, at 20 °C.
const INDICES: &[(&str, f64)] = &[
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// An index of refraction: a number or a name.
pub(super) fn index(object: &Object, name: &'static str, or: f64) -> Result<f64, Fault> {
    let Some((_, node)) = object.find(name) else { return Ok(or) };
    if node.tag != "string" {
        return Ok(object.float(name)?.unwrap_or(or).clamp(1e-3, 100.0));
    }
    let word = node.attribute("value").unwrap_or_default().trim().to_lowercase();
    match INDICES.iter().find(|(n, _)| *n == word) {
        Some((_, v)) => Ok(*v),
        None => {
            let all: Vec<&str> = INDICES.iter().map(|(n, _)| *n).collect();
            Err(unknown("substance", &word, &all).or_at(node.place))
        }
    }
}
