//! What lies under a pixel, and where things are.

use turner::description::Labels;
use turner::math::{Bounds, DVec3};
use turner::sampler::SampleId;
use turner::schema::MaterialId;
use turner::view::camera_ray;

use crate::engine::Stand;

/// What a camera ray hits first.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// The index of the entry in the scene's list of objects; `None` for the floor of the default studio.
    pub object: Option<usize>,
    /// Its name, or its shape and number.
    pub label: String,
    /// The material.
    pub material: MaterialId,
    /// The point in world space.
    pub point: DVec3,
    /// The shading normal.
    pub normal: DVec3,
    /// Distance from the camera.
    pub distance: f64,
}

/// What the camera ray through a position hits, in pixels of the film from its top left corner. `None` for nothing.
pub fn pick(stand: &Stand, at: [f64; 2]) -> Option<Picked> {
    let prepared = &stand.prepared;
    let (view, scene) = (&prepared.view, &prepared.scene);
    let inside = |v: f64, size: u32| (v >= 0.0 && v < f64::from(size)).then_some(v as u32);
    let (x, y) = (inside(at[0], view.film.width)?, inside(at[1], view.film.height)?);
    let ray = camera_ray(view, SampleId { x, y, index: 0, seed: 0 }, at)?;
    let hit = scene.intersect_from_camera(&ray)?;
    let surface = scene.surface(&ray, &hit);
    let primitive = scene.primitive_id(&hit);
    let entry = scene.entry_of(primitive) as usize;
    let labels = Labels { scene, desc: &stand.desc };
    let listed = stand.desc.objects.get(entry);
    Some(Picked {
        object: listed.is_some().then_some(entry),
        label: labels.object(primitive, scene.shape_word(&hit)),
        material: surface.material,
        point: surface.p,
        normal: surface.ns,
        distance: hit.shape.t,
    })
}

/// The bounds in world space of an entry of the scene's list of objects; `None` for unbounded or hidden ones.
pub fn object_bounds(stand: &Stand, object: usize) -> Option<Bounds> {
    let scene = &stand.prepared.scene;
    let own = scene.all_bounds().filter(|(primitive, _)| scene.entry_of(*primitive) as usize == object);
    let total = own.fold(Bounds::EMPTY, |total, (_, bounds)| total.union(&bounds));
    (!total.is_empty()).then_some(total)
}

/// The bounds of everything bounded.
pub fn scene_bounds(stand: &Stand) -> Option<Bounds> {
    stand.prepared.scene.stats.bounds
}
