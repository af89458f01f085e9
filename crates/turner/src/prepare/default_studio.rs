//! The default studio: what Turner adds to a scene without camera, lights or floor.

use crate::camera::CameraDesc;
use crate::color::Spectrum;
use crate::description::default_studio::Orbit;
use crate::description::{SceneDesc, StudioDesc};
use crate::light::{EnvironmentDesc, Light};
use crate::material::{Material, MaterialDesc, PrincipledMaterial};
use crate::math::elementary::sin_cos;
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
    /// Notes about what was added.
    pub(crate) notes: Vec<Warning>,
}

impl DefaultStudio {
    /// Appends the material of the floor.
    pub(super) fn add_floor(&self, physical: bool, materials: &mut Vec<Material>) {
        if let Some((_, material)) = &self.ground {
            materials.push(MaterialDesc::Principled(material.clone()).prepare(physical, &[]));
        }
    }
}

impl StudioDesc {
    /// Adds what the scene lacks; lights go to `lights`. `bounds` contain all bounded objects.
    pub(crate) fn complete(
        &self,
        scene: &SceneDesc,
        bounds: &Bounds,
        compensates: bool,
        lights: &mut Vec<Light>,
    ) -> Result<DefaultStudio, SceneError> {
        let mut studio = DefaultStudio::default();
        let aspect = scene.film.aspect();
        let own = scene.camera.as_ref().or(scene.cameras.first());
        let camera = match &self.camera {
            None => own.cloned(),
            Some(wanted) => match Orbit::parse(wanted) {
                Some(Ok(orbit)) => Some(unnamed(orbit.camera(bounds, self.fov, aspect))),
                Some(Err(message)) => return Err(SceneError::new(ErrorCode::OutOfRange, message)),
                None => Some(named_camera(scene, wanted)?),
            },
        };
        let framed = camera.is_none();
        studio.camera = camera.or_else(|| Some(unnamed(Orbit::DEFAULT.camera(bounds, self.fov, aspect))));
        if !bounds.is_empty() && bounds.is_finite() {
            let radius = 0.5 * bounds.size().length();
            let far = bounds.center().abs().max_element();
            // Single precision has 24 bits: at this distance, vertices are on a grid of 1/160 of the size.
            if far > 1e5 * radius && radius > 0.0 {
                let message = "the scene is far from the origin for its size: mesh vertices, in single precision, are rounded coarsely there. Move it to the origin";
                studio.notes.push(Warning::new(WarningKind::Doubtful, message));
            }
        }
        let mut note = |message: &str, remedy| {
            studio.notes.push(Warning { remedy: Some(remedy), ..Warning::new(WarningKind::Note, message) });
        };
        if framed {
            note(
                "no camera in the file: the view is from the front, right and above",
                Remedy::set("studio.camera", "orbit:azimuth,elevation"),
            );
        }
        if self.lights && lights.is_empty() {
            let studio = EnvironmentDesc {
                strength: self.strength,
                rotation: self.rotation,
                ..EnvironmentDesc::studio()
            };
            lights.push(Light::Environment(studio.prepare(&[], compensates)?));
            note(
                "no light in the file: the built-in studio lights it until you add a light or an environment map",
                Remedy::Environment,
            );
        }
        let wanted = self.ground.unwrap_or(own.is_none() && !scene.background.transparent);
        if wanted && !bounds.is_empty() && bounds.is_finite() {
            let gap = 1e-4 * bounds.size().max_element().max(1e-9 * bounds.min.abs().max_element());
            let point = DVec3::new(0.0, bounds.min.y - gap, 0.0);
            let base_color = ColorSource::Constant(ground_color(lights));
            let material = PrincipledMaterial { base_color, ..PrincipledMaterial::matte() };
            studio.ground = Some((Plane { point, normal: DVec3::Y }, material));
            if self.ground.is_none() {
                note("no floor in the file: one was added", Remedy::set("studio.ground", false));
            }
        }
        Ok(studio)
    }
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

/// The floor colour for which a floor without shadows has the radiance of the horizon behind it, so that no edge
/// is visible. A diffuse floor of albedo C under irradiance E has radiance E·C/π, and E/π is the cosine-weighted
/// mean of the radiance above.
fn ground_color(lights: &[Light]) -> Spectrum {
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
    let horizon = ring(0.01);
    let ratio = |horizon: f32, mean: f32| if mean > 0.0 { (horizon / mean).clamp(0.05, 0.85) } else { 0.5 };
    Spectrum::new(ratio(horizon.r, mean.r), ratio(horizon.g, mean.g), ratio(horizon.b, mean.b))
}
