//! Many rays at once find what each finds alone.

use turner::math::{DVec3, Ray};
use turner::sampler::{SampleId, uniform_sphere};
use turner::scene::RayBatch;
use turner::schema::PrepareOptions;

use crate::classic::common::describe;

/// Spheres and other shapes, opaque, tinted and shadowless, with and without transforms; `more` spheres beside.
fn scene(more: usize) -> String {
    let mut text = r#"
        [[object]]
        type = "plane"
        [[object]]
        type = "sphere"
        center = [0, 1, 0]
        [[object]]
        type = "sphere"
        center = [2, 1, 0]
        material = { color = [0.5, 0.9, 0.7], k_refract = 0.8, shadow = "tinted" }
        [[object]]
        type = "sphere"
        center = [2, 1, 0.5]
        material = { shadow = "none" }
        [[object]]
        type = "sphere"
        transform = [{ scale = [1, 2, 1] }, { translate = [-2, 1, 1] }]
        [[object]]
        type = "box"
        material = { color = [0.3, 0.9, 0.7], k_refract = 0.5, shadow = "tinted" }
        [[object]]
        type = "sphere"
        center = [0, 1, 0]
        "#
    .to_owned();
    for i in 0..more {
        let x = i as f64 * 0.37 - 3.0;
        text +=
            &format!("[[object]]\ntype = \"sphere\"\nradius = 0.2\ncenter = [{x}, {}, -1]\n", x * x * 0.3);
    }
    text
}

#[test]
fn batches_find_what_single_rays_find() {
    for more in [0, 20, 90] {
        let scene = describe(&scene(more)).prepare(&PrepareOptions::default()).unwrap().scene;
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
