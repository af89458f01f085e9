//! Maps of the picture: cost, variance, and the kind of path with the most light.

use super::grid::Pixel;
use super::kind::PathKind;
use super::paths::{self, PixelPaths};
use super::{Options, trees};
use crate::color::{Spectrum, heat, srgb_encode};
use crate::description::SceneDesc;
use crate::doctor::subject::Subject;
use crate::film::Antialias;
use crate::integrator::Prepared;
use crate::math::elementary::ln;

/// An image of 8-bit display values (sRGB), row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Its content: `cost`, `variance` or `path-kind`.
    pub name: &'static str,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The colours.
    pub pixels: Vec<[u8; 3]>,
    /// The values of the first and the last heat colour, with their unit; `None` for `path-kind`.
    pub range: Option<([f64; 2], &'static str)>,
}

/// Maximum number of pixels of a map. Of larger pictures, pixels at even intervals are shown.
const MAX: f64 = 40_000.0;

/// The maps of a scene: all three with `path` and `direct`, the cost with `classic`, none with debug views. `desc` is
/// the description that the scene was prepared from.
pub fn maps(prepared: &Prepared, desc: &SceneDesc, options: &Options<'_>) -> Vec<Map> {
    let scene = &mut Subject { prepared: prepared.clone(), integrator: desc.integrator.clone() };
    scene.set_integrator(desc.integrator.clone());
    let film = scene.film().clone();
    scene.film_mut().crop = None;
    if scene.integrator.capabilities().physical {
        let film = scene.film_mut();
        (film.antialias, film.samples) = (Antialias::MonteCarlo, options.samples.max(2));
    } else {
        scene.film_mut().antialias = Antialias::None;
    }
    let [x0, y0, w, h] = film.crop.unwrap_or([0, 0, film.width, film.height]);
    let step = (f64::from(w) * f64::from(h) / MAX).sqrt().max(1.0);
    let size = |n: u32| ((f64::from(n) / step) as u32).max(1);
    let (width, height) = (size(w), size(h));
    let position = |i: u32, n: u32, all: u32| ((f64::from(i) + 0.5) / f64::from(n) * f64::from(all)) as u32;
    let pixels: Vec<Pixel> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| Pixel { x: x0 + position(x, width, w), y: y0 + position(y, height, h) })
        .collect();
    let map = |name, pixels: Vec<[u8; 3]>, range| Map { name, width, height, pixels, range };
    if scene.integrator.capabilities().physical {
        let samples = options.samples.min(8);
        let exposure = crate::math::elementary::pow(2.0, film.exposure);
        let paths = paths::trace(scene, &pixels, samples, exposure, options, &|| false);
        let of = |f: &dyn Fn(&PixelPaths) -> f64| -> Vec<f64> {
            paths.iter().map(|p| p.as_ref().map_or(0.0, f)).collect()
        };
        let per = |n: u64, p: &PixelPaths| n as f64 / f64::from(p.samples.max(1));
        let (cost, cost_range) = heat_map(&of(&|p| per(p.vertices + p.shadow_rays, p)), false);
        let (variance, variance_range) = heat_map(&of(&|p| p.variance), true);
        let kinds = paths.iter().map(|p| p.as_ref().and_then(strongest).map_or([0; 3], PathKind::color));
        vec![
            map("cost", cost, Some((cost_range, "rays per sample"))),
            map("variance", variance, Some((variance_range, "relative variance of a sample"))),
            map("path-kind", kinds.collect(), None),
        ]
    } else if scene.integrator.capabilities().debug {
        Vec::new()
    } else {
        let cost: Vec<f64> = pixels
            .iter()
            .map(|p| {
                let t = trees::of(scene, std::slice::from_ref(p), &Options { threads: 1, ..*options });
                (t.rays + t.shadow_rays) as f64
            })
            .collect();
        let (cost, range) = heat_map(&cost, false);
        vec![map("cost", cost, Some((range, "rays per sample")))]
    }
}

/// The kind of path with the most light in a pixel.
fn strongest(p: &PixelPaths) -> Option<PathKind> {
    let mut sums = [0.0; PathKind::ALL.len()];
    for (key, c) in &p.contributions {
        if let Some(i) = PathKind::ALL.iter().position(|k| *k == key.kind) {
            sums[i] += c.light;
        }
    }
    let (i, most) = sums.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)))?;
    (*most > 0.0).then(|| PathKind::ALL[i])
}

/// Values as heat colours, linear or logarithmic over four decades, with the values of the first and the last colour.
fn heat_map(values: &[f64], logarithmic: bool) -> (Vec<[u8; 3]>, [f64; 2]) {
    let most = super::picture::quantile(values.iter().copied(), 0.995).max(1e-12);
    let least = if logarithmic { most * 1e-4 } else { 0.0 };
    let position = |v: f64| {
        if logarithmic { ln((v / least).max(1.0)) / ln(most / least) } else { v / most }
    };
    let color = |v: &f64| {
        let Spectrum { r, g, b } = heat(position(*v).clamp(0.0, 1.0) as f32);
        [r, g, b].map(|v| (f64::from(srgb_encode(v)) * 255.0 + 0.5) as u8)
    };
    (values.iter().map(color).collect(), [least, most])
}
