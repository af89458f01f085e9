//! Lights, and the emission of shapes.
//!
//! Strengths follow pbrt: a light's spectrum is scaled to luminance 1 (an `rgb` keeps its values) and
//! multiplied by `scale`. `power` and `illuminance` replace the light's own strength. The exposure of the film
//! comes last.

use std::f64::consts::{PI, TAU};

use turner::color::Spectrum;
use turner::light::{
    Attenuation, DirectionalDesc, EnvironmentDesc, LightDesc, PointDesc, SphereLightDesc, SpotDesc,
};
use turner::math::elementary::{cbrt, cos};
use turner::math::{DAffine3, DMat3, DVec3, radians};
use turner::shape::ShapeDesc;

use super::assembly::Assembly;
use super::environment;
use super::params::Params;
use super::report::Fault;
use super::shapes::Made;
use super::source::Place;
use super::spectra::{Role, color};
use super::state::State;
use crate::assets::printable;
use crate::scene_import::environment_light;

/// Falls off with 1/d².
const INVERSE_SQUARE: Attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };

/// Widest cone of a spot light, degrees.
const MAX_CONE: f64 = 180.0;

/// Adds a light.
pub(super) fn add(scene: &mut Assembly<'_>, state: &State, name: &str, params: Params) -> Result<(), Fault> {
    let place = params.place;
    if state.ctm[0] != state.ctm[1] {
        scene.report.approximated(place, "light motion: the start position is used");
    }
    let scale = params.float("scale").unwrap_or(1.0) * scene.frame.exposure();
    let mut light = Light { scene, state, params: &params, to_world: state.ctm[0], scale };
    let desc = match name {
        "point" => light.point()?,
        "goniometric" => {
            params.pass(&["filename"]);
            let desc = light.point()?;
            light
                .scene
                .report
                .approximated(place, "a goniometric light: rendered as a point light without its image");
            desc
        }
        "spot" => light.spot()?,
        "projection" => light.projection()?,
        "distant" => light.distant()?,
        "infinite" => light.infinite()?,
        other => {
            let fault = super::reader::unknown(
                "light",
                other,
                &["point", "spot", "distant", "infinite", "goniometric", "projection"],
            );
            return Err(fault.or_at(place));
        }
    };
    if let Some(desc) = desc {
        params.finish(&format!("the light \"{}\"", printable(name)), &mut scene.report);
        scene.lights.push(desc.into());
    }
    Ok(())
}

/// A light under construction. `None` is a light that is omitted, with a report.
struct Light<'a, 'b> {
    scene: &'a mut Assembly<'b>,
    state: &'a State,
    params: &'a Params,
    to_world: DAffine3,
    /// Factor on its colour.
    scale: f64,
}

impl Light<'_, '_> {
    fn color(&mut self, name: &'static str) -> Result<Spectrum, Fault> {
        let found = color(self.scene, self.state.color_space, self.params, name, Role::Light)?;
        Ok(self.scene.frame.balanced(found.unwrap_or(Spectrum::WHITE)))
    }

    /// A parameter that is greater than 0.
    fn positive(&self, name: &'static str) -> Option<f64> {
        self.params.float(name).filter(|v| *v > 0.0)
    }

    fn point(&mut self) -> Result<Option<LightDesc>, Fault> {
        let color = self.color("I")?;
        if let Some(power) = self.positive("power") {
            self.scale *= power / (4.0 * PI);
        }
        let from = self.params.vector("from").unwrap_or(DVec3::ZERO);
        Ok(Some(LightDesc::Point(PointDesc {
            position: self.to_world.transform_point3(from),
            color,
            intensity: sound(self.scale),
            attenuation: INVERSE_SQUARE,
            ..PointDesc::default()
        })))
    }

    fn spot(&mut self) -> Result<Option<LightDesc>, Fault> {
        let cone = self.params.float("coneangle").unwrap_or(30.0);
        let delta = self.params.float("conedeltaangle").unwrap_or(5.0);
        let from = self.params.vector("from").unwrap_or(DVec3::ZERO);
        let to = self.params.vector("to").unwrap_or(DVec3::Z);
        self.cone([cone, delta], from, to)
    }

    fn projection(&mut self) -> Result<Option<LightDesc>, Fault> {
        self.params.pass(&["filename"]);
        let message = "a projection light: rendered as a spot light without its image";
        self.scene.report.approximated(self.params.place, message);
        let cone = self.params.float("fov").unwrap_or(90.0) / 2.0;
        self.cone([cone, 0.0], DVec3::ZERO, DVec3::Z)
    }

    /// A spot light with the half angle of its cone and the width of its edge, degrees.
    fn cone(&mut self, [cone, delta]: [f64; 2], from: DVec3, to: DVec3) -> Result<Option<LightDesc>, Fault> {
        let color = self.color("I")?;
        let cone = cone.clamp(1e-3, MAX_CONE);
        let delta = delta.clamp(0.0, cone);
        if let Some(power) = self.positive("power") {
            let (end, start) = (cos(radians(cone)), cos(radians(cone - delta)));
            self.scale *= power / (TAU * ((1.0 - start) + (start - end) / 2.0));
        }
        let (position, look_at) = (self.to_world.transform_point3(from), self.to_world.transform_point3(to));
        if position == look_at {
            self.scene.report.doubtful(self.params.place, "a spot light without a direction: omitted");
            return Ok(None);
        }
        Ok(Some(LightDesc::Spot(SpotDesc {
            position,
            look_at,
            angle: cone,
            penumbra: delta,
            color,
            intensity: sound(self.scale),
            attenuation: INVERSE_SQUARE,
            ..SpotDesc::default()
        })))
    }

    fn distant(&mut self) -> Result<Option<LightDesc>, Fault> {
        let color = self.color("L")?;
        if let Some(illuminance) = self.positive("illuminance") {
            self.scale *= illuminance;
        }
        let from = self.params.vector("from").unwrap_or(DVec3::ZERO);
        let to = self.params.vector("to").unwrap_or(DVec3::Z);
        let Some(direction) = self.to_world.transform_vector3(to - from).try_normalize() else {
            self.scene.report.doubtful(self.params.place, "a distant light without a direction: omitted");
            return Ok(None);
        };
        Ok(Some(LightDesc::Directional(DirectionalDesc {
            direction: Some(direction),
            color,
            intensity: sound(self.scale),
            ..DirectionalDesc::default()
        })))
    }

    fn infinite(&mut self) -> Result<Option<LightDesc>, Fault> {
        let (params, illuminance) = (self.params, self.positive("illuminance"));
        if params.has("portal") {
            let message = "the portal of an infinite light: not used";
            self.scene.report.approximated(params.place_of("portal"), message);
            params.pass(&["portal"]);
        }
        let file = params.string("filename").map(str::to_owned);
        if file.is_some() && params.has("L") {
            let message = "an infinite light with an image and a colour L: the image is used";
            self.scene.report.doubtful(params.place_of("L"), message);
            params.pass(&["L"]);
        }
        let tint = match &file {
            Some(_) => self.scene.frame.balanced(Spectrum::WHITE),
            None => self.color("L")?,
        };
        let made = match file {
            None => Some((environment_light::white(self.scene), PI)),
            Some(name) => {
                let place = params.place_of("filename");
                environment::equirectangular(self.scene, &name, self.to_world.matrix3, place)
            }
        };
        let Some((image, mean_irradiance)) = made else { return Ok(None) };
        if let Some(illuminance) = illuminance {
            self.scale *= illuminance / mean_irradiance.max(1e-30);
        }
        let strength = sound(self.scale);
        Ok(Some(LightDesc::Environment(EnvironmentDesc { file: Some(image), strength, rotation: 0.0, tint })))
    }
}

/// A strength within the limits of a scene.
pub(super) fn sound(v: f64) -> f64 {
    if v.is_finite() { v.clamp(0.0, 1e30) } else { 0.0 }
}

/// The emission of a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Emission {
    pub(super) color: Spectrum,
    /// Radiance, as a factor on the colour.
    pub(super) radiance: f64,
    pub(super) two_sided: bool,
}

/// An emissive shape with alpha 0: invisible to rays, but its light is sampled. A full sphere becomes a sphere
/// light; other shapes are reported.
pub(super) fn unseen(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    made: &Made,
    place: Place,
) -> Result<(), Fault> {
    let Made::Shape(ShapeDesc::Sphere(sphere), _) = made else {
        scene
            .report
            .ignored(place, "an invisible area light (alpha 0) that is not a full sphere: it emits no light");
        return Ok(());
    };
    let to_world = &state.ctm[0];
    let size = cbrt(to_world.matrix3.determinant().abs());
    let radius = sphere.radius * size;
    let Some(emission) = area(scene, state, params, |_| 4.0 * PI * radius * radius)? else { return Ok(()) };
    if !(radius > 0.0 && radius.is_finite()) {
        scene.report.doubtful(place, "an area light of zero size: omitted");
        return Ok(());
    }
    scene.report.approximated(place, "an invisible area light (alpha 0): replaced by a sphere light");
    // A sphere of radiance L and radius r has the intensity L · π r².
    let light = SphereLightDesc {
        center: to_world.transform_point3(DVec3::ZERO),
        radius,
        samples: 1,
        jitter: true,
        color: emission.color,
        intensity: sound(emission.radiance * PI * radius * radius),
        attenuation: INVERSE_SQUARE,
    };
    scene.lights.push(LightDesc::Sphere(light).into());
    Ok(())
}

/// The emission of a shape. `part_area` is the mean area of its parts.
pub(super) fn area(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    part_area: impl FnOnce(&DMat3) -> f64,
) -> Result<Option<Emission>, Fault> {
    let mut radiance = params.float("scale").unwrap_or(1.0) * scene.frame.exposure();
    let color = color(scene, state.color_space, params, "L", Role::Light)?.unwrap_or(Spectrum::WHITE);
    let color = scene.frame.balanced(color);
    let two_sided = params.bool("twosided").unwrap_or(false);
    if let Some(power) = params.float("power").filter(|p| *p > 0.0) {
        let sides = if two_sided { 2.0 } else { 1.0 };
        radiance *= power / (sides * PI * part_area(&state.ctm[0].matrix3).max(1e-30));
    }
    if params.has("filename") {
        params.pass(&["filename"]);
        let message = "the image of an area light: not used, the light emits uniformly";
        scene.report.approximated(params.place_of("filename"), message);
    }
    params.pass(&["nsamples", "samples"]);
    params.finish("the area light", &mut scene.report);
    let radiance = radiance.clamp(0.0, 1e15);
    Ok((radiance > 0.0 && radiance.is_finite()).then_some(Emission { color, radiance, two_sided }))
}
