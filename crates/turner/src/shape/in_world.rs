//! Shapes that a transform keeps of their kind. Rays meet them in world space, and so eight at a time, instead of each
//! being transformed to object space.

use super::{RectangleDesc, Shape, Sphere};
use crate::math::{DAffine3, DMat3};
use crate::shape::PlaneDesc;

/// How far the products of a rotation's columns may be from those of unit vectors.
const ROTATION_ERROR: f64 = 1e-15;

impl Shape {
    /// The same shape in world space: planes, rectangles, and spheres that are only moved, turned and scaled alike along
    /// all axes. Its hits have the same u and v, and the same t and normal, up to rounding.
    pub(crate) fn in_world(&self, to_world: &DAffine3) -> Option<Shape> {
        match self {
            Shape::Sphere(s) => {
                let scale = uniform_scale(&to_world.matrix3)?;
                let center = to_world.transform_point3(s.center);
                Some(Shape::Sphere(Sphere { center, radius: scale * s.radius }))
            }
            Shape::Plane(p) => {
                let normal = to_world.matrix3.inverse().transpose() * p.normal;
                let point = to_world.transform_point3(p.point);
                Some(Shape::Plane(PlaneDesc { point, normal }.prepare().ok()?))
            }
            Shape::Rectangle(r) => {
                let (corner, u, v) = r.corner_and_edges();
                let along = |v| to_world.transform_vector3(v);
                let center = to_world.transform_point3(corner + 0.5 * (u + v));
                let desc = RectangleDesc { center, edge_u: along(u), edge_v: along(v) };
                let mirrored = to_world.matrix3.determinant() < 0.0;
                let rectangle = desc.prepare().ok()?;
                Some(Shape::Rectangle(Box::new(if mirrored { rectangle.turned_over() } else { rectangle })))
            }
            Shape::Box(_)
            | Shape::Disk(_)
            | Shape::Cylinder(_)
            | Shape::Cone(_)
            | Shape::Torus(_)
            | Shape::Mesh(_)
            | Shape::Points(_)
            | Shape::Curves(_)
            | Shape::Solid(_) => None,
        }
    }
}

/// The factor by which a matrix scales all lengths, if there is one.
fn uniform_scale(m: &DMat3) -> Option<f64> {
    let scale = m.x_axis.length();
    let unit = m.mul_scalar(scale.recip());
    let product = unit.transpose() * unit - DMat3::IDENTITY;
    let error = product.to_cols_array().into_iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    (error <= ROTATION_ERROR && scale.is_normal()).then_some(scale)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::math::{DVec3, Ray};
    use crate::scene::scene::ObjectTransform;
    use crate::shape::testing::Random;
    use crate::shape::{Plane, ShapeDesc, SphereDesc, SurfacePoint};

    fn shapes() -> Vec<Shape> {
        let sphere = Sphere { center: DVec3::new(0.3, -1.0, 2.0), radius: 0.7 };
        let plane = Plane { point: DVec3::new(0.0, 1.0, 0.5), normal: DVec3::new(0.6, 0.8, 0.0) };
        let edge_u = DVec3::new(2.0, 0.5, 0.0);
        let rectangle = RectangleDesc { center: DVec3::X, edge_u, edge_v: DVec3::new(0.0, 1.0, 3.0) };
        vec![
            Shape::Sphere(sphere),
            Shape::Plane(plane),
            Shape::Rectangle(Box::new(rectangle.prepare().unwrap())),
        ]
    }

    fn turned(random: &mut Random) -> DQuat {
        DQuat::from_axis_angle(random.direction(), 6.0 * random.unit())
    }

    /// Rays meet the shape in world space where they meet it in object space, with the same normals, and no ray that leaves
    /// it meets it again.
    #[test]
    fn hits_are_those_in_object_space() {
        let mut random = Random::new(3);
        let (mut hits, mut found) = (0, [0; 3]);
        for n in 0..6000 {
            let size = [1.0, 1e-3, 300.0, 1e5][n % 4];
            let mut scale = DVec3::splat(size);
            let kind = n % 3;
            if kind != 0 {
                scale *= DVec3::new(1.0, 0.2 + random.unit(), -0.5);
            }
            let translation = random.in_cube() * [0.0, 1.0, 1e3][n / 3 % 3] * size;
            let to_world = DAffine3::from_scale_rotation_translation(scale, turned(&mut random), translation);
            let shape = &shapes()[kind];
            let Some(world) = shape.in_world(&to_world) else { continue };
            found[kind] += 1;
            let transform = ObjectTransform::new(to_world);
            let target = to_world.transform_point3(random.in_cube() * 2.0);
            let from = to_world.transform_point3(random.in_cube() * 8.0);
            let ray = Ray::new(from, (target - from).normalize());
            let own = shape.intersect(&transform.ray_to_object(&ray));
            let there = world.intersect(&ray);
            let (Some(own), Some(there)) = (own, there) else {
                assert_eq!(own.is_some(), there.is_some(), "{n}: a ray at the very edge");
                continue;
            };
            hits += 1;
            let near = |a: f64, b: f64, size: f64| (a - b).abs() <= 1e-9 * size;
            let far = (from - translation).length() + translation.length();
            assert!(near(own.t, there.t, far + own.t), "{n}: {own:?} {there:?}");
            assert!(near(own.u, there.u, 1.0 + far / size) && near(own.v, there.v, 1.0 + far / size), "{n}");

            let s = shape.surface(&ray.transformed(&transform.to_object), &there);
            let SurfacePoint { p, error, ng, .. } = world.surface(&ray, &there);
            assert!((p - to_world.transform_point3(s.p)).length() <= 1e-9 * far, "{n}");
            assert!(ng.dot((transform.normal * s.ng).normalize()) > 1.0 - 1e-9, "{n}");
            for _ in 0..20 {
                let away = random.direction();
                // A sphere is met again from its inside.
                let away = if away.dot(ng) < 0.0 && kind == 0 { -away } else { away };
                let side = if away.dot(ng) >= 0.0 { 4.0 } else { -4.0 };
                let leaving = Ray::new(p + ng * (side * error), away);
                assert_eq!(world.intersect(&leaving), None, "{n}: {away:?}");
            }
        }
        assert!(hits > 1500 && found.iter().all(|count| *count > 1000), "{hits} {found:?}");
    }

    #[test]
    fn stretched_spheres_and_other_shapes_stay_in_object_space() {
        let stretched = DAffine3::from_scale(DVec3::new(1.0, 1.0, 1.001));
        let sheared = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.1, 0.0, 1.0)));
        for to_world in [stretched, sheared] {
            assert!(shapes()[0].in_world(&to_world).is_none());
            assert!(shapes()[2].in_world(&to_world).is_some());
        }
        let mut meshes = crate::shape::mesh_cache::MeshCache::new(&[]);
        let desc = ShapeDesc::Torus(crate::shape::TorusDesc::default());
        assert!(desc.prepare(&mut meshes).unwrap().in_world(&DAffine3::IDENTITY).is_none());
        let sphere = ShapeDesc::Sphere(SphereDesc::default()).prepare(&mut meshes).unwrap();
        assert!(
            sphere.in_world(&DAffine3::from_scale(DVec3::splat(-2.0))).is_some(),
            "a mirrored sphere is one"
        );
    }
}
