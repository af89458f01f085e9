//! Dispersion.

use crate::description::ObjectDesc;
use crate::integrator::{LightSampling, PathDesc};
use crate::material::PrincipledMaterial;
use crate::math::{DAffine3, DVec3};
use crate::schema::Transform;
use crate::schema::transform::rotation;
use crate::shape::ShapeDesc;
use crate::testing::scenes::{cuboid, emissive, grey, mean, path, rectangle, sphere, v};
use crate::texture::{GradientDesc, TextureDesc};

/// Indices of the three bands for n_d = 1.5 and an Abbe number of 10: Cauchy's equation at 611.4, 549.1 and 464.3 nm.
fn indices() -> [f64; 3] {
    let inverse2 = |l: f64| 1.0 / (l * l);
    let b = 0.5 / (10.0 * (inverse2(0.48613) - inverse2(0.65627)));
    [0.6114, 0.5491, 0.4643].map(|l| 1.5 + b * (inverse2(l) - inverse2(0.58756)))
}

fn glass(roughness: f64) -> PrincipledMaterial {
    PrincipledMaterial {
        transmission_weight: grey(1.0),
        specular_roughness: grey(roughness),
        transmission_dispersion_scale: 2.0,
        ..PrincipledMaterial::default()
    }
}

fn slab() -> ShapeDesc {
    cuboid(v(-9.0, -9.0, -1.0), v(9.0, 9.0, 1.0))
}

fn wall() -> ShapeDesc {
    rectangle(v(0.0, 0.0, -20.0), v(8.0, 0.0, 0.0), v(0.0, 8.0, 0.0))
}

#[test]
fn each_band_is_shifted_by_its_own_index() {
    // A slab rotated by 50 degrees shifts what is behind it, here a linear gradient. Only paths that refract in and out
    // count.
    let (angle, thickness): (f64, f64) = (50f64.to_radians(), 2.0);
    let mut desc = path(PathDesc { max_depth: 2, ..PathDesc::default() }).seen_from_front(10.0, 0.001);
    let slope = desc.texture(TextureDesc::Gradient(GradientDesc::default()));
    let turn = Transform(DAffine3::from_mat3(rotation(DVec3::Y, 50.0)));
    let desc = desc
        .with_object(ObjectDesc { transform: turn, ..ObjectDesc::new(slab()) }, glass(0.0))
        .with(wall(), emissive(1.0, slope));
    let expected = indices().map(|n| {
        let inner = (angle.sin() / n).asin();
        let shift = thickness * (angle - inner).sin() / inner.cos();
        let (ci, ct) = (angle.cos(), inner.cos());
        let s = (ci - n * ct) / (ci + n * ct);
        let p = (n * ci - ct) / (n * ci + ct);
        let through = 1.0 - 0.5 * (s * s + p * p);
        // From black at x = −4 to white at x = 4.
        [through * through * (0.5 + shift / 8.0), through * through * (0.5 - shift / 8.0)]
    });
    let seen = mean(1024, desc);
    let side = usize::from(seen.value()[1] < 0.5 * expected[1][0] + 0.5 * expected[1][1]);
    seen.is(expected.map(|e| e[side]), 0.01);
    // The bands differ by far more than the tolerance.
    assert!((seen.value()[2] - seen.value()[0]).abs() > 0.01 * seen.value()[0], "{seen:?}");
}

#[test]
fn a_slab_seen_head_on_passes_each_band_by_its_index() {
    let desc = path(PathDesc { max_depth: 100, ..PathDesc::default() })
        .seen_from_front(10.0, 0.001)
        .with(slab(), glass(0.0))
        .with(wall(), emissive(1.0, grey(1.0)));
    let expected = indices().map(|n| {
        let r = ((n - 1.0) / (n + 1.0)).powi(2);
        (1.0 - r) / (1.0 + r)
    });
    mean(1024, desc).is(expected, 0.01);
}

#[test]
fn clear_glass_passes_a_furnace() {
    for (roughness, most, least) in [(0.0, 1.0002, 0.9998), (0.4, 1.003, 0.95)] {
        let desc = path(PathDesc { max_depth: 1000, rr_start: Some(1000), ..PathDesc::default() })
            .before(1.0)
            .seen_from_front(4.0, 20.0)
            .with(sphere(DVec3::ZERO, 1.0), glass(roughness));
        let seen = mean(256, desc);
        for i in 0..3 {
            let slack = 4.0 * seen.error()[i];
            assert!(
                slack < 0.05 && seen.value()[i] > least - slack && seen.value()[i] < most + slack,
                "{seen:?}"
            );
        }
    }
}

#[test]
fn rough_dispersive_glass_is_the_same_by_both_strategies() {
    let lit = |light_sampling| {
        path(PathDesc { max_depth: 4, light_sampling, ..PathDesc::default() })
            .seen_from_front(4.0, 0.001)
            .with(slab(), glass(0.5))
            .with(rectangle(v(1.0, 0.0, -4.0), v(3.0, 0.0, 0.0), v(0.0, 3.0, 0.0)), emissive(1.0, grey(1.0)))
    };
    mean(512, lit(LightSampling::Both)).agrees(&mean(1024, lit(LightSampling::Bsdf)), 0.03);
}
