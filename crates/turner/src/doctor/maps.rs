//! Maps of a picture: cost, variance, and the kind of path that carries most light.

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
    /// What it shows: `cost`, `variance`, `path-kind`.
    pub name: &'static str,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Colours.
    pub pixels: Vec<[u8; 3]>,
    /// The values of its darkest and its brightest colour, and their unit.
    pub range: Option<([f64; 2], &'static str)>,
}

/// Most pixels of a map: larger pictures are sampled at intervals.
const MOST: f64 = 40_000.0;

/// Maps of a scene. With "classic" there is only the cost; debug views have no maps.
/// `desc` is what it was prepared from.
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
    let step = (f64::from(w) * f64::from(h) / MOST).sqrt().max(1.0);
    let size = |n: u32| ((f64::from(n) / step) as u32).max(1);
    let (width, height) = (size(w), size(h));
    let place = |i: u32, n: u32, all: u32| ((f64::from(i) + 0.5) / f64::from(n) * f64::from(all)) as u32;
    let pixels: Vec<Pixel> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| Pixel { x: x0 + place(x, width, w), y: y0 + place(y, height, h) })
        .collect();
    let map = |name, pixels: Vec<[u8; 3]>, range| Map { name, width, height, pixels, range };
    if scene.integrator.capabilities().physical {
        let samples = options.samples.min(8);
        let exposure = crate::math::elementary::pow(2.0, film.exposure);
        let paths = paths::follow(scene, &pixels, samples, exposure, options, &|| false);
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

/// The kind of path that carries most of a pixel's light.
fn strongest(p: &PixelPaths) -> Option<PathKind> {
    let mut sums = [0.0; PathKind::ALL.len()];
    for (key, share) in &p.shares {
        if let Some(i) = PathKind::ALL.iter().position(|k| *k == key.kind) {
            sums[i] += share.light;
        }
    }
    let (i, most) = sums.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)))?;
    (*most > 0.0).then(|| PathKind::ALL[i])
}

/// Values as heat colours, linear or logarithmic over four decades, and the values of both ends.
fn heat_map(values: &[f64], logarithmic: bool) -> (Vec<[u8; 3]>, [f64; 2]) {
    let most = super::picture::quantile(values.iter().copied(), 0.995).max(1e-12);
    let least = if logarithmic { most * 1e-4 } else { 0.0 };
    let place = |v: f64| {
        if logarithmic { ln((v / least).max(1.0)) / ln(most / least) } else { v / most }
    };
    let color = |v: &f64| {
        let Spectrum { r, g, b } = heat(place(*v).clamp(0.0, 1.0) as f32);
        [r, g, b].map(|v| (f64::from(srgb_encode(v)) * 255.0 + 0.5) as u8)
    };
    (values.iter().map(color).collect(), [least, most])
}
