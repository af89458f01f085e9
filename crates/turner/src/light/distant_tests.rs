//! Directional lights with an extent, the sky light, and IES profiles.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values are independent of the renderer's own functions"
)]

use std::f64::consts::PI;
use std::sync::Arc;

use super::{Attenuation, DirectionalDesc, LightDesc, PointDesc, ProfileUnits, SkyDesc, SpotDesc};
use crate::camera::PinholeDesc;
use crate::color::Spectrum;
use crate::description::{ObjectDesc, SceneDesc};
use crate::film::Antialias;
use crate::integrator::{DirectDesc, IntegratorDesc, LightSampling, PathDesc};
use crate::material::{ClassicMaterial, MaterialDesc, PrincipledMaterial};
use crate::math::DVec3;
use crate::schema::{LightProfile, ProfileFile};
use crate::shape::ShapeDesc;
use crate::testing::scenes::{
    Mean, grey, matte, mean, mean_of, path, pixel, plane, rectangle, render, render_with, rgb, scene, v,
};

const STRATEGIES: [LightSampling; 3] = [LightSampling::Both, LightSampling::Bsdf, LightSampling::Light];

fn by(light_sampling: LightSampling) -> SceneDesc {
    path(PathDesc { light_sampling, ..PathDesc::default() })
}

fn disc(from: DVec3, intensity: f64, angle: f64) -> LightDesc {
    LightDesc::Directional(DirectionalDesc {
        from: Some(from),
        intensity,
        angle,
        ..DirectionalDesc::default()
    })
}

/// Straight down from 0.2 above a point of the ground.
fn down_at(x: f64, z: f64) -> PinholeDesc {
    PinholeDesc {
        position: v(x, 0.2, z),
        look_at: v(x, 0.0, z),
        up: DVec3::NEG_Z,
        fov: Some(0.001),
        ..PinholeDesc::default()
    }
}

/// A disc lights a surface as a point at its centre does, as long as all of it is above the surface.
#[test]
fn a_disc_in_the_sky_lights_a_matte_plane_as_a_point_does() {
    let lit = |samples, sampling, angle| {
        let light = disc(v(1.732_050_807_568_877_2, 1.0, 0.0), 8.0, angle);
        mean(samples, by(sampling).seen_down().with(plane(), matte(rgb([0.5, 0.25, 1.0]))).lit(light))
    };
    let expected = [0.5, 0.25, 1.0].map(|c| c / PI * 4.0);
    for (sampling, samples, cap) in [
        (LightSampling::Both, 256, 0.01),
        (LightSampling::Light, 64, 0.01),
        (LightSampling::Bsdf, 1024, 0.02),
    ] {
        lit(samples, sampling, 50.0).is(expected, cap);
    }
    // BSDF sampling never hits a sun as small as the real one; it has practically no noise.
    lit(64, LightSampling::Both, 0.53).is(expected, 0.001);
}

/// Mirrors and cameras see the disc itself: irradiance over π sin² of half its angle.
#[test]
fn discs_are_visible_in_mirrors_and_in_the_sky() {
    let lit = |desc: SceneDesc| desc.lit(disc(DVec3::Y, 3.0, 10.0));
    let radiance = 3.0 / (PI * 5f64.to_radians().sin().powi(2));
    let mirror = |sampling, roughness| {
        let metal = PrincipledMaterial {
            base_metalness: grey(1.0),
            base_color: grey(1.0),
            specular_roughness: grey(roughness),
            ..PrincipledMaterial::default()
        };
        lit(by(sampling).seen_down().with(plane(), metal))
    };
    let up = |sampling, look_at, fov| {
        let camera = PinholeDesc {
            position: DVec3::ZERO,
            look_at,
            up: DVec3::NEG_Z,
            fov: Some(fov),
            ..PinholeDesc::default()
        };
        lit(by(sampling).before(0.25).seen(camera))
    };
    for sampling in STRATEGIES {
        mean(1, mirror(sampling, 0.0)).is_grey(radiance, 0.0);
        let mut straight = up(sampling, DVec3::Y, 1.0);
        mean(1, straight.clone()).is_grey(radiance + 0.25, 0.0);
        mean(1, up(sampling, v(0.1, 1.0, 0.0), 0.1)).is_grey(0.25, 0.0);
        straight.background.environment = false;
        mean(1, straight).is_grey(0.25, 0.0);
    }
    // A rough mirror: all strategies give the same picture.
    let m = STRATEGIES.map(|sampling| mean_of(24, 512, mirror(sampling, 0.35)));
    m[0].agrees(&m[1], 0.02);
    m[0].agrees(&m[2], 0.02);
}

/// Covers all of the ground to the right, at height 1.
fn edge() -> ShapeDesc {
    rectangle(v(50.0, 1.0, 0.0), v(100.0, 0.0, 0.0), v(0.0, 0.0, 100.0))
}

/// The penumbra of an edge under a disc: half of the light at its centre.
#[test]
fn a_shadow_of_a_disc_is_soft() {
    let lit = |at: f64| {
        scene(IntegratorDesc::Direct(DirectDesc::default()))
            .seen(down_at(at, 0.0))
            .with(plane(), matte(grey(1.0)))
            .with(edge(), matte(grey(0.0)))
            .lit(disc(DVec3::Y, 1.0, 20.0))
    };
    let half = 10f64.to_radians();
    mean(64, lit(0.0)).is_grey(0.5 / PI, 0.01);
    // A straight line cuts the disc: the fraction of a circle beyond it, in the plane of projected directions.
    let fraction = |x: f64| (x.acos() - x * (1.0 - x * x).sqrt()) / PI;
    let at: f64 = 0.08;
    let sin = (at / (1.0f64 + at * at).sqrt()) / half.sin();
    // An edge is a great circle of directions: nearly straight within ten degrees.
    let m = mean(256, lit(at));
    assert!((m.value()[0] * PI - fraction(sin)).abs() < 4e-3, "{m:?} {}", fraction(sin));
    mean(4, lit(0.2)).is_grey(0.0, 0.0);
    mean(4, lit(-0.2)).is_grey(1.0 / PI, 0.01);
}

/// Sky light on level ground: environment plus sun, the same with every sampling strategy.
#[test]
fn the_sky_is_the_same_with_every_sampling_strategy() {
    let seen = |sampling, samples, sky: SkyDesc| -> Mean {
        let desc = by(sampling).seen_down().with(plane(), matte(grey(1.0)));
        mean_of(24, samples, desc.lit(LightDesc::Sky(sky)))
    };
    let day = || SkyDesc { elevation: 40.0, azimuth: 120.0, ..SkyDesc::default() };
    let m = [LightSampling::Both, LightSampling::Light].map(|sampling| seen(sampling, 256, day()));
    m[0].agrees(&m[1], 0.01);
    let wide = [LightSampling::Both, LightSampling::Light, LightSampling::Bsdf]
        .map(|sampling| seen(sampling, 512, SkyDesc { sun_angle: 40.0, ..day() }));
    wide[0].agrees(&wide[1], 0.01);
    wide[0].agrees(&wide[2], 0.02);
    // The sky alone is blue and dimmer; sky and sun add up.
    let sky = seen(LightSampling::Both, 256, SkyDesc { sun: false, ..day() });
    assert!(sky.value()[2] > 1.3 * sky.value()[0] && sky.value()[1] < 0.35 * m[0].value()[1], "{sky:?}");
    let twice = seen(LightSampling::Both, 256, SkyDesc { sun_strength: Spectrum::grey(2.0), ..day() });
    for i in 0..3 {
        let expected = 2.0 * m[0].value()[i] - sky.value()[i];
        assert!((twice.value()[i] / expected - 1.0).abs() < 0.01, "{twice:?} {m:?} {sky:?}");
    }
}

#[test]
fn sky_and_sun_have_their_own_factors() {
    let day = || SkyDesc { elevation: 40.0, azimuth: 120.0, ..SkyDesc::default() };
    let lit = |sky: SkyDesc| {
        let desc = by(LightSampling::Both).seen_down().with(plane(), matte(grey(1.0)));
        mean_of(24, 256, desc.lit(LightDesc::Sky(sky))).value()
    };
    let (sky, both) = (lit(SkyDesc { sun: false, ..day() }), lit(day()));
    let sun = lit(SkyDesc { sky_strength: Spectrum::BLACK, ..day() });
    let tinted = lit(SkyDesc {
        sky_strength: Spectrum::new(0.0, 1.0, 3.0),
        sun_strength: Spectrum::new(2.0, 0.5, 0.0),
        strength: 2.0,
        ..day()
    });
    let [of_sky, of_sun] = [[0.0, 2.0, 6.0], [4.0, 1.0, 0.0]];
    for i in 0..3 {
        assert!((sky[i] + sun[i]) / both[i] > 0.99 && (sky[i] + sun[i]) / both[i] < 1.01, "{sun:?} {both:?}");
        let expected = of_sky[i] * sky[i] + of_sun[i] * sun[i];
        assert!((tinted[i] / expected - 1.0).abs() < 0.01, "{tinted:?} {sky:?} {sun:?}");
    }
}

/// White ground for the classic integrator.
fn classic(size: u32, camera: PinholeDesc) -> SceneDesc {
    let mut desc = SceneDesc::default().seen(camera);
    (desc.film.width, desc.film.height) = (size, size);
    let white = ClassicMaterial { color: grey(1.0), ..ClassicMaterial::default() };
    let white = desc.material(MaterialDesc::Classic(white));
    desc.with_shared(plane(), white)
}

#[test]
fn the_classic_integrator_takes_skies_and_discs() {
    let camera = PinholeDesc { position: DVec3::Y, up: DVec3::NEG_Z, ..PinholeDesc::default() };
    let day = LightDesc::Sky(SkyDesc { elevation: 40.0, ..SkyDesc::default() });
    let mut desc = classic(8, camera).lit(day).lit(disc(DVec3::Y, 1.0, 30.0));
    let picture = render(&desc).0;
    // 1 from straight above, plus a sky whose light is 1/π of the irradiance.
    let v = pixel(&picture, 4, 4)[1];
    assert!(v > 1.4 && v < 2.4, "{v}");
    desc.film.antialias = Antialias::Adaptive;
    assert!(render(&desc).1.shadow > 0);
}

/// Also without a physical integrator: half of the disc gives half of the light.
#[test]
fn the_classic_integrator_makes_soft_shadows_of_discs() {
    let lit = |at: f64| {
        let mut desc = classic(16, down_at(at, 0.0)).lit(disc(DVec3::Y, 1.0, 20.0));
        desc.objects.push(ObjectDesc::new(edge()));
        let picture = render(&desc).0;
        picture.linear.iter().map(|p| f64::from(p[0])).sum::<f64>() / 256.0
    };
    // The disc's normalisation makes up for the mean cosine: the complete disc gives 1.
    assert!((lit(-0.3) - 1.0).abs() < 2e-3, "{}", lit(-0.3));
    assert!((lit(0.0) - 0.5).abs() < 0.02, "{}", lit(0.0));
    assert_eq!(lit(0.3), 0.0);
}

/// A profile that points down in a narrow beam, brighter to the right: symmetric about the plane of 0 and 180
/// degrees.
fn profile() -> ProfileFile {
    let planes = [[200.0, 160.0, 0.0], [200.0, 100.0, 0.0], [200.0, 40.0, 0.0]];
    let around = [0, 1, 2, 1, 0].into_iter().flat_map(|i| planes[i]).collect();
    let profile =
        LightProfile::new(vec![0.0, 30.0, 90.0], vec![0.0, 90.0, 180.0, 270.0, 360.0], around).unwrap();
    ProfileFile { uri: "lamps/down.ies".into(), data: Arc::new(profile) }
}

/// What a light at height 1 above the origin contributes to a point of the ground.
fn lit(light: LightDesc, at: [f64; 2]) -> f64 {
    let mut desc = scene(IntegratorDesc::Direct(DirectDesc::default()))
        .seen(down_at(at[0], at[1]))
        .with(plane(), matte(grey(1.0)))
        .lit(light);
    (desc.film.width, desc.film.height) = (1, 1);
    f64::from(pixel(&render_with(&desc, 1, 1).0, 0, 0)[0]) * PI
}

#[test]
fn ies_profiles_give_the_measured_intensities() {
    let tan30 = 30f64.to_radians().tan();
    let cos30 = 30f64.to_radians().cos();
    let point =
        || PointDesc { position: DVec3::Y, intensity: 3.0, ies: Some(profile()), ..PointDesc::default() };
    let close = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 2e-5 * expected.max(1.0), "{found} {expected}")
    };
    let by_point = |desc: PointDesc, at| lit(LightDesc::Point(desc), at);
    // Relative: 3 in the brightest direction. No attenuation: the cosine remains.
    close(by_point(point(), [0.0, 0.0]), 3.0);
    close(by_point(point(), [tan30, 0.0]), 3.0 * 0.8 * cos30);
    close(by_point(point(), [-tan30, 0.0]), 3.0 * 0.2 * cos30);
    close(by_point(point(), [0.0, tan30]), 3.0 * 0.5 * cos30);
    close(by_point(point(), [0.0, -tan30]), 3.0 * 0.5 * cos30);
    // Half way between 30 and 90 degrees: half of the intensity.
    close(by_point(point(), [3f64.sqrt(), 0.0]), 3.0 * 0.4 * 0.5);
    let candela = PointDesc {
        ies_units: ProfileUnits::Candela,
        attenuation: Attenuation { coefficients: [0.0, 0.0, 1.0] },
        ..point()
    };
    close(by_point(candela, [0.0, 0.0]), 3.0 * 200.0);
    // Rotated, and pointing up.
    close(by_point(PointDesc { ies_rotation: 180.0, ..point() }, [tan30, 0.0]), 3.0 * 0.2 * cos30);
    close(by_point(PointDesc { ies_axis: DVec3::Y, ..point() }, [0.0, 0.0]), 0.0);
    // A spot's profile follows its direction, within its cone.
    let by_spot = |look_at_x, at| {
        let spot = SpotDesc {
            position: DVec3::Y,
            look_at: v(look_at_x, 0.0, 0.0),
            intensity: 3.0,
            angle: 40.0,
            penumbra: 0.0,
            ies: Some(profile()),
            ..SpotDesc::default()
        };
        lit(LightDesc::Spot(spot), at)
    };
    close(by_spot(0.0, [tan30, 0.0]), 3.0 * 0.8 * cos30);
    close(by_spot(tan30, [tan30, 0.0]), 3.0 * cos30);
    close(by_spot(0.0, [3f64.sqrt(), 0.0]), 0.0);
}
