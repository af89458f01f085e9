//! Lights, and the emission of shapes.
//!
//! Strengths follow pbrt: a light's spectrum is scaled to luminance 1 (an `rgb` keeps its values) and
//! multiplied by `scale`. `power` and `illuminance` replace the light's own strength. The exposure of the film
//! comes last.

use std::f64::consts::{PI, TAU};

use turner::color::Spectrum;
use turner::light::{
    Attenuation, DirectionalDesc, EnvironmentDesc, LightDesc, PointDesc, ProfileUnits, SphereLightDesc,
    SpotDesc,
};
use turner::math::elementary::{cbrt, cos};
use turner::math::{DAffine3, DVec3, radians};
use turner::schema::ColorSource;
use turner::shape::ShapeDesc;
use turner::texture::{Encoding, ImageDesc, TextureDesc, Wrap};

use super::assembly::{Assembly, Texture};
use super::environment;
use super::goniometric;
use super::params::Params;
use super::projection;
use super::report::Fault;
use super::shapes::Made;
use super::source::Place;
use super::spectra::{Role, color};
use super::state::State;
use super::version3;
use crate::assets::printable;
use crate::scene_import::environment_light;

/// Falls off with 1/d².
const INVERSE_SQUARE: Attenuation = Attenuation { coefficients: [0.0, 0.0, 1.0] };

/// Widest cone of a spot light, degrees.
const MAX_CONE: f64 = 180.0;

/// Widest field of view of a projection light, degrees.
const MAX_FOV: f64 = 170.0;

/// Adds a light.
pub(super) fn add(scene: &mut Assembly<'_>, state: &State, name: &str, params: Params) -> Result<(), Fault> {
    let place = params.place;
    if state.ctm[0] != state.ctm[1] {
        scene.report.approximated(place, "light motion: the start position is used");
    }
    let (own, tint) = version3::light_scale(scene, state, &params)?;
    let scale = own * scene.frame.exposure();
    let mut light = Light { scene, state, params: &params, to_world: state.ctm[0], scale, tint };
    let desc = match name {
        "point" => light.point()?,
        "goniometric" => light.goniometric()?,
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
    /// The same by colour band.
    tint: Spectrum,
}

impl Light<'_, '_> {
    fn color(&mut self, name: &'static str) -> Result<Spectrum, Fault> {
        let found = color(self.scene, self.state.color_space, self.params, name, Role::Light)?;
        Ok(self.scene.frame.balanced(found.unwrap_or(self.state.color_space.white())) * self.tint)
    }

    /// The image of the light.
    fn file(&self) -> Option<String> {
        self.params.string("filename").or_else(|| self.params.string("mapname")).map(str::to_owned)
    }

    /// Where the file gives it.
    fn place_of_file(&self) -> Place {
        self.params.place_of(if self.params.has("mapname") { "mapname" } else { "filename" })
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

    /// A point light with the intensities of an image. `power` is that of all directions together.
    fn goniometric(&mut self) -> Result<Option<LightDesc>, Fault> {
        let (file, place) = (self.file(), self.place_of_file());
        let found = file.and_then(|name| goniometric::intensities(self.scene, &name, &self.to_world, place));
        let Some(LightDesc::Point(point)) = self.point()? else { return Ok(None) };
        let Some(found) = found else { return Ok(Some(LightDesc::Point(point))) };
        let by = if self.positive("power").is_some() { 1.0 / found.mean.max(1e-30) } else { 1.0 };
        Ok(Some(LightDesc::Point(PointDesc {
            intensity: sound(point.intensity * by),
            ies: Some(found.profile),
            ies_units: ProfileUnits::Candela,
            ies_axis: goniometric::AXIS,
            ..point
        })))
    }

    fn spot(&mut self) -> Result<Option<LightDesc>, Fault> {
        let cone = self.params.float("coneangle").unwrap_or(30.0);
        let delta = self.params.float("conedeltaangle").unwrap_or(5.0);
        let from = self.params.vector("from").unwrap_or(DVec3::ZERO);
        let to = self.params.vector("to").unwrap_or(DVec3::Z);
        self.cone([cone, delta], from, to)
    }

    /// A spot light around its image. The shorter side of the image has the angle `fov`; `power` is that of all its light.
    fn projection(&mut self) -> Result<Option<LightDesc>, Fault> {
        let place = self.place_of_file();
        let default = if self.scene.frame.is_version3 { 45.0 } else { 90.0 };
        let fov = self.params.float("fov").unwrap_or(default).clamp(1e-3, MAX_FOV);
        let Some(name) = self.file() else {
            self.scene
                .report
                .ignored(self.params.place, "a projection light without an image: it emits no light");
            return Ok(None);
        };
        let m = self.to_world.matrix3;
        let Some(axis) = m.z_axis.try_normalize() else {
            self.scene.report.doubtful(self.params.place, "a projection light without a direction: omitted");
            return Ok(None);
        };
        // The picture's right is +x. Seen along the axis, that is the left unless the transform mirrors.
        let image = match m.determinant() > 0.0 {
            true => projection::mirrored(self.scene, &name, place),
            false => self.scene.image(&name, place),
        };
        let Some(image) = image else { return Ok(None) };
        let Some(slide) = projection::Slide::new(self.scene, image, fov) else { return Ok(None) };
        if let Some(power) = self.positive("power") {
            self.scale *= power / slide.power().max(1e-30);
        }
        let position = self.to_world.translation;
        Ok(Some(LightDesc::Spot(SpotDesc {
            position,
            look_at: position + axis * (1.0 + position.abs().max_element()),
            angle: slide.angle(),
            penumbra: 0.0,
            color: match self.scene.frame.is_version3 {
                true => self.color("I")?,
                false => self.scene.frame.balanced(Spectrum::WHITE) * self.tint,
            },
            intensity: sound(self.scale),
            attenuation: INVERSE_SQUARE,
            image: Some(image),
            image_fov: Some(slide.fov()),
            image_up: m.y_axis,
            ..SpotDesc::default()
        })))
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
        let (file, is_version3) = (self.file(), self.scene.frame.is_version3);
        if file.is_some() && params.has("L") && !is_version3 {
            let message = "an infinite light with an image and a colour L: the image is used";
            self.scene.report.doubtful(params.place_of("L"), message);
            params.pass(&["L"]);
        }
        let tint = match &file {
            Some(_) if !is_version3 => self.scene.frame.balanced(Spectrum::WHITE) * self.tint,
            // In pbrt-v3 it multiplies the image.
            _ => self.color("L")?,
        };
        params.pass(&["nsamples", "samples"]);
        let place = self.place_of_file();
        let image = match &file {
            None => Some(environment_light::white(self.scene)),
            Some(name) => environment::equirectangular(self.scene, name, self.to_world.matrix3, place),
        };
        let Some(image) = image else { return Ok(None) };
        if let Some(illuminance) = illuminance {
            let own = file.and_then(|name| environment::illuminance(self.scene, &name, place));
            self.scale *= illuminance / own.unwrap_or(PI).max(1e-30);
        }
        let strength = sound(self.scale);
        Ok(Some(LightDesc::Environment(EnvironmentDesc {
            file: Some(image),
            strength,
            tint,
            ..EnvironmentDesc::default()
        })))
    }
}

/// A strength within the limits of a scene.
pub(super) fn sound(v: f64) -> f64 {
    if v.is_finite() { v.clamp(0.0, 1e30) } else { 0.0 }
}

/// The emission of a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Emission {
    pub(super) color: ColorSource,
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
    if scene.materials.is_interface(state.material) {
        scene.report.ignored(place, "an area light on an interface material: it emits no light, as in pbrt");
        return Ok(());
    }
    let &Made::Shape(ShapeDesc::Sphere(ref sphere), _, area) = made else {
        scene
            .report
            .ignored(place, "an invisible area light (alpha 0) that is not a full sphere: it emits no light");
        return Ok(());
    };
    let to_world = &state.ctm[0];
    let size = cbrt(to_world.matrix3.determinant().abs());
    let radius = sphere.radius * size;
    let emission = self::area(scene, state, params, &[area])?.pop().flatten();
    let Some(emission) = emission else { return Ok(()) };
    if !(radius > 0.0 && radius.is_finite()) {
        scene.report.doubtful(place, "an area light of zero size: omitted");
        return Ok(());
    }
    let ColorSource::Constant(color) = emission.color else {
        scene.report.ignored(place, "an invisible area light (alpha 0) with an image: it emits no light");
        return Ok(());
    };
    scene.report.approximated(place, "an invisible area light (alpha 0): replaced by a sphere light");
    // A sphere of radiance L and radius r has the intensity L · π r².
    let light = SphereLightDesc {
        center: to_world.transform_point3(DVec3::ZERO),
        radius,
        samples: 1,
        jitter: true,
        color,
        intensity: sound(emission.radiance * PI * radius * radius),
        attenuation: INVERSE_SQUARE,
    };
    scene.lights.push(LightDesc::Sphere(light).into());
    Ok(())
}

/// The emission of a shape whose lights have these areas, for each of them.
pub(super) fn area(
    scene: &mut Assembly<'_>,
    state: &State,
    params: &Params,
    areas: &[f64],
) -> Result<Vec<Option<Emission>>, Fault> {
    let (scale, tint) = version3::light_scale(scene, state, params)?;
    let radiance = scale * scene.frame.exposure();
    let color = color(scene, state.color_space, params, "L", Role::Light)?;
    let color = color.unwrap_or(state.color_space.white()) * tint;
    // The luminance by which `power` is divided: that of a constant colour does not count.
    let (mut color, mut luminance) = (ColorSource::Constant(scene.frame.balanced(color)), 1.0);
    if let Some(name) = params.string("filename").map(str::to_owned)
        && let Some(shown) = shown(scene, &name, params.place_of("filename"))
    {
        (color, luminance) = shown;
    }
    let two_sided = params.bool("twosided").unwrap_or(false);
    let power = params.float("power").filter(|p| *p > 0.0);
    let sides = if two_sided { 2.0 } else { 1.0 };
    params.pass(&["nsamples", "samples"]);
    params.finish("the area light", &mut scene.report);
    let of_area = |area: &f64| {
        let density = power.map_or(1.0, |power| power / (sides * PI * (luminance * area).max(1e-30)));
        let radiance = (radiance * density).clamp(0.0, 1e15);
        (radiance > 0.0 && radiance.is_finite()).then_some(Emission { color, radiance, two_sided })
    };
    Ok(areas.iter().map(of_area).collect())
}

/// The image of an area light as the colour of its emission, and its mean luminance.
fn shown(scene: &mut Assembly<'_>, name: &str, place: Place) -> Option<(ColorSource, f64)> {
    let file = scene.image(name, place)?;
    let image = scene.images.get(file.index())?.data.clone();
    let look = environment::EncodedView::new(&image);
    let mut sum = 0.0;
    for y in 0..i64::from(image.height) {
        for x in 0..i64::from(image.width) {
            let [r, g, b] = look.pixel(x, y);
            sum += 0.212_673 * r + 0.715_152 * g + 0.072_175 * b;
        }
    }
    let mean = sum / (f64::from(image.width) * f64::from(image.height));
    // All shapes of the light share the texture. The key is no name.
    let key = format!("\0light {}", file.index());
    if let Some(known) = scene.textures.get(&key) {
        return Some((known.source, mean));
    }
    let tint = scene.frame.balanced(Spectrum::WHITE);
    let desc = ImageDesc { file, encoding: Encoding::Srgb, wrap: Wrap::Clamp, tint, ..ImageDesc::default() };
    let source = scene.texture(TextureDesc::Image(desc));
    scene.textures.insert(key, Texture { source });
    Some((source, mean))
}
