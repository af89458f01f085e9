//! The sky model compared with physics and with measurements.

use super::spectrum::{BANDS, Bands, SUN_ABOVE_AIR};
use super::*;
use crate::light::Light;
use crate::math::elementary::{exp, sin};

fn desc() -> SkyDesc {
    SkyDesc { ..SkyDesc::default() }
}

fn setting(compensated: bool, physical: bool) -> LightSetting<'static> {
    LightSetting { images: &[], compensated, physical, threads: 2, before: &[] }
}

fn radiance(sky: &Sky, cos_view: f64, cos_turn: f64) -> Bands {
    let [light] = sky.radiances(0.0, cos_view, &[cos_turn]);
    light
}

fn sky(air: f64, dust: f64, ozone: f64, elevation: f64, albedo: f64) -> Sky {
    let atmosphere = Atmosphere { depths: Depths::new(air, dust, ozone) };
    Sky::new(atmosphere, radians(90.0 - elevation), albedo)
}

/// Irradiance of the sky on level ground at each wavelength, as a fraction of the sunlight above the atmosphere.
fn diffuse(sky: &Sky) -> Bands {
    let mut sum = [0.0; BANDS];
    let (rings, environment) = (48, 32);
    for ring in 0..rings {
        // Uniform in the square of the sine: cosine-weighted.
        let sin2 = (f64::from(ring) + 0.5) / f64::from(rings);
        for turn in 0..environment {
            let cos_turn = cos(PI * (f64::from(turn) + 0.5) / f64::from(environment));
            let light = radiance(sky, (1.0 - sin2).sqrt(), cos_turn);
            for (sum, v) in sum.iter_mut().zip(light) {
                *sum += v * PI / f64::from(rings * environment);
            }
        }
    }
    sum
}

/// Air absorbs nothing: light that does not come down returns to space. At 45 degrees a thin layer of optical depth τ
/// scatters 1 − e^(−τ/cos) of the sunlight, half of it down.
#[test]
fn air_scatters_as_much_down_as_up() {
    let sky = sky(1.0, 0.0, 0.0, 45.0, 0.0);
    let down = diffuse(&sky);
    let depths = Depths::new(1.0, 0.0, 0.0).air;
    for i in 4..BANDS {
        let (tau, facing) = (depths[i], sin(radians(45.0)));
        let scattered = facing * (1.0 - exp(-tau / facing));
        // Light scattered up is scattered again, a little more of it down than up: the air is denser below.
        let fraction = down[i] / scattered;
        assert!((0.46..0.54).contains(&fraction), "τ = {tau}: {fraction}");
    }
}

/// Two-stream solution (Meador & Weaver 1980) for conservative, symmetric scattering: T = 1 − R comes down over black
/// ground, direct sunlight included.
#[test]
fn thick_air_agrees_with_two_streams() {
    let depths = Depths::new(1.0, 0.0, 0.0).air;
    for elevation in [30.0, 60.0, 90.0] {
        let down = diffuse(&sky(1.0, 0.0, 0.0, elevation, 0.0));
        let mu = sin(radians(elevation));
        for i in [0, 2, 5, 10] {
            let tau = depths[i];
            let through = ((2.0 / 3.0 + mu) + (2.0 / 3.0 - mu) * exp(-tau / mu)) / (4.0 / 3.0 + tau);
            let found = exp(-tau / mu) + down[i] / mu;
            assert!((found - through).abs() < 0.03, "{elevation}, τ = {tau}: {found}, {through}");
        }
    }
}

#[test]
fn a_clear_day_has_measured_illuminances() {
    // Illuminances of clear days with the sun 60 degrees high: some 90 to 105 kilolux from the sun on a surface that
    // faces it, 10 to 17 from the sky.
    let colors = Colors::new();
    let klux = |v: f32| f64::from(v) / SUN_ABOVE_AIR * 133.0;
    let high = sky(1.0, 1.0, 1.0, 60.0, 0.2);
    let sun = klux(colors.color(&high.sunlight(0.0, radians(30.0))).luminance());
    let environment = klux(colors.color(&diffuse(&high)).luminance());
    assert!((90.0..112.0).contains(&sun), "{sun}");
    assert!((9.0..18.0).contains(&environment), "{environment}");
    // The zenith is blue, the horizon paler and brighter, the low sun orange.
    let zenith = colors.color(&radiance(&high, 1.0, 1.0));
    let horizon = colors.color(&radiance(&high, 0.03, -1.0));
    assert!(zenith.b > 1.6 * zenith.r && zenith.b < 5.0 * zenith.r, "{zenith:?}");
    assert!(horizon.b / horizon.r < 0.7 * zenith.b / zenith.r, "{horizon:?}");
    assert!(horizon.luminance() > 2.0 * zenith.luminance(), "{horizon:?} {zenith:?}");
    let low = sky(1.0, 1.0, 1.0, 2.0, 0.2);
    let sun = colors.color(&low.sunlight(0.0, radians(88.0)));
    assert!(sun.r > 2.0 * sun.g && sun.g > 2.0 * sun.b, "{sun:?}");
    // Haze attenuates the sun and brightens the sky around it.
    let hazy = sky(1.0, 6.0, 1.0, 60.0, 0.2);
    let near = |s: &Sky| colors.color(&radiance(s, cos(radians(35.0)), 1.0)).luminance();
    assert!(near(&hazy) > 2.0 * near(&high));
    assert!(hazy.sunlight(0.0, radians(30.0))[5] < 0.8 * high.sunlight(0.0, radians(30.0))[5]);
}

#[test]
fn twilight_fades_and_ozone_keeps_it_blue() {
    let colors = Colors::new();
    let zenith =
        |elevation: f64, ozone: f64| colors.color(&radiance(&sky(1.0, 1.0, ozone, elevation, 0.3), 1.0, 1.0));
    let mut before = f32::INFINITY;
    for elevation in [20.0, 5.0, 0.0, -2.0, -4.0, -6.0, -9.0] {
        let now = zenith(elevation, 1.0).luminance();
        assert!(now < before && now > 0.0, "{elevation}: {now}");
        before = now;
    }
    // At the end of civil twilight the light is about a thousandth of that at sunset, within half an order of
    // magnitude.
    let fraction = zenith(-6.0, 1.0).luminance() / zenith(0.0, 1.0).luminance();
    assert!((3e-4..3e-2).contains(&fraction), "{fraction}");
    let (with, without) = (zenith(-4.0, 1.0), zenith(-4.0, 0.0));
    assert!(with.b / with.r > 1.3 * without.b / without.r, "{with:?} {without:?}");
}

#[test]
fn the_sun_is_where_the_sky_is_brightest() {
    let (environment, sun) = desc().prepare(&setting(true, true)).unwrap();
    let sun = sun.unwrap();
    let d = sun.to_light;
    assert!((d - DVec3::new(-0.579, 0.574, 0.579)).length() < 1e-2, "{d}");
    let mirrored = [DVec3::new(-d.x, d.y, d.z), DVec3::new(d.x, d.y, -d.z), DVec3::new(-d.x, d.y, -d.z)];
    for other in mirrored {
        assert!(environment.radiance(d).luminance() > 1.5 * environment.radiance(other).luminance());
    }
    let same = SkyDesc { direction: Some(7.0 * d), elevation: -50.0, azimuth: 1.0, ..desc() };
    let (again, its_sun) = same.prepare(&setting(true, true)).unwrap();
    assert!((its_sun.unwrap().to_light - d).length() < 1e-12);
    for look in [DVec3::Y, DVec3::X, DVec3::new(0.3, 0.4, -1.0)] {
        assert!((again.radiance(look).g / environment.radiance(look).g - 1.0).abs() < 1e-4);
    }
    // Rotated by 90 degrees, with either way to give the direction.
    for mut turned in [desc(), SkyDesc { direction: Some(d), ..desc() }] {
        turned.turn(90.0);
        let (_, sun) = turned.prepare(&setting(true, true)).unwrap();
        assert!((sun.unwrap().to_light - DVec3::new(d.z, d.y, -d.x)).length() < 1e-12);
    }
    // Below the horizon lies the ground; a quarter of the sunlight above the atmosphere is the unit.
    let ground = environment.radiance(DVec3::NEG_Y);
    assert_eq!(ground, environment.radiance(DVec3::new(0.3, -0.5, 0.1)));
    let expected = 0.3 / PI as f32 * (sun.intensity.g * d.y as f32);
    assert!(ground.g > expected && ground.g < 1.5 * expected, "{ground:?}");
    // For the classic integrator 1/π of the sun, as of the sky.
    let (_, classic) = desc().prepare(&setting(false, false)).unwrap();
    assert!((classic.unwrap().intensity.g * PI as f32 / sun.intensity.g - 1.0).abs() < 1e-6);
}

#[test]
fn extreme_skies_are_finite() {
    let kinds = [
        SkyDesc { elevation: 90.0, ..desc() },
        SkyDesc { elevation: -90.0, ..desc() },
        SkyDesc { elevation: -0.1, sun_angle: 0.0, ..desc() },
        SkyDesc { air: 0.0, dust: 0.0, ozone: 0.0, ..desc() },
        SkyDesc { air: 10.0, dust: 100.0, ozone: 10.0, elevation: 3.0, ..desc() },
        SkyDesc { ground_albedo: Spectrum::WHITE, azimuth: -1e9, ..desc() },
        SkyDesc { direction: Some(DVec3::NEG_Y), ..desc() },
    ];
    for kind in kinds {
        let (environment, sun) = kind.prepare(&setting(true, true)).unwrap();
        assert_eq!(environment.invalid_pixels(), 0, "{kind:?}");
        assert!(sun.is_none_or(|sun| sun.intensity.is_finite()));
        for d in [DVec3::Y, DVec3::X, DVec3::NEG_Y, DVec3::new(0.1, 0.01, -1.0)] {
            let light = environment.radiance(d);
            assert!(light.is_finite() && light.luminance() >= 0.0, "{kind:?} {light:?}");
        }
    }
    // Night has no sun; without air the sky is black and the sun white.
    let night = SkyDesc { elevation: -30.0, ..desc() }.prepare(&setting(true, true)).unwrap();
    assert!(night.1.is_none());
    let space = SkyDesc { air: 0.0, dust: 0.0, ozone: 0.0, ..desc() }.prepare(&setting(true, true)).unwrap();
    assert_eq!(space.0.radiance(DVec3::Y), Spectrum::BLACK);
    assert!((f64::from(space.1.unwrap().intensity.luminance()) - SUN_ABOVE_AIR).abs() < 0.01);
    assert!(SkyDesc { direction: Some(DVec3::ZERO), ..desc() }.prepare(&setting(true, true)).is_err());
}

#[test]
fn an_edit_that_keeps_the_day_keeps_its_image() {
    let (first, _) = desc().prepare(&setting(true, true)).unwrap();
    let before = [Light::Environment(first)];
    let again = |desc: SkyDesc, compensated: bool| {
        let kept = desc.prepare(&LightSetting { before: &before, ..setting(compensated, true) }).unwrap();
        let fresh = desc.prepare(&LightSetting { threads: 1, ..setting(compensated, true) }).unwrap();
        for direction in [DVec3::new(0.3, 0.5, -0.2), DVec3::new(-1.0, 0.1, 0.4), DVec3::NEG_Y] {
            assert_eq!(kept.0.radiance(direction), fresh.0.radiance(direction));
            assert_eq!(kept.0.pdf(direction), fresh.0.pdf(direction));
        }
        assert_eq!(format!("{:?}", kept.1), format!("{:?}", fresh.1));
        let Light::Environment(first) = &before[0] else { unreachable!() };
        kept.0.shares_image(first)
    };
    assert!(again(
        SkyDesc { azimuth: 20.0, strength: 2.0, sun_strength: Spectrum::grey(0.5), ..desc() },
        true
    ));
    assert!(!again(SkyDesc { elevation: 12.0, ..desc() }, true));
    assert!(again(SkyDesc { sky_strength: Spectrum::new(0.5, 1.0, 2.0), ..desc() }, true));
    assert!(!again(SkyDesc { dust: 2.0, ..desc() }, true));
    assert!(!again(SkyDesc { ground: false, ..desc() }, true));
    assert!(!again(desc(), false));
}

#[test]
fn without_ground_it_is_black_below_the_horizon() {
    let seen = |ground: bool, direction: DVec3| {
        let (light, _) = SkyDesc { ground, ..desc() }.prepare(&setting(true, true)).unwrap();
        light.radiance(direction)
    };
    let (up, down) = (DVec3::new(0.3, 0.5, -0.2), DVec3::new(0.3, -0.5, 0.2));
    assert!(seen(false, down).is_black() && seen(true, down).luminance() > 0.01);
    assert_eq!(seen(false, up), seen(true, up));
}

#[test]
fn another_zenith_turns_everything() {
    let up = DVec3::new(0.3, 0.2, 0.9).normalize();
    let to_sky = crate::light::environment::tilt(up).unwrap();
    let level = desc();
    let sun = |desc: &SkyDesc| {
        let (sky, sun) = desc.prepare(&setting(false, true)).unwrap();
        (sky, sun.unwrap().illuminate().to_light.normalize())
    };
    let (upright, sun_upright) = sun(&level);
    let (tilted, sun_tilted) = sun(&SkyDesc { up, ..level.clone() });
    assert!((to_sky * sun_upright - sun_tilted).length() < 0.02, "{sun_tilted}");
    for d in [DVec3::new(0.1, 0.9, 0.2), DVec3::new(0.5, 0.3, -0.2), DVec3::new(-1.0, -0.4, 0.6)] {
        let (a, b) = (upright.radiance(d), tilted.radiance(to_sky * d));
        assert!((a - b).map(f32::abs).max_component() < 1e-4 * a.max_component(), "{d}: {a:?} {b:?}");
    }
    // A direction is one in the world, whatever the zenith.
    let direction = DVec3::new(0.1, 0.5, 0.8);
    let (_, towards) = sun(&SkyDesc { up, direction: Some(direction), ..level.clone() });
    assert!((towards - direction.normalize()).length() < 0.02, "{towards}");
    // Turning the whole sky turns the sun with it.
    let mut turned = SkyDesc { up, ..level };
    turned.turn(90.0);
    let (_, after) = sun(&turned);
    let expected = DVec3::new(sun_tilted.z, sun_tilted.y, -sun_tilted.x);
    assert!((after - expected).length() < 0.02, "{after} {expected}");
}
