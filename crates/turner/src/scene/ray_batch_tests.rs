//! Batches of rays find what each ray finds alone.

use super::RayBatch;
use crate::description::SceneDesc;
use crate::material::{ClassicMaterial, ShadowKind};
use crate::math::{DAffine3, DVec3, Ray};
use crate::sampler::{SampleId, uniform_sphere};
use crate::schema::PrepareOptions;
use crate::shape::{BoxDesc, ShapeDesc};
use crate::testing::scenes::{placed, plane, rgb, sphere, v};

/// Spheres and other shapes, opaque, tinted and shadowless, with and without transforms, plus `extra_spheres`
/// spheres.
fn scene(extra_spheres: u32) -> SceneDesc {
    let tinted = |color, k_refract| ClassicMaterial {
        color: rgb(color),
        k_refract,
        shadow: ShadowKind::Tinted,
        ..ClassicMaterial::default()
    };
    let shadowless = ClassicMaterial { shadow: ShadowKind::None, ..ClassicMaterial::default() };
    let long = DAffine3::from_translation(v(-2.0, 1.0, 1.0)) * DAffine3::from_scale(v(1.0, 2.0, 1.0));
    let mut desc = SceneDesc::default()
        .with_default(plane())
        .with_default(sphere(DVec3::Y, 1.0))
        .with(sphere(v(2.0, 1.0, 0.0), 1.0), tinted([0.5, 0.9, 0.7], 0.8))
        .with(sphere(v(2.0, 1.0, 0.5), 1.0), shadowless);
    desc.objects.push(placed(sphere(DVec3::ZERO, 1.0), long));
    let desc = desc
        .with(ShapeDesc::Box(BoxDesc::default()), tinted([0.3, 0.9, 0.7], 0.5))
        .with_default(sphere(DVec3::Y, 1.0));
    (0..extra_spheres).fold(desc, |desc, i| {
        let x = f64::from(i) * 0.37 - 3.0;
        desc.with_default(sphere(v(x, x * x * 0.3, -1.0), 0.2))
    })
}

#[test]
fn batches_find_what_single_rays_find() {
    for extra_spheres in [0, 20, 90] {
        let scene = scene(extra_spheres).prepare(&PrepareOptions::default()).unwrap().scene;
        let (mut hits, mut through) = (Vec::new(), Vec::new());
        let (mut struck, mut tinted) = (0, 0);
        for n in 0..400 {
            let mut batch = RayBatch::default();
            let rays: Vec<Ray> = (0..1 + n % 23)
                .map(|i| {
                    let id = SampleId { x: n, y: i, index: 0, seed: 3 };
                    let u = id.unit_square(5);
                    let origin = 6.0 * DVec3::new(u.x - 0.5, u.y, id.unit_square(6).x - 0.5);
                    let mut ray = Ray::new(origin, uniform_sphere(id.unit_square(7)));
                    if n % 2 == 0 {
                        ray.t_max = 3.0;
                    }
                    batch.push(&ray);
                    ray
                })
                .collect();
            scene.intersect_batch(&mut batch, &mut hits);
            scene.transmittance_batch(&mut batch, &mut through);
            assert_eq!(hits.len(), rays.len());
            for (i, ray) in rays.iter().enumerate() {
                assert_eq!(format!("{:?}", hits[i]), format!("{:?}", scene.intersect(ray)), "{ray:?}");
                let light = scene.transmittance(ray);
                assert_eq!(through[i / 8].get(i % 8), light, "{ray:?}");
                struck += usize::from(hits[i].is_some());
                tinted += usize::from(light.g > 0.0 && light.g < 1.0);
            }
        }
        assert!(struck > 1000 && tinted > 100, "{struck} {tinted}");
    }
}
