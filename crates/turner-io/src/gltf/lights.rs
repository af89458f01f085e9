//! Punctual lights (`KHR_lights_punctual`).
//!
//! Intensities keep their numbers: candela for point and spot lights, lux for directional ones. Turner's radiometric
//! values have no unit, so neither is divided by the luminous efficacy of 683 lm/W.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use turner::color::Spectrum;
use turner::description::SceneLight;
use turner::light::{Attenuation, DirectionalDesc, LightDesc, PointDesc, SpotDesc};
use turner::math::{DAffine3, DVec3};

use super::fault::{Fault, Outcome};
use super::json::{Document, Index, LightJson};
use super::report::Report;

/// Intensity falls off with 1/d².
const INVERSE_SQUARE: Attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };

/// The light with this index on a node with this transform; `None` if it is degenerate or of an unknown type.
pub(super) fn light(
    document: &Document,
    index: Index,
    world: &DAffine3,
    node_name: Option<&str>,
    report: &mut Report,
    pointer: &str,
) -> Outcome<Option<SceneLight>> {
    let lights = document.extensions.lights.as_ref().map_or(&[][..], |l| &l.lights);
    let Some(json) = lights.get(index.index()) else {
        return Err(Fault::dangling(pointer, "light", index.0, lights.len()));
    };
    let position = world.translation;
    // A glTF light points along −z.
    let direction = (world.matrix3 * DVec3::NEG_Z).try_normalize();
    let (Some(direction), true) = (direction, position.is_finite()) else {
        report.doubtful("a light whose node has no direction");
        return Ok(None);
    };
    let color = json.color.unwrap_or([1.0; 3]).map(|v| v.clamp(0.0, f64::from(f32::MAX)) as f32);
    let color = Spectrum::new(color[0], color[1], color[2]);
    let intensity = json.intensity.unwrap_or(1.0).clamp(0.0, f64::from(f32::MAX));
    if json.range.is_some() {
        report.ignored("the range of lights: they fall off with the square of the distance, without a limit");
    }
    let value = match json.kind.as_str() {
        "point" => LightDesc::Point(PointDesc {
            attenuation: INVERSE_SQUARE,
            position,
            color,
            intensity,
            ..PointDesc::default()
        }),
        "spot" => LightDesc::Spot(spot(json, position, direction, color, intensity, report)),
        "directional" => LightDesc::Directional(DirectionalDesc {
            direction: Some(direction),
            color,
            intensity,
            ..DirectionalDesc::default()
        }),
        _ => {
            report.ignored("a light of an unknown type");
            return Ok(None);
        }
    };
    let name = json.name.as_deref().or(node_name).map(str::to_owned);
    Ok(Some(SceneLight { name, ..value.into() }))
}

fn spot(
    json: &LightJson,
    position: DVec3,
    direction: DVec3,
    color: Spectrum,
    intensity: f64,
    report: &mut Report,
) -> SpotDesc {
    let cone = json.spot.as_ref();
    let inner = cone.and_then(|c| c.inner_cone_angle).unwrap_or(0.0);
    let outer = cone.and_then(|c| c.outer_cone_angle).unwrap_or(FRAC_PI_4);
    if !(0.0 <= inner && inner < outer && outer <= FRAC_PI_2) {
        report.doubtful("a spot light with an outer cone angle above 90 degrees or below the inner one");
    }
    let outer = outer.clamp(1e-6, FRAC_PI_2);
    let inner = inner.clamp(0.0, outer);
    SpotDesc {
        position,
        // Far enough away that rounding does not change the direction.
        look_at: position + direction * (1.0 + position.abs().max_element()),
        angle: outer.to_degrees(),
        penumbra: (outer - inner).to_degrees(),
        color,
        intensity,
        attenuation: INVERSE_SQUARE,
        ..SpotDesc::default()
    }
}
