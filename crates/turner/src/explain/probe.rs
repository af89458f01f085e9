//! What a pixel shows: the first surface along the ray through its centre, with all its values.

use crate::color::Spectrum;
use crate::description::{Labels, SceneDesc};
use crate::integrator::Prepared;
use crate::material::{PrincipledMaterial, color_at};
use crate::math::DVec3;
use crate::sampler::SampleId;
use crate::schema::{MaterialId, SceneError};
use crate::view::{camera_ray, check_pixel};

/// The first surface that the ray through the centre of a pixel hits. Opacity is not considered.
#[derive(Clone, Debug)]
pub struct Probe {
    /// ID of the primitive.
    pub primitive: u32,
    /// Its name, or its shape and ID.
    pub object: String,
    /// Its shape as a word.
    pub shape: &'static str,
    /// The material.
    pub material_id: MaterialId,
    /// Its name, or its type.
    pub material: String,
    /// The point, in world space.
    pub position: DVec3,
    /// Geometric normal.
    pub geometric_normal: DVec3,
    /// Shading normal, towards the viewer.
    pub normal: DVec3,
    /// Texture coordinates.
    pub uv: [f64; 2],
    /// Distance from the origin of the ray.
    pub distance: f64,
    /// Distance along the viewing direction.
    pub depth: f64,
    /// Whether the ray hits the outside.
    pub outside: bool,
    /// Base colour times its weight.
    pub albedo: Spectrum,
    /// Parameters of the equivalent OpenPBR material at the point; `None` for a mix and for the default material.
    pub surface: Option<SurfaceValues>,
}

/// Parameters of a material at a point, with their textures evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceValues {
    /// `base_metalness`.
    pub metalness: f32,
    /// `specular_weight`.
    pub specular: f32,
    /// `specular_roughness`.
    pub roughness: f32,
    /// `specular_ior`.
    pub ior: f64,
    /// `transmission_weight`.
    pub transmission: f32,
    /// `subsurface_weight`.
    pub subsurface: f32,
    /// `coat_weight`.
    pub coat: f32,
    /// `opacity`.
    pub opacity: f32,
    /// Emitted radiance.
    pub emission: Spectrum,
}

/// What the pixel in column `x`, row `y` (from 0, top left) shows; `None` where its ray hits nothing or the camera has none.
/// Nothing is rendered. `desc` is the description that the scene was prepared from.
///
/// Errors: a pixel outside the picture ([`ErrorCode::OutOfRange`](crate::schema::ErrorCode::OutOfRange)).
pub fn probe(prepared: &Prepared, desc: &SceneDesc, x: u32, y: u32) -> Result<Option<Probe>, SceneError> {
    let (scene, view) = (&*prepared.scene, &prepared.view);
    check_pixel(view, x, y)?;
    let id = SampleId { x, y, index: 0, seed: u64::from(view.film.seed) };
    let Some(ray) = camera_ray(view, id, [f64::from(x) + 0.5, f64::from(y) + 0.5]) else { return Ok(None) };
    let Some(hit) = scene.intersect_from_camera(&ray) else { return Ok(None) };
    let surface = scene.surface(&ray, &hit);
    let (primitive, shape) = (scene.primitive_id(&hit), scene.shape_word(&hit));
    let labels = Labels { scene, desc };
    let outside = surface.ng.dot(ray.direction) <= 0.0;
    let values = |m: PrincipledMaterial| {
        let number = |source| color_at(source, scene, &surface).luminance();
        SurfaceValues {
            metalness: number(m.base_metalness),
            specular: number(m.specular_weight),
            roughness: number(m.specular_roughness),
            ior: m.specular_ior,
            transmission: number(m.transmission_weight),
            subsurface: number(m.subsurface_weight),
            coat: number(m.coat_weight),
            opacity: number(m.opacity),
            emission: m.emitted_color(scene, &scene.texture_point(&surface)),
        }
    };
    let along = surface.p - ray.origin;
    Ok(Some(Probe {
        primitive,
        object: labels.object(primitive, shape),
        shape,
        material_id: surface.material,
        material: labels.material(surface.material),
        position: surface.p,
        geometric_normal: surface.ng,
        normal: if outside { surface.ns } else { -surface.ns },
        uv: scene.texture_point(&surface).uv.into(),
        distance: along.length(),
        depth: along.dot(view.camera.frame().forward),
        outside,
        albedo: scene.material_at(&hit).base_color(scene, &surface, outside),
        surface: desc.materials.get(surface.material.index()).and_then(|m| m.value.principled()).map(values),
    }))
}
