//! Explanations sum to the samples, and probes agree with the picture.

use super::*;
use crate::description::ObjectDesc;
use crate::integrator::{ClassicDesc, DepthDesc, IntegratorDesc, PathDesc};
use crate::light::{LightDesc, PointDesc};
use crate::material::{MaterialDesc, PrincipledMaterial};
use crate::math::DVec3;
use crate::render::sample;
use crate::schema::{ColorSource, MaterialId, PrepareOptions};
use crate::shape::{BoxDesc, ShapeDesc, SphereDesc};

/// A rough sphere on a floor under a point light.
fn desc(integrator: IntegratorDesc, antialias: Antialias, samples: u32) -> SceneDesc {
    let mut desc = SceneDesc { integrator, ..SceneDesc::default() };
    (desc.film.width, desc.film.height) = (24, 16);
    (desc.film.antialias, desc.film.samples) = (antialias, samples);
    let rough = PrincipledMaterial {
        base_metalness: ColorSource::Constant(Spectrum::grey(1.0)),
        specular_roughness: ColorSource::Constant(Spectrum::grey(0.25)),
        ..PrincipledMaterial::default()
    };
    desc.materials = vec![MaterialDesc::Principled(rough).into()];
    let ball = ShapeDesc::Sphere(SphereDesc { center: DVec3::new(0.0, 0.5, 0.0), radius: 0.5 });
    let (min, max) = (Some(DVec3::new(-3.0, -1.0, -3.0)), Some(DVec3::new(3.0, 0.0, 3.0)));
    let floor = ShapeDesc::Box(BoxDesc { min, max, center: None, size: None });
    desc.objects =
        vec![ObjectDesc { material: Some(MaterialId(0)), ..ObjectDesc::new(ball) }, ObjectDesc::new(floor)];
    let light = PointDesc { position: DVec3::new(2.0, 4.0, 3.0), ..PointDesc::default() };
    desc.lights.push(LightDesc::Point(light).into());
    desc
}

#[test]
fn contributions_sum_to_the_sample_of_the_picture() {
    let integrators = [
        (IntegratorDesc::Classic(ClassicDesc::default()), Antialias::None, 1),
        (IntegratorDesc::Classic(ClassicDesc::default()), Antialias::Grid, 4),
        (IntegratorDesc::Path(PathDesc::default()), Antialias::MonteCarlo, 8),
        (IntegratorDesc::Depth(DepthDesc::default()), Antialias::None, 1),
    ];
    for (integrator, antialias, samples) in integrators {
        let desc = desc(integrator, antialias, samples);
        let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
        for (x, y) in [(12, 8), (3, 12), (0, 0)] {
            let last = desc.film.samples_per_pixel() - 1;
            for which in [Which::Index(last), Which::Largest(u32::MAX)] {
                let e = explain(&prepared, &desc, x, y, which).unwrap();
                let rendered = sample(&prepared, x, y, e.tree.number as u32).unwrap().color;
                assert!(e.tree.exact, "{:?}", e.tree);
                assert_eq!((e.tree.rendered, e.tree.sum), (rendered, rendered));
                let root = e.root().unwrap();
                assert_eq!((root.kind, root.parent), (Kind::Camera, None));
                // Up to rounding, as additions are in another order.
                let off = (root.total - rendered).map(f32::abs).max_component();
                assert!(off <= 1e-5 * rendered.max_component().max(1.0), "{off}");
                for (i, node) in e.tree.nodes.iter().enumerate() {
                    assert!(node.children.iter().all(|&c| e.tree.nodes[c].parent == Some(i)));
                }
            }
            let largest = explain(&prepared, &desc, x, y, Which::Largest(u32::MAX)).unwrap().tree.rendered;
            for index in 0..=last {
                let other = explain(&prepared, &desc, x, y, Which::Index(index)).unwrap().tree.rendered;
                assert!(largest.max_component() >= other.max_component());
            }
            assert!(explain(&prepared, &desc, x, y, Which::Index(last + 1)).is_err());
        }
    }
}

#[test]
fn a_ray_says_what_it_hits_in_numbers_and_words() {
    let desc = desc(IntegratorDesc::Classic(ClassicDesc::default()), Antialias::None, 1);
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    let e = explain(&prepared, &desc, 12, 8, Which::Index(0)).unwrap();
    let root = e.root().unwrap();
    let probe = probe(&prepared, &desc, 12, 8).unwrap().unwrap();
    assert_eq!(
        (root.primitive, root.to, &root.target),
        (Some(probe.primitive), Some(probe.position), &probe.object)
    );
    assert_eq!(root.term("t").unwrap().pieces, [Piece::Number(root.distance.unwrap())]);
    assert_eq!(root.term("hits").unwrap().pieces[0], Piece::Vector(probe.position));
    assert!(root.term("N·L").is_none() && root.term("t").unwrap().meaning().is_some());
    assert!(root.summary().starts_with(&format!("camera ray → {}", probe.object)), "{}", root.summary());
    // One shadow ray for the light.
    let shadows: Vec<_> = root.children.iter().filter(|&&c| e.tree.nodes[c].kind == Kind::Shadow).collect();
    assert_eq!(shadows.len(), 1);
}

#[test]
fn a_probe_has_the_values_of_the_surface() {
    let desc = desc(IntegratorDesc::Path(PathDesc::default()), Antialias::MonteCarlo, 4);
    let prepared = desc.prepare(&PrepareOptions::default()).unwrap();
    let pixels = (0..16).flat_map(|y| (0..24).map(move |x| (x, y)));
    let found: Vec<_> = pixels.filter_map(|(x, y)| probe(&prepared, &desc, x, y).unwrap()).collect();
    let ball = found.iter().find(|p| p.primitive == 0).expect("the sphere is in the picture");
    let surface = ball.surface.unwrap();
    assert_eq!((surface.roughness, surface.metalness, surface.transmission), (0.25, 1.0, 0.0));
    let center = DVec3::new(0.0, 0.5, 0.0);
    assert!(((ball.position - center).length() - 0.5).abs() < 1e-9);
    assert!((ball.normal - (ball.position - center) * 2.0).length() < 1e-9);
    assert!(ball.depth > 0.0 && ball.depth <= ball.distance);
    assert!(found.iter().any(|p| p.primitive == 1));
    assert!(probe(&prepared, &desc, 24, 0).is_err());
}
