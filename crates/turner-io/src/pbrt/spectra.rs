//! Colours of parameters: `rgb`, `blackbody`, and spectra by name, from a file or by wavelength.

use turner::color::{Spectrum, black_body};
use turner::schema::ErrorCode;

use super::assembly::Assembly;
use super::params::{Param, Params, Type, Value};
use super::reader::unknown;
use super::report::Fault;
use super::state::ColorSpace;
use crate::assets::printable;
use crate::spectral::{self, Sampled};

/// Largest spectrum file, bytes.
const MAX_SPD: u64 = 1 << 24;

/// What a colour is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// A fraction of light, 0 to 1.
    Albedo,
    /// A coefficient of any size.
    Unbounded,
    /// Light. Spectra are scaled to luminance 1; other parameters give the strength.
    Light,
}

/// A spectrum as the file describes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Curve {
    Rgb(Spectrum),
    Blackbody(f64),
    /// One of pbrt's named spectra.
    Named(String),
    Sampled(Sampled),
}

/// The colour of a parameter, if it is given.
pub(super) fn color(
    scene: &mut Assembly<'_>,
    space: ColorSpace,
    params: &Params,
    name: &'static str,
    role: Role,
) -> Result<Option<Spectrum>, Fault> {
    let Some(param) = params.spectrum(name) else { return Ok(None) };
    let curve = curve(scene, space, param, role)?;
    to_color(&curve, role).map(Some).map_err(|f| f.or_at(param.place))
}

/// The spectrum of a parameter.
pub(super) fn curve(
    scene: &mut Assembly<'_>,
    space: ColorSpace,
    param: &Param,
    role: Role,
) -> Result<Curve, Fault> {
    match (&param.value, param.kind) {
        (Value::Numbers(v), Type::Rgb) => {
            let (&r, &g, &b) = match &v[..] {
                [r, g, b, ..] => (r, g, b),
                _ => return Err(Fault::at(param.place, ErrorCode::WrongType, "rgb has three numbers")),
            };
            let mut c = match role {
                Role::Light => space.light_to_rec709([r, g, b]),
                Role::Albedo | Role::Unbounded => space.to_rec709([r, g, b]),
            };
            let most = if role == Role::Albedo { 1.0 } else { f64::from(f32::MAX) };
            if [r, g, b].iter().any(|v| *v < 0.0 || *v > most) {
                let message = format!("rgb {} has a value out of range: clamped", printable(&param.name));
                scene.report.doubtful(param.place, message);
            }
            c.iter_mut().for_each(|v| *v = v.clamp(0.0, most));
            Ok(Curve::Rgb(Spectrum::new(c[0] as f32, c[1] as f32, c[2] as f32)))
        }
        // In pbrt-v3, a temperature and a scale; the emission spectrum is normalized to a maximum of 1.
        (Value::Numbers(v), Type::Blackbody) if scene.frame.is_version3 => {
            let (kelvin, scale) = (v.first().copied().unwrap_or(6500.0), v.get(1).copied().unwrap_or(1.0));
            Ok(Curve::Rgb(black_body(kelvin) * scale.clamp(0.0, 1e30) as f32))
        }
        (Value::Numbers(v), Type::Blackbody) => Ok(Curve::Blackbody(v.first().copied().unwrap_or(6500.0))),
        (Value::Numbers(v), _) => Sampled::of_pairs(v).map(Curve::Sampled).ok_or_else(|| {
            let message = format!(
                "spectrum {}: expected pairs of ascending wavelengths and values",
                printable(&param.name)
            );
            Fault::at(param.place, ErrorCode::WrongType, message)
        }),
        (Value::Strings(v), _) => {
            let name = v.first().map_or("", String::as_str);
            if let Some(index) = metal_of(name) {
                return Ok(Curve::Sampled(index));
            }
            if is_known(name) {
                return Ok(Curve::Named(name.to_owned()));
            }
            if !name.contains('.') {
                let known = known_names();
                return Err(unknown("spectrum", name, &known).or_at(param.place));
            }
            let (_, bytes) = scene.read(name, MAX_SPD, param.place)?;
            let text = String::from_utf8_lossy(&bytes);
            Sampled::of_text(&text).map(Curve::Sampled).ok_or_else(|| {
                let message =
                    format!("{}: expected lines of a wavelength and a value, ascending", printable(name));
                Fault::at(param.place, ErrorCode::File, message)
            })
        }
        _ => Err(Fault::at(param.place, ErrorCode::WrongType, "expected a colour or a spectrum")),
    }
}

/// The colour of a spectrum.
pub(super) fn to_color(curve: &Curve, role: Role) -> Result<Spectrum, Fault> {
    Ok(match (curve, role) {
        (Curve::Rgb(c), _) => *c,
        (Curve::Blackbody(kelvin), _) => spectral::blackbody(*kelvin),
        (Curve::Sampled(s), Role::Light) => s.light(),
        // pbrt's spectra are 0 beyond their ends.
        (Curve::Sampled(s), Role::Albedo) => {
            s.dark_beyond_its_ends().reflectance().map(|v| v.clamp(0.0, 1.0))
        }
        (Curve::Sampled(s), Role::Unbounded) => s.dark_beyond_its_ends().reflectance().map(|v| v.max(0.0)),
        (Curve::Named(name), _) => match (spectral::illuminant(name), glass_of(name)) {
            (Some(light), _) => light,
            (_, Some(glass)) => Spectrum::grey(glass.ior as f32),
            _ => return Err(Fault::new(ErrorCode::UnknownName, "unknown spectrum")),
        },
    })
}

/// The glass of a named index of refraction.
pub(super) fn glass_of(name: &str) -> Option<spectral::Glass> {
    spectral::glass(name.strip_prefix("glass-")?)
}

/// A metal's η or k by name.
pub(super) fn metal_of(name: &str) -> Option<Sampled> {
    let (symbol, part) = name.strip_prefix("metal-")?.rsplit_once('-')?;
    let [eta, k] = spectral::metal(symbol)?;
    match part {
        "eta" => Some(eta),
        "k" => Some(k),
        _ => None,
    }
}

fn is_known(name: &str) -> bool {
    spectral::illuminant(name).is_some() || glass_of(name).is_some()
}

fn known_names() -> Vec<&'static str> {
    vec![
        "metal-Ag-eta",
        "metal-Ag-k",
        "metal-Al-eta",
        "metal-Al-k",
        "metal-Au-eta",
        "metal-Au-k",
        "metal-Cu-eta",
        "metal-Cu-k",
        "metal-CuZn-eta",
        "metal-CuZn-k",
        "metal-MgO-eta",
        "metal-MgO-k",
        "metal-TiO2-eta",
        "metal-TiO2-k",
        "glass-BK7",
        "glass-BAF10",
        "glass-FK51A",
        "glass-LASF9",
        "glass-F5",
        "glass-F10",
        "glass-F11",
        "stdillum-A",
        "stdillum-D50",
        "stdillum-D65",
        "stdillum-F1",
        "stdillum-F2",
        "stdillum-F11",
        "illum-acesD60",
    ]
}
