//! First hits of camera rays, and the cost of finding them.

use super::grid::Pixel;
use super::{Options, threads};
use crate::doctor::subject::Subject;
use crate::math::{DVec3, Ray};
use crate::scene::Scene;
use crate::schema::MaterialId;
use crate::view::{camera_ray, place_of};

/// The camera ray of a pixel's first sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstHit {
    pub(super) ray: Ray,
    /// Its first hit, if any.
    pub(super) hit: Option<Hit>,
    /// Number of boxes and shapes tested.
    pub(super) steps: u64,
}

/// A first hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) t: f64,
    pub(super) p: DVec3,
    /// Geometric normal on the side of the camera.
    pub(super) n: DVec3,
    pub(super) primitive: u32,
    pub(super) shape: &'static str,
    pub(super) material: MaterialId,
    /// Whether the ray hits the front face.
    pub(super) outside: bool,
    /// Luminance of the base colour.
    pub(super) albedo: f64,
    /// Whether the surface emits light towards the camera, or is unlit.
    pub(super) emits: bool,
    /// Whether the shape is unbounded.
    pub(super) unbounded: bool,
    /// Whether it is a shadow catcher.
    pub(super) catches_shadows: bool,
    /// Whether the geometric and the shading normal are finite and on the same side.
    pub(super) valid_normals: bool,
}

/// The first hits of all pixels, in their order; `None` for pixels without a camera ray.
pub(super) fn first_hits(scene: &Subject, pixels: &[Pixel], options: &Options<'_>) -> Vec<Option<FirstHit>> {
    let never = || false;
    let found = threads::map(pixels, options.threads, &never, |pixel| {
        let id = pixel.sample(scene, 0);
        let ray = camera_ray(&scene.prepared.view, id, place_of(&scene.prepared.view, &id))?;
        Some(FirstHit { ray, hit: first(scene, &ray), steps: steps(scene, &ray) })
    });
    found.into_iter().map(Option::flatten).collect()
}

fn steps(scene: &Scene, ray: &Ray) -> u64 {
    let end = scene.intersect(ray).map_or(ray.t_max, |hit| hit.shape.t);
    let cost = scene.search_cost(&Ray { t_max: end, ..*ray });
    cost.boxes + cost.tests
}

/// The first hit of `ray`.
pub(super) fn first(scene: &Scene, ray: &Ray) -> Option<Hit> {
    let hit = scene.intersect_from_camera(ray)?;
    let surface = scene.surface(ray, &hit);
    let material = scene.material_at(&hit);
    let outside = surface.ng.dot(ray.direction) <= 0.0;
    let color = material.base_color(scene, &surface, outside);
    let n = if outside { surface.ng } else { -surface.ng };
    let finite = surface.ng.is_finite() && surface.ns.is_finite() && surface.p.is_finite();
    Some(Hit {
        t: hit.shape.t,
        p: surface.p,
        n,
        primitive: scene.primitive_id(&hit),
        shape: scene.shape_word(&hit),
        material: surface.material,
        outside,
        albedo: f64::from(color.luminance()),
        emits: super::materials::emits_at(scene, surface.material, outside),
        unbounded: scene.is_unbounded(&hit),
        catches_shadows: scene.is_shadow_catcher(&hit),
        valid_normals: finite && surface.ng.dot(surface.ns) > 0.0,
    })
}

/// Uniformly distributed directions: a Fibonacci spiral on the sphere.
pub(super) fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    // The golden angle, in turns.
    const STEP: f64 = 0.381_966_011_250_105_1;
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = crate::math::elementary::sin_cos_turns((f64::from(i) * STEP).fract());
        DVec3::new(r * cos, z, r * sin)
    })
}
