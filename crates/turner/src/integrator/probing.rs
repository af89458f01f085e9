//! Whether probe rays are cheap in a scene.
//!
//! The strategies for caustics and shared paths are chosen by probes of some ten thousand rays, which take little time
//! in ordinary scenes. Where thousands of shapes overlap, each ray is tested against all of them and probes would take
//! minutes. Such scenes are not probed.

use crate::bsdf::sample_cosine;
use crate::math::{Frame, Ray};
use crate::sampler::SampleId;
use crate::scene::Scene;
use crate::view::{View, camera_ray, place_of};

/// Camera rays along the width and height of the image. Each is followed to its hit, and one diffuse bounce beyond.
const SIDE: u32 = 8;

/// Maximum mean number of intersection tests per ray, some microseconds. Ordinary scenes take fewer than ten.
const MAX_TESTS: f64 = 500.0;

/// Seed of the probe rays.
const SEED: u64 = 0x51de;

/// Whether probes are cheap. The answer is the same for any number of threads and any quality of BVH.
pub(in crate::integrator) fn is_cheap(scene: &Scene, view: &View) -> bool {
    let mut left = MAX_TESTS * f64::from(2 * SIDE * SIDE);
    for cell in 0..SIDE * SIDE {
        let centre =
            |n: u32, size: u32| (u64::from(size) * u64::from(2 * n + 1) / u64::from(2 * SIDE)) as u32;
        let (x, y) = (centre(cell % SIDE, view.film.width), centre(cell / SIDE, view.film.height));
        let id = SampleId { x, y, index: 0, seed: SEED };
        let mut next = camera_ray(view, id, place_of(view, &id));
        for _ in 0..2 {
            let Some(ray) = next else { break };
            let hit = scene.intersect(&ray);
            let end = hit.as_ref().map_or(ray.t_max, |hit| hit.shape.t);
            left -= scene.ray_tests(&Ray { t_max: end, ..ray });
            if left < 0.0 {
                return false;
            }
            next = hit.map(|hit| {
                let surface = scene.surface(&ray, &hit);
                let n = if surface.ng.dot(ray.direction) <= 0.0 { surface.ng } else { -surface.ng };
                let direction = Frame::from_z(n).to_world(sample_cosine(id.unit_square(0).into()));
                Ray { time: ray.time, ..Ray::new(surface.leave(direction), direction) }
            });
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Spectrum;
    use crate::description::{ObjectContent, ObjectDesc, SceneDesc};
    use crate::integrator::path::Caustics;
    use crate::integrator::{IntegratorDesc, PathDesc, Prepared};
    use crate::material::{MaterialDesc, PrincipledMaterial};
    use crate::math::DVec3;
    use crate::schema::MeshData;
    use crate::schema::{Asset, ColorSource, GroupId, MaterialId, MeshId, PrepareOptions};
    use crate::shape::{MeshDesc, PointsDesc, ShapeDesc, SphereDesc};
    use std::sync::Arc;

    fn ball(center: DVec3, radius: f64) -> ObjectDesc {
        ObjectDesc::new(ShapeDesc::Sphere(SphereDesc { center, radius }))
    }

    /// The objects seen from the front, filling the centre of the image, with a light at the side.
    fn described(objects: Vec<ObjectDesc>) -> SceneDesc {
        let mut desc = SceneDesc::default();
        (desc.film.width, desc.film.height) = (160, 120);
        desc.integrator = IntegratorDesc::Path(PathDesc::default());
        let light = PrincipledMaterial { emission_luminance: 40.0, ..PrincipledMaterial::default() };
        let glass = PrincipledMaterial {
            transmission_weight: ColorSource::Constant(Spectrum::WHITE),
            specular_roughness: ColorSource::Constant(Spectrum::BLACK),
            ..PrincipledMaterial::default()
        };
        desc.materials = [light, glass].map(|m| MaterialDesc::Principled(m).into()).into();
        desc.objects = objects;
        let light = ball(DVec3::new(1.5, 1.5, 0.0), 0.2);
        desc.objects.push(ObjectDesc { material: Some(MaterialId(0)), ..light });
        desc
    }

    fn prepared(desc: &SceneDesc) -> Prepared {
        desc.prepare(&PrepareOptions::default()).unwrap()
    }

    fn probed(p: &Prepared) -> bool {
        is_cheap(&p.scene, &p.view)
    }

    fn mesh(desc: &mut SceneDesc, data: MeshData) -> MeshId {
        desc.meshes.push(Asset { uri: String::new(), data: Arc::new(data) });
        MeshId(desc.meshes.len() as u32 - 1)
    }

    fn showing(mesh: MeshId) -> ObjectDesc {
        ObjectDesc::new(ShapeDesc::Mesh(MeshDesc { mesh, ..MeshDesc::default() }))
    }

    /// Triangles at the same position.
    fn stack(count: usize) -> MeshData {
        MeshData {
            positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]; count],
            ..MeshData::default()
        }
    }

    /// Probing these scenes takes a minute or more each.
    #[test]
    fn a_hundred_thousand_shapes_at_one_position() {
        let balls = vec![ball(DVec3::ZERO, 1.0); 100_000];
        assert!(!probed(&prepared(&described(balls))));
        // Concentric shells.
        let shells = (0..100_000).map(|i| ball(DVec3::ZERO, 1.0 + 1e-6 * f64::from(i))).collect();
        assert!(!probed(&prepared(&described(shells))));
        let mut desc = described(Vec::new());
        let one = mesh(&mut desc, stack(1));
        desc.objects.extend(std::iter::repeat_n(showing(one), 100_000));
        assert!(!probed(&prepared(&desc)));
    }

    #[test]
    fn two_hundred_thousand_nested_groups() {
        let mut desc = described(Vec::new());
        let count = 200_000;
        let instance = |group| {
            let mut object = ball(DVec3::ZERO, 1.0);
            object.content = ObjectContent::Instance(GroupId(group));
            object
        };
        for i in 0..count {
            let mut objects = vec![ball(DVec3::ZERO, 1.0)];
            objects.extend((i + 1 < count).then(|| instance(i + 1)));
            desc.groups.push(crate::description::GroupDesc { objects, model: None }.into());
        }
        desc.objects.push(instance(0));
        let scene = prepared(&desc);
        assert_eq!(scene.scene.stats.primitives, u64::from(count) + 1);
        assert!(!probed(&scene));
    }

    #[test]
    fn triangles_and_points_at_one_position() {
        let mut desc = described(Vec::new());
        let heap = mesh(&mut desc, stack(50_000));
        desc.objects.push(showing(heap));
        assert!(!probed(&prepared(&desc)));
        let mut desc = described(Vec::new());
        let data = MeshData { positions: vec![[0.0; 3]; 20_000], ..MeshData::default() };
        let points = mesh(&mut desc, data);
        let shown = ShapeDesc::Points(PointsDesc { points, radius: Some(1.0), radii: Vec::new() });
        desc.objects.push(ObjectDesc::new(shown));
        assert!(!probed(&prepared(&desc)));
    }

    /// As many shapes next to one another are probed.
    #[test]
    fn separate_shapes_are_cheap() {
        let place = |i: u32| DVec3::new(f64::from(i % 100), f64::from(i / 100), 0.0) * 0.03 - DVec3::ONE;
        let mut desc = described((0..10_000).map(|i| ball(place(i), 0.01)).collect());
        assert!(probed(&prepared(&desc)));
        let one = mesh(&mut desc, stack(1));
        desc.objects.push(showing(one));
        assert!(probed(&prepared(&desc)));
        assert!(probed(&prepared(&SceneDesc::default())));
    }

    /// Light that only light paths find is kept without a probe.
    #[test]
    fn overlapping_glass_keeps_light_paths() {
        let glass = ObjectDesc { material: Some(MaterialId(1)), ..ball(DVec3::ZERO, 1.0) };
        for (caustics, merges) in
            [(Caustics::Auto, Some(false)), (Caustics::Full, Some(true)), (Caustics::Off, None)]
        {
            let mut desc = described(vec![glass.clone(); 5_000]);
            desc.integrator = IntegratorDesc::Path(PathDesc { caustics, ..PathDesc::default() });
            let scene = prepared(&desc);
            let strategy = scene.path().and_then(|path| path.caustics());
            assert_eq!(strategy.map(|strategy| strategy.merges), merges);
            assert!(
                strategy
                    .is_none_or(|strategy| strategy.paths == 160 * 120 / 4 && strategy.first_radius >= 0.0)
            );
            assert!(!scene.integrator.shares_paths());
        }
    }
}
