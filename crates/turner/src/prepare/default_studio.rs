//! The default studio: what Turner adds to a scene without camera, lights or floor.

use std::f64::consts::LOG2_E;

use crate::camera::CameraDesc;
use crate::color::Spectrum;
use crate::description::default_studio::{self, Orbit};
use crate::description::framing::Subject;
use crate::description::{ObjectDesc, SceneDesc, StudioDesc};
use crate::light::{BackgroundDesc, EnvironmentDesc, Light, LightDesc};
use crate::material::{Material, MaterialDesc, PrincipledMaterial};
use crate::math::elementary::{ln, pow, sin_cos};
use crate::math::{Bounds, DVec3};
use crate::schema::error::unknown_name;
use crate::schema::value::Span;
use crate::schema::{ColorSource, ErrorCode, Named, Remedy, SceneError, Warning, WarningKind};
use crate::shape::Plane;

/// What the default studio adds to a scene.
#[derive(Debug, Default)]
pub(crate) struct DefaultStudio {
    /// The camera of the view.
    pub(crate) camera: Option<Named<CameraDesc>>,
    /// The floor and its material.
    pub(crate) ground: Option<(Plane, PrincipledMaterial)>,
    /// Whether the camera sees only the shadows on the floor.
    pub(crate) catches_shadows: bool,
    /// What the camera sees behind everything, as scene radiance.
    pub(crate) backdrop: Option<Spectrum>,
    /// The exposure for the light of environment maps, in stops.
    pub(crate) exposure: f64,
    /// Notes about what was added.
    pub(crate) notes: Vec<Warning>,
}

impl DefaultStudio {
    /// The background, or the backdrop of the studio instead.
    pub(super) fn background(&self, desc: &BackgroundDesc) -> BackgroundDesc {
        let own = desc.prepared();
        match self.backdrop {
            Some(color) => BackgroundDesc { color, zenith: None, environment: false, ..own },
            None => own,
        }
    }

    /// Appends the material of the floor.
    pub(super) fn add_floor(&self, physical: bool, materials: &mut Vec<Material>) {
        if let Some((_, material)) = &self.ground {
            materials.push(MaterialDesc::Principled(material.clone()).prepare(physical, &[]));
        }
    }
}

/// The objects of a name, or all of them.
pub(crate) type Subjects<'a> = dyn Fn(Option<&str>) -> Result<Subject, SceneError> + 'a;

impl StudioDesc {
    /// Adds what the scene lacks; lights go to `lights`. `bounds` contain all bounded objects; `subject` gives the objects
    /// of a name, or all of them.
    pub(crate) fn complete(
        &self,
        scene: &SceneDesc,
        (bounds, subject): (&Bounds, &Subjects<'_>),
        compensates: bool,
        lights: &mut Vec<Light>,
    ) -> Result<DefaultStudio, SceneError> {
        let mut studio = DefaultStudio::default();
        let aspect = scene.film.aspect();
        let own = scene.camera.as_ref().or(scene.cameras.first());
        let mut orbit = None;
        let camera = match &self.camera {
            None => own.cloned(),
            Some(wanted) => match Orbit::parse(wanted) {
                Some(Ok(wanted)) => {
                    orbit = Some(wanted);
                    None
                }
                Some(Err(message)) => return Err(SceneError::new(ErrorCode::OutOfRange, message)),
                None => Some(named_camera(scene, wanted)?),
            },
        };
        if self.look_at.is_some() && camera.is_some() {
            let message = "`look_at` of [studio] needs an orbit camera: this camera has its own direction";
            let help = "give [studio] an orbit camera, such as `camera = \"orbit:35,22\"`";
            return Err(SceneError::new(ErrorCode::Conflict, message).help(help));
        }
        let is_default = camera.is_none() && orbit.is_none();
        let orbit = if is_default { Some(Orbit::DEFAULT) } else { orbit };
        studio.camera = match (camera, orbit) {
            (None, Some(orbit)) => {
                let own = scene.camera.as_ref().map(|camera| &camera.value);
                let subject = subject(self.look_at.as_deref())?;
                Some(unnamed(self.framed(&orbit, &subject, own, aspect)))
            }
            (camera, _) => camera.map(|camera| {
                let radius = if bounds.is_finite() { 0.5 * bounds.size().length() } else { 1.0 };
                Named { value: self.refined(camera.value, radius, aspect), ..camera }
            }),
        };
        studio.notes.extend(far_from_origin(bounds));
        let mut note = |message: &str, remedy| {
            studio.notes.push(Warning { remedy: Some(remedy), ..Warning::new(WarningKind::Note, message) });
        };
        if is_default {
            note(
                "no camera in the file: the view is from the front, right and above",
                Remedy::set("studio.camera", "orbit:azimuth,elevation"),
            );
        }
        let lit = self.lights && lights.is_empty() && !has_shapes_as_lights(scene);
        if lit {
            let studio = EnvironmentDesc {
                strength: self.strength,
                rotation: self.rotation + orbit.map_or(0.0, |orbit| orbit.azimuth),
                ..EnvironmentDesc::studio()
            };
            lights.push(Light::Environment(studio.prepare(&[], compensates)?));
            note(
                "no light in the file: the built-in studio lights it until you add a light or an environment map",
                Remedy::Environment,
            );
        }
        if self.metering && !lit && !scene.film.auto_exposure {
            studio.exposure = metered(scene, studio.camera.as_ref(), lights);
            if studio.exposure != 0.0 {
                let message = format!(
                    "exposure {:+} stops, for the light of the environment; more or less",
                    studio.exposure
                );
                note(&message, Remedy::set("film.exposure", "STOPS"));
            }
        }
        let backdrop = self.backdrop.or_else(|| {
            (lit && scene.background == BackgroundDesc::default()).then_some(default_studio::BACKDROP)
        });
        studio.backdrop = backdrop.filter(|_| !scene.background.transparent).map(|shown| {
            let stops = (scene.film.exposure + studio.exposure).clamp(-64.0, 64.0);
            scene.film.tonemap.inverse(shown) * pow(2.0, -stops) as f32
        });
        let shows_environment =
            scene.background.environment && lights.iter().any(|l| matches!(l, Light::Environment(_)));
        studio.catches_shadows =
            scene.background.transparent || studio.backdrop.is_some() || shows_environment;
        let wanted = self.ground.unwrap_or(own.is_none() && !scene.background.transparent);
        if wanted && !bounds.is_empty() && bounds.is_finite() {
            let gap = 1e-4 * bounds.size().max_element().max(1e-9 * bounds.min.abs().max_element());
            let point = DVec3::new(0.0, bounds.min.y - gap, 0.0);
            // From below, a floor would hide everything.
            let height = studio.camera.clone().map(|mut camera| camera.value.placement_mut()[0].y);
            if height.is_some_and(|height| height <= point.y) {
                return Ok(studio);
            }
            let base_color = ColorSource::Constant(ground_color(lights, studio.backdrop));
            let material = PrincipledMaterial { base_color, ..PrincipledMaterial::matte() };
            studio.ground = Some((Plane { point, normal: DVec3::Y }, material));
            if self.ground.is_none() {
                note("no floor in the file: one was added", Remedy::set("studio.ground", false));
            }
        }
        Ok(studio)
    }
}

/// A warning about a scene whose vertices are rounded coarsely.
fn far_from_origin(bounds: &Bounds) -> Option<Warning> {
    let radius = 0.5 * bounds.size().length();
    let far = bounds.center().abs().max_element();
    // Single precision has 24 bits: at this distance, vertices are on a grid of 1/160 of the size.
    let is_far = !bounds.is_empty() && bounds.is_finite() && far > 1e5 * radius && radius > 0.0;
    let message = "the scene is far from the origin for its size: mesh vertices, in single precision, are rounded coarsely there. Move it to the origin";
    is_far.then(|| Warning::new(WarningKind::Doubtful, message))
}

/// The exposure in stops that the lights of a scene ask for, in steps of a tenth.
fn metered(scene: &SceneDesc, camera: Option<&Named<CameraDesc>>, lights: &[Light]) -> f64 {
    let back = camera.cloned().map_or(DVec3::Z, |mut camera| {
        let [position, look_at, _] = camera.value.placement_mut();
        (*position - *look_at).normalize_or_zero()
    });
    // `strength` makes the picture brighter.
    let strength = scene.lights.iter().find_map(|l| match &l.value {
        LightDesc::Environment(l) if l.strength > 0.0 => Some(l.strength),
        _ => None,
    });
    let stops = super::metering::exposure(lights, back);
    let stops = stops.map(|stops| stops + ln(strength.unwrap_or(1.0)) * LOG2_E);
    stops.map_or(0.0, |stops| (10.0 * stops).round().clamp(-160.0, 160.0) / 10.0)
}

fn unnamed(value: CameraDesc) -> Named<CameraDesc> {
    Named { name: None, span: None::<Span>, value }
}

/// A camera of a model, by name or index.
fn named_camera(scene: &SceneDesc, wanted: &str) -> Result<Named<CameraDesc>, SceneError> {
    let by_name = scene.cameras.iter().find(|c| c.name.as_deref() == Some(wanted));
    let by_number = || wanted.parse::<usize>().ok().and_then(|i| scene.cameras.get(i));
    by_name.or_else(by_number).cloned().ok_or_else(|| {
        let names: Vec<&str> = scene.cameras.iter().filter_map(|c| c.name.as_deref()).collect();
        let span = Span { file: crate::schema::value::FileId(u32::MAX), start: 0, end: 0 };
        let mut error = unknown_name(ErrorCode::UnknownName, span, "camera", wanted, &names);
        error.span = None;
        if scene.cameras.is_empty() {
            error.help("the scene has no cameras; write orbit:azimuth,elevation, as in orbit:30,20")
        } else {
            error
        }
    })
}

/// The floor colour for which a floor without shadows has the radiance of the backdrop or of the horizon behind it, so
/// that no edge is visible in mirrors and through glass. A diffuse floor of albedo C under irradiance E has radiance
/// E·C/π, and E/π is the cosine-weighted mean of the radiance above.
fn ground_color(lights: &[Light], backdrop: Option<Spectrum>) -> Spectrum {
    const RINGS: u32 = 48;
    const SECTORS: u32 = 96;
    let radiance = |height: f64, azimuth: f64| {
        let (sin, cos) = sin_cos(std::f64::consts::TAU * azimuth);
        let radius = (1.0 - height * height).sqrt();
        let direction = DVec3::new(radius * cos, height, radius * sin);
        lights.iter().filter_map(|l| l.around(direction)).fold(Spectrum::BLACK, |sum, l| sum + l)
    };
    let ring = |height: f64| {
        let all = (0..SECTORS).map(|i| radiance(height, (f64::from(i) + 0.5) / f64::from(SECTORS)));
        all.fold(Spectrum::BLACK, |sum, l| sum + l) * (1.0 / SECTORS as f32)
    };
    // Stratified in the square of the height, which distributes the samples by the cosine.
    let heights = (0..RINGS).map(|i| ((f64::from(i) + 0.5) / f64::from(RINGS)).sqrt());
    let mean = heights.fold(Spectrum::BLACK, |sum, height| sum + ring(height)) * (1.0 / RINGS as f32);
    let horizon = backdrop.unwrap_or_else(|| ring(0.01));
    let ratio = |horizon: f32, mean: f32| if mean > 0.0 { (horizon / mean).clamp(0.05, 0.9) } else { 0.5 };
    Spectrum::new(ratio(horizon.r, mean.r), ratio(horizon.g, mean.g), ratio(horizon.b, mean.b))
}

/// Whether a shape that the camera does not see emits light: the light of another program.
fn has_shapes_as_lights(scene: &SceneDesc) -> bool {
    let emits = |object: &ObjectDesc| {
        let material = object.material.and_then(|id| scene.materials.get(id.index()));
        let is_emitter = matches!(material.map(|m| &m.value),
            Some(MaterialDesc::Principled(m)) if m.emission_luminance > 0.0);
        object.hidden_from_camera && !object.hidden && is_emitter
    };
    let inner = scene.groups.iter().flat_map(|group| &group.value.objects);
    scene.objects.iter().chain(inner).any(emits)
}
