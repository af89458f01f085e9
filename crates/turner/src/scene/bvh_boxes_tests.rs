//! The boxes of each depth contain the scene.

use crate::description::{ObjectDesc, SceneDesc};
use crate::math::{Bounds, DVec3};
use crate::schema::PrepareOptions;
use crate::shape::{ShapeDesc, SphereDesc};

fn spheres(count: u32) -> SceneDesc {
    let mut desc = SceneDesc::default();
    for i in 0..count {
        let center = DVec3::new(f64::from(i % 10) * 3.0, f64::from(i / 10 % 10) * 2.0, f64::from(i / 100));
        let ball = SphereDesc { center, radius: 0.25 };
        desc.objects.push(ObjectDesc::new(ShapeDesc::Sphere(ball)));
    }
    desc
}

fn contains(boxes: &[Bounds], inner: &Bounds) -> bool {
    boxes.iter().any(|b| b.min.cmple(inner.min).all() && b.max.cmpge(inner.max).all())
}

#[test]
fn boxes_contain_the_objects_at_each_depth() {
    for count in [7, 500] {
        let scene = spheres(count).prepare(&PrepareOptions::default()).unwrap().scene;
        let bounds: Vec<Bounds> = scene.primitives.iter().filter_map(|p| p.shape.bounds()).collect();
        let mut last = 0;
        for depth in 0..4 {
            let boxes = scene.bvh_boxes(depth, 10_000);
            assert!(bounds.iter().all(|b| contains(&boxes, b)), "{count} {depth}");
            // With few objects a sphere culler takes the place of the BVH.
            assert!(if count == 7 { boxes.len() == 7 } else { boxes.len() > last }, "{count} {depth}");
            last = boxes.len();
        }
        assert!(scene.bvh_boxes(9, 5).len() <= 5);
    }
}
