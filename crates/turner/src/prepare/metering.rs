//! Metering: the exposure for the light that falls on a scene, as a photographer reads it from an incident light meter.
//!
//! It depends on the light and the viewing direction alone, not on the materials: a black object stays black. A white
//! sphere in this light, seen by the camera, has the mean brightness [`WHITE`]; shadows are left out.

use crate::light::Light;
use crate::math::DVec3;
use crate::math::elementary::{ln, sin_cos};

/// The mean brightness of a white surface towards the camera.
const WHITE: f64 = 0.65;

/// The number of normals on the sphere.
const NORMALS: u32 = 96;

/// The exposure in stops, in tenths; `back` points towards the camera. `None` without an environment that emits light.
pub(super) fn exposure(lights: &[Light], back: DVec3) -> Option<f64> {
    let normals = normals();
    let mut brightness = vec![0.0; normals.len()];
    let mut has_environment = false;
    for light in lights {
        match light {
            Light::Environment(l) => {
                has_environment = true;
                for (sum, more) in brightness.iter_mut().zip(l.brightness(&normals)) {
                    *sum += more;
                }
            }
            Light::Directional(_) => {
                let Some(lit) = light.illuminate_at(DVec3::ZERO, [0.5; 2]) else { continue };
                let towards = lit.to_light.normalize_or_zero();
                let irradiance = f64::from(lit.intensity.luminance());
                for (sum, n) in brightness.iter_mut().zip(&normals) {
                    *sum += irradiance * towards.dot(*n).max(0.0) * std::f64::consts::FRAC_1_PI;
                }
            }
            Light::Point(_) | Light::Spot(_) | Light::Area(_) => {}
        }
    }
    let seen = normals.iter().map(|n| n.dot(back).max(0.0));
    let (sum, weight) = seen.zip(&brightness).fold((0.0, 0.0), |(s, w), (seen, b)| (s + seen * b, w + seen));
    let stops = ln(WHITE * weight / sum) * std::f64::consts::LOG2_E;
    // Tenths, so that `--exposure` can repeat it.
    (has_environment && sum > 0.0 && stops.is_finite())
        .then(|| (10.0 * stops).round().clamp(-160.0, 160.0) / 10.0)
}

/// Directions that cover the sphere evenly, on a spiral.
fn normals() -> Vec<DVec3> {
    /// The golden angle, radians.
    const TURN: f64 = 2.399_963_229_728_653;
    let direction = |i: u32| {
        let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(NORMALS);
        let (s, c) = sin_cos(TURN * f64::from(i));
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * c, y, r * s)
    };
    (0..NORMALS).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, Pixels};
    use crate::light::EnvironmentDesc;
    use crate::schema::Asset;
    use std::sync::Arc;

    fn environment(sample: impl Fn(u32, u32) -> f32, strength: f64) -> Light {
        let samples = (0..64 * 32).map(|i| sample(i % 64, i / 64)).collect();
        let image = Image { width: 64, height: 32, channels: 1, pixels: Pixels::F32(samples) };
        let images = [Asset { uri: String::new(), data: Arc::new(image) }];
        let file = Some(crate::schema::ImageId(0));
        let desc = EnvironmentDesc { file, strength, ..EnvironmentDesc::default() };
        Light::Environment(desc.prepare(&images, false).unwrap())
    }

    #[test]
    fn a_constant_environment_is_metered_exactly() {
        for (radiance, stops) in [(WHITE, 0.0), (WHITE / 8.0, 3.0), (WHITE * 4.0, -2.0)] {
            let found = exposure(&[environment(|_, _| 1.0, radiance)], DVec3::Z).unwrap();
            assert!((found - stops).abs() < 0.11, "{radiance}: {found}");
        }
        assert_eq!(exposure(&[environment(|_, _| 0.0, 1.0)], DVec3::Z), None);
        assert_eq!(exposure(&[], DVec3::Z), None);
    }

    #[test]
    fn what_the_sun_does_not_reach_gets_more_exposure() {
        // A sun along −z, the middle of the image.
        let sun = |x: u32, y: u32| if (31..33).contains(&x) && (15..17).contains(&y) { 500.0 } else { 0.2 };
        let towards = exposure(&[environment(sun, 1.0)], DVec3::NEG_Z).unwrap();
        let away = exposure(&[environment(sun, 1.0)], DVec3::Z).unwrap();
        assert!(away > towards + 1.0, "{towards} {away}");
    }
}
