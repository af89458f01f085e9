//! The sky of Hošek and Wilkie, with a sun: `sky`, `sun` and `sunsky`. Turner's own sky replaces it, with the same sun and
//! with the irradiances of a horizontal surface in Mitsuba 3.9.1.

use turner::color::Spectrum;
use turner::light::{LightDesc, SkyDesc};
use turner::math::DVec3;
use turner::math::elementary::asin;
use turner::schema::ColorSource;

use super::assembly::Assembly;
use super::params::Object;
use super::sky_strength::{dust, sky_strength, sun_strength};
use super::spectra::Role;
use super::sun;
use super::textures::{Surface, source};
use crate::scene_import::report::Fault;

/// Angular diameter of the sun, degrees.
const SUN: f64 = 0.5338;

/// The light of a `sky`, `sun` or `sunsky`.
pub(super) fn light(scene: &mut Assembly<'_>, object: &Object) -> Result<LightDesc, Fault> {
    let to_world = object.transform("to_world")?;
    let turbidity = object.float("turbidity")?.unwrap_or(3.0).clamp(1.0, 10.0);
    let albedo = match object.find("albedo") {
        Some((node, _)) => match source(scene, node, Role::Albedo, Surface::Same)? {
            ColorSource::Constant(c) => c,
            ColorSource::Texture(_) => Spectrum::grey(0.3),
        },
        None => Spectrum::grey(0.3),
    };
    let is_old = scene.document.is_old;
    let own = match object.vector("sun_direction")? {
        Some(own) => own,
        None => {
            let by_time = sun::direction(object, is_old)?;
            if (if is_old { by_time.y } else { by_time.z }) < 0.0 {
                let message = "the sun is below the horizon at this place and time";
                scene.report.doubtful(object.place, message);
            }
            by_time
        }
    };
    let scale = |name| object.float(name).map(|v| v.unwrap_or(1.0).clamp(0.0, 1e6));
    let (sky_scale, sun_scale) = (scale("sky_scale")?, scale("sun_scale")?);
    let strength = scale("scale")?;
    // The irradiance of the sun does not depend on its size.
    let sun_angle = match object.float("sun_aperture")? {
        Some(angle) => angle,
        None => SUN * object.float("sun_radius_scale")?.unwrap_or(1.0),
    };
    object.pass(&[
        "latitude",
        "longitude",
        "timezone",
        "year",
        "month",
        "day",
        "hour",
        "minute",
        "second",
        "complex_sun",
        "stretch",
        "resolution",
    ]);
    scene.report.approximated(object.place, "the sky of Mitsuba: Turner's sky model replaces it");
    // In Mitsuba 0.6 y is up and the direction is in world space; later versions have z up before the transform.
    let zenith = if is_old { DVec3::Y } else { DVec3::Z };
    let up = (to_world.matrix3 * zenith).try_normalize().unwrap_or(DVec3::Y);
    // Rounding must not tilt it.
    let up = if (up - DVec3::Y).length() < 1e-9 { DVec3::Y } else { up };
    let direction = if is_old { own } else { to_world.transform_vector3(own) };
    let elevation = direction.try_normalize().map_or(35.0, |d| asin(d.dot(up).clamp(-1.0, 1.0)).to_degrees());
    let [has_sky, has_sun] = [object.kind != "sun", object.kind != "sky" && sun_scale > 0.0];
    let only = |on: bool, strength: Spectrum| if on { strength } else { Spectrum::BLACK };
    Ok(LightDesc::Sky(SkyDesc {
        direction: Some(direction).filter(|d| d.length() > 0.0),
        up,
        dust: dust(turbidity),
        ground_albedo: albedo,
        ground: false,
        sun: has_sun,
        sun_angle: sun_angle.clamp(0.0, 90.0),
        sun_strength: sun_strength(turbidity, elevation) * sun_scale as f32,
        sky_strength: only(has_sky, sky_strength(turbidity, elevation, albedo) * sky_scale as f32),
        strength,
        ..SkyDesc::default()
    }))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use turner::{PassOptions, Renderer};

    use crate::assets::MemoryAssets;
    use crate::import::ImportOptions;

    /// The mean of a white plane under a sky whose zenith is its normal.
    fn plane(turbidity: f64, elevation: f64, albedo: f64, scales: &str) -> [f64; 3] {
        let [x, z] =
            [90.0 - elevation, elevation].map(|a: f64| turner::math::elementary::sin(a.to_radians()));
        let text = format!(
            "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>
             <sensor type='orthographic'><transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/>
               </transform><film type='hdrfilm'><integer name='width' value='16'/><integer name='height' value='16'/>
               <rfilter type='box'/></film><sampler type='independent'><integer name='sample_count' value='256'/>
             </sampler></sensor>
             <shape type='rectangle'><transform name='to_world'><scale value='10'/></transform>
               <bsdf type='diffuse'><rgb name='reflectance' value='1'/></bsdf></shape>
             <emitter type='sunsky'><float name='turbidity' value='{turbidity}'/>
               <vector name='sun_direction' x='{x}' y='0' z='{z}'/><rgb name='albedo' value='{albedo}'/>{scales}</emitter>
             </scene>"
        );
        let (assets, options) = (MemoryAssets::default(), ImportOptions::default());
        let scene = super::super::import_from(text.into_bytes(), "a.xml", &assets, &options).unwrap();
        let mut renderer = Renderer::new(scene.prepare(&Default::default()).unwrap()).unwrap();
        let never = AtomicBool::new(false);
        let options = PassOptions { threads: 2, cancel: &never, progress: None };
        renderer.pass(renderer.samples_per_pixel(), &options).unwrap();
        let picture = renderer.develop().linear;
        std::array::from_fn(|i| {
            picture.iter().map(|pixel| f64::from(pixel[i])).sum::<f64>() / picture.len() as f64
        })
    }

    /// Between the points of the tables; the figures are Mitsuba 3.9.1's, of the sky and of the sun.
    #[test]
    fn irradiances_are_those_of_mitsuba() {
        for (turbidity, elevation, albedo, sky, sun) in [
            (2.5, 27.0, 0.3, [0.0397, 0.0638, 0.1005], [0.2006, 0.1557, 0.1001]),
            (6.4, 12.0, 0.5, [0.0587, 0.0642, 0.0675], [0.0474, 0.0294, 0.0125]),
            (3.0, 46.0, 0.2, [0.0486, 0.0757, 0.1276], [0.3361, 0.2765, 0.2045]),
            (4.5, 72.0, 0.9, [0.106, 0.1517, 0.232], [0.4397, 0.3693, 0.2903]),
            (8.5, 40.0, 0.1, [0.1549, 0.1661, 0.174], [0.2163, 0.1702, 0.1244]),
        ] {
            for (without, expected, bound) in [("sun", sky, 0.06), ("sky", sun, 0.04)] {
                let scales = format!("<float name='{without}_scale' value='0'/>");
                let found = plane(turbidity, elevation, albedo, &scales);
                for i in 0..3 {
                    let ratio = found[i] / expected[i];
                    assert!(
                        (ratio - 1.0).abs() < bound,
                        "{turbidity} {elevation}: {found:?} for {expected:?}"
                    );
                }
            }
        }
        // Both, with factors of their own.
        let scales = "<float name='sky_scale' value='2'/><float name='sun_scale' value='0.5'/>";
        let both = plane(3.0, 46.0, 0.2, scales);
        let expected = [0.0972 + 0.168, 0.1514 + 0.1383, 0.2552 + 0.1023];
        assert!((0..3).all(|i| (both[i] / expected[i] - 1.0).abs() < 0.04), "{both:?}");
    }
}
