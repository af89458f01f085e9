//! The picture with some of its light only, or with other weights, without tracing anything again.

use super::Renderer;
use super::aovs::each;
use crate::color::Spectrum;
use crate::film::{Aov, Picture};

/// The layer of light that light paths bring.
const CAUSTICS: &str = "caustics";

impl Renderer {
    /// The names of the layers of light that [`Renderer::mixed`] can weight: "emission", "direct" and "indirect" if the film has
    /// these AOVs; `light.NAME` for each light group and `light.default` with the AOV "light_groups"; "caustics" if there
    /// are light paths; those of [`Aov::LOBES`]. See [`Renderer::light_layers_of`] for what adds up to the picture.
    pub fn light_layers(&self) -> Vec<String> {
        self.light_layers_of(&Aov::all().collect::<Vec<_>>())
    }

    /// Those of some AOVs. The picture is the sum of "caustics" and one of these sets: "emission", "direct" and "indirect";
    /// "emission" and [`Aov::LOBES`]; "light_groups".
    pub fn light_layers_of(&self, some: &[Aov]) -> Vec<String> {
        let aovs = &self.prepared.view.film.aovs;
        let of_light = aovs.iter().filter(|aov| aov.is_light() && some.contains(aov));
        let names = of_light.flat_map(|aov| aovs.channels_of(aov));
        let mut out: Vec<String> =
            names.filter_map(|name| Some(name.strip_suffix(".R")?.to_owned())).collect();
        out.retain(|name| name != CAUSTICS && !self.film.channel_values(&format!("{name}.R"), 1).is_empty());
        if self.prepared.integrator.light_paths() > 0 {
            out.push(CAUSTICS.to_owned());
        }
        out
    }

    /// The picture as the weighted sum of layers of light, by their names in [`Renderer::light_layers`]; layers that `mix` does
    /// not name are left out, names of no layer add nothing. With exposure and tone mapping of the film, without denoising.
    /// Coverage stays. `threads` of 0 uses all.
    pub fn mixed(&self, mix: &[(&str, Spectrum)], threads: usize) -> Picture {
        let desc = &self.prepared.view.film;
        let mut colors = vec![[0.0_f32; 3]; self.film.crop.area() as usize];
        for (layer, weight) in mix {
            if *layer == CAUSTICS {
                let light = each(&self.film, |x, y| self.film.light(desc, x, y));
                for (to, from) in colors.iter_mut().zip(light) {
                    *to = std::array::from_fn(|c| to[c] + from[c] * weight.to_array()[c]);
                }
                continue;
            }
            for (c, (channel, by)) in ["R", "G", "B"].iter().zip(weight.to_array()).enumerate() {
                let values = self.film.channel_values(&format!("{layer}.{channel}"), threads);
                colors.iter_mut().zip(values).for_each(|(to, v)| to[c] += v * by);
            }
        }
        let mut developed = self.film.developed(desc, threads);
        developed.recolor(&colors);
        developed.into_picture(threads)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::film::{Antialias, Aovs};
    use crate::integrator::{IntegratorDesc, PathDesc};
    use crate::light::{LightDesc, PointDesc};
    use crate::math::DVec3;
    use crate::render::PassOptions;
    use crate::schema::PrepareOptions;
    use crate::shape::{BoxDesc, ShapeDesc, SphereDesc};
    use crate::{ObjectDesc, SceneDesc};

    #[test]
    fn the_layers_of_light_sum_to_the_picture() {
        let mut desc =
            SceneDesc { integrator: IntegratorDesc::Path(PathDesc::default()), ..SceneDesc::default() };
        (desc.film.width, desc.film.height) = (32, 24);
        (desc.film.antialias, desc.film.samples) = (Antialias::MonteCarlo, 4);
        desc.film.aovs = Aovs::new(&[Aov::Emission, Aov::Direct, Aov::Indirect]);
        let ball = SphereDesc { center: DVec3::new(0.0, 0.5, 0.0), radius: 0.5 };
        let (min, max) = (Some(DVec3::new(-3.0, -1.0, -3.0)), Some(DVec3::new(3.0, 0.0, 3.0)));
        let floor = BoxDesc { min, max, center: None, size: None };
        desc.objects = [ShapeDesc::Sphere(ball), ShapeDesc::Box(floor)].map(ObjectDesc::new).into();
        let light = PointDesc { position: DVec3::new(2.0, 4.0, 3.0), ..PointDesc::default() };
        desc.lights.push(LightDesc::Point(light).into());
        let mut renderer = Renderer::new(desc.prepare(&PrepareOptions::default()).unwrap()).unwrap();
        let options = PassOptions { threads: 1, cancel: &AtomicBool::new(false), progress: None };
        renderer.pass(u32::MAX, &options).unwrap();
        assert_eq!(renderer.light_layers(), ["emission", "direct", "indirect"]);
        let one = |layer| renderer.mixed(&[(layer, Spectrum::WHITE)], 1).linear;
        let parts = [one("emission"), one("direct"), one("indirect")];
        assert!(parts[1..].iter().all(|part| part.iter().any(|v| v[0] > 0.0)));
        for (i, pixel) in renderer.develop().linear.iter().enumerate() {
            for c in 0..3 {
                let sum: f32 = parts.iter().map(|part| part[i][c]).sum();
                assert!((sum - pixel[c]).abs() <= 1e-5 * pixel[c].max(1e-3), "{i}: {sum} {}", pixel[c]);
            }
            assert!(parts.iter().all(|part| part[i][3] == pixel[3]));
        }
        let red = renderer.mixed(&[("direct", Spectrum::new(2.0, 0.0, 0.0))], 1).linear;
        assert!(red.iter().zip(&parts[1]).all(|(a, b)| a[0] == 2.0 * b[0] && a[1] == 0.0));
        assert!(renderer.mixed(&[("nothing", Spectrum::WHITE)], 1).linear.iter().all(|v| v[0] == 0.0));
    }
}
