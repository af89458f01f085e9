//! All measurements of the probe, and sums of them that several rules need.

use std::collections::BTreeMap;

use super::Options;
use super::first_hits::{FirstHit, Hit, first_hits};
use super::grid::{Pixel, pixels};
use super::kind::{PathKind, Source};
use super::lights::{self, LightFacts};
use super::media::{self, Without};
use super::paths::{self, PixelPaths};
use super::picture::{PictureFacts, quantile};
use super::trees::{self, TreeFacts};
use super::trial::{self, Trial};
use crate::description::{Label, Labels, SceneDesc};
use crate::doctor::subject::Subject;
use crate::film::Antialias;
use crate::integrator::{IntegratorDesc, Prepared, RayStats};
use crate::math::DVec3;
use crate::scene::ListedEmitter;
use crate::schema::MaterialId;
use crate::schema::value::Span;

/// Samples per pixel for trials of changed settings.
const TRIAL_SAMPLES: u32 = 4;

/// The measurements of the probe.
pub(super) struct Gathered {
    pub(super) pixels: Vec<Pixel>,
    pub(super) first_hits: Vec<Option<FirstHit>>,
    pub(super) paths: Vec<Option<PixelPaths>>,
    pub(super) trees: Option<TreeFacts>,
    pub(super) lights: Vec<LightFacts>,
    /// The number of lights and emissive shapes, including those that were not measured.
    pub(super) emitters: usize,
    pub(super) colors: Vec<[f64; 3]>,
    /// Trials: a higher `max_depth`; no `clamp_indirect`; a higher `max_transparent`; `light_sampling = "both"`.
    pub(super) deeper: Option<Trial>,
    pub(super) unclamped: Option<Trial>,
    pub(super) transparent: Option<Trial>,
    pub(super) both_strategies: Option<Trial>,
    /// Trials without one medium or without the absorption of one transparent material.
    pub(super) without: Vec<Without>,
    /// For the crop and for the complete picture: a high quantile of the luminance, and the fraction of rays that hit
    /// something.
    pub(super) crop: Option<[(f64, f64); 2]>,
    /// The mean luminance that light paths add to the picture, if the integrator traces them. All other measurements
    /// exclude light paths.
    pub(super) by_light_paths: Option<f64>,
    /// Whether all pixels were probed within the time limit.
    pub(super) complete: bool,
}

/// Runs the probe. Changes the film and the integrator of the subject.
pub(super) fn gather(scene: &mut Subject, options: &Options<'_>) -> Gathered {
    let by_light_paths = light_by_paths(&scene.prepared);
    let stop = options.stop;
    let film = scene.film().clone();
    let physical = scene.integrator.capabilities().physical;
    let whole = [0, 0, film.width, film.height];
    let crop = film.crop.filter(|crop| *crop != whole);
    scene.film_mut().crop = None;
    scene.film_mut().auto_exposure = false;
    // Switches off light paths and shared paths, so that camera paths are independent.
    scene.set_integrator(scene.integrator.clone());
    match (physical, film.antialias) {
        (true, _) => {
            let film = scene.film_mut();
            (film.antialias, film.samples) = (Antialias::MonteCarlo, options.samples.max(TRIAL_SAMPLES));
        }
        (false, Antialias::Adaptive | Antialias::Mean) => scene.film_mut().antialias = Antialias::None,
        (false, _) => {}
    }
    let samples = scene.film().samples_per_pixel().min(TRIAL_SAMPLES);
    let rect = crop.unwrap_or(whole);
    let (pixels, _) = pixels(rect, options.pixels);
    let mut g = Gathered {
        first_hits: first_hits(scene, &pixels, options),
        paths: Vec::new(),
        trees: None,
        lights: Vec::new(),
        emitters: 0,
        colors: Vec::new(),
        deeper: None,
        unclamped: None,
        transparent: None,
        both_strategies: None,
        without: Vec::new(),
        crop: crop.map(|crop| crop_facts(scene, crop, options)),
        by_light_paths,
        complete: true,
        pixels,
    };
    if scene.integrator.capabilities().debug {
        return g;
    }
    g.emitters = scene.emitter_list().len();
    if physical {
        let exposure = crate::math::elementary::pow(2.0, film.exposure);
        let samples = samples_in_budget(scene, &mut g, options, stop);
        g.paths = paths::trace(scene, &g.pixels, samples, exposure, options, stop);
        g.complete = g.paths.iter().all(Option::is_some);
        let color = |p: &Option<PixelPaths>| p.as_ref().map_or([f64::NAN; 3], |p| p.color);
        g.colors = g.paths.iter().map(color).collect();
    } else {
        g.trees = Some(trees::of(scene, &g.pixels, options));
        g.colors = colors(scene, &g.pixels, samples, options);
    }
    let points = points(&g);
    g.lights = lights::measure(scene, &points, options);
    if !stop() {
        try_changes(scene, &mut g, samples, options);
    }
    if physical && !stop() {
        g.without = media::try_without(scene, &g.pixels, samples, options);
    }
    g
}

/// The mean luminance that light paths add to the picture, if the integrator traces them.
fn light_by_paths(p: &Prepared) -> Option<f64> {
    const PATHS: u64 = 16384;
    let mut tracer = p.integrator.light_tracer(&p.scene, &p.view)?;
    let mut splats = Vec::new();
    for batch in 0..4 {
        let paths = batch * PATHS / 4..(batch + 1) * PATHS / 4;
        tracer.trace(paths, &|| false, &mut splats, &mut RayStats::default());
    }
    let light: f64 = splats.iter().map(|s| f64::from(s.color.luminance())).filter(|v| v.is_finite()).sum();
    Some(light / (PATHS as f64 * f64::from(p.view.film.width) * f64::from(p.view.film.height)))
}

/// The number of samples per pixel within the work budget, estimated from a few pixels. If paths are very long, pixels
/// are dropped as well.
fn samples_in_budget(
    scene: &Subject,
    g: &mut Gathered,
    options: &Options<'_>,
    stop: &(dyn Fn() -> bool + Sync),
) -> u32 {
    /// The budget in vertices and shadow casters: about two seconds on one core.
    const MAX: f64 = 800_000.0;
    const MIN_SAMPLES: f64 = 4.0;
    let few: Vec<Pixel> = g.pixels.iter().copied().step_by(g.pixels.len().div_ceil(32).max(1)).collect();
    let pilot = paths::trace(scene, &few, 1, 1.0, options, stop);
    let work: u64 = pilot.iter().flatten().map(|p| p.work).sum();
    let each = work as f64 / few.len().max(1) as f64;
    let samples = MAX / (each.max(1.0) * g.pixels.len().max(1) as f64);
    if samples < MIN_SAMPLES {
        let step = (MIN_SAMPLES / samples).ceil() as usize;
        let mut kept = (0..).map(|i: usize| i.is_multiple_of(step));
        g.pixels.retain(|_| kept.next() == Some(true));
        let mut kept = (0..).map(|i: usize| i.is_multiple_of(step));
        g.first_hits.retain(|_| kept.next() == Some(true));
    }
    (samples.max(MIN_SAMPLES) as u32).min(options.samples).max(2)
}

/// Mean colours of pixels.
fn colors(scene: &Subject, pixels: &[Pixel], samples: u32, options: &Options<'_>) -> Vec<[f64; 3]> {
    let of = |pixel: &Pixel| {
        let mut sum = [0.0; 3];
        for i in 0..samples {
            let color = crate::render::sample(&scene.prepared, pixel.x, pixel.y, i)
                .map_or([f32::NAN; 3], |r| r.color.to_array());
            for (s, v) in sum.iter_mut().zip(color) {
                *s += f64::from(v);
            }
        }
        sum.map(|s| s / f64::from(samples.max(1)))
    };
    let colors = super::threads::map(pixels, options.threads, &|| false, of);
    colors.into_iter().map(|c| c.unwrap_or([f64::NAN; 3])).collect()
}

/// For the crop and for the complete picture: the 90th percentile of the luminance of a few pixels, and the fraction of
/// their rays that hit something.
fn crop_facts(scene: &Subject, crop: [u32; 4], options: &Options<'_>) -> [(f64, f64); 2] {
    [crop, [0, 0, scene.film().width, scene.film().height]].map(|rect| {
        let (pixels, _) = pixels(rect, 64);
        let light = trial::mean_luminances(scene, &pixels, 1, options);
        let hits = first_hits(scene, &pixels, options).iter().flatten().filter(|s| s.hit.is_some()).count();
        (quantile(light, 0.9), hits as f64 / pixels.len().max(1) as f64)
    })
}

/// Surface points at which lights can be sampled, with the normal on the visible side.
fn points(g: &Gathered) -> Vec<(DVec3, DVec3)> {
    let of_paths = g.paths.iter().flatten().flat_map(|p| p.points.iter().take(2).copied());
    let points: Vec<_> = of_paths.collect();
    if !points.is_empty() {
        return points;
    }
    g.first_hits.iter().flatten().filter_map(|s| s.hit).map(|m| (m.p, m.n)).collect()
}

fn try_changes(scene: &mut Subject, g: &mut Gathered, samples: u32, options: &Options<'_>) {
    let own = scene.integrator.clone();
    let ended = |word: &str| g.paths.iter().flatten().filter_map(|p| p.ends.get(word)).sum::<u32>();
    let cut: u32 = g.paths.iter().flatten().map(|p| p.cut).sum();
    let transparency = ended("transparency");
    let mut before = None;
    let mut change = |scene: &mut Subject, to: IntegratorDesc| {
        let before = before.get_or_insert_with(|| trial::mean_luminances(scene, &g.pixels, samples, options));
        scene.set_integrator(to);
        let trial = trial::compare(before, &trial::mean_luminances(scene, &g.pixels, samples, options));
        scene.set_integrator(own.clone());
        trial
    };
    match own.clone() {
        IntegratorDesc::Path(mut p) => {
            let first = p.clone();
            if cut > 0 {
                p.max_depth = p.max_depth.max(4).saturating_mul(4).min(64).max(p.max_depth);
                (p.max_diffuse, p.max_glossy, p.max_transmission) = (None, None, None);
                g.deeper = Some(change(scene, IntegratorDesc::Path(p)));
            }
            p = first.clone();
            if p.clamp_indirect > 0.0 {
                p.clamp_indirect = 0.0;
                g.unclamped = Some(change(scene, IntegratorDesc::Path(p)));
            }
            p = first.clone();
            if transparency > 0 {
                p.max_transparent = p.max_transparent.max(16).saturating_mul(16).min(4096);
                g.transparent = Some(change(scene, IntegratorDesc::Path(p)));
            }
            p = first;
            if p.light_sampling != crate::integrator::LightSampling::Both {
                p.light_sampling = crate::integrator::LightSampling::Both;
                g.both_strategies = Some(change(scene, IntegratorDesc::Path(p)));
            }
        }
        IntegratorDesc::Direct(mut d) if cut > 0 => {
            d.max_depth = d.max_depth.max(4).saturating_mul(4).min(64);
            g.deeper = Some(change(scene, IntegratorDesc::Direct(d)));
        }
        IntegratorDesc::Classic(mut c) if g.trees.is_some_and(|t| t.cut > 0) => {
            c.max_depth = c.max_depth.max(3).saturating_mul(4).min(24);
            g.deeper = Some(change(scene, IntegratorDesc::Classic(c)));
        }
        _ => {}
    }
}

/// The measurements with sums of them.
pub(super) struct Evidence<'a> {
    pub(super) scene: &'a Subject,
    pub(super) desc: &'a SceneDesc,
    pub(super) labels: Labels<'a>,
    pub(super) g: Gathered,
    pub(super) picture: PictureFacts,
    /// The 95th percentile of the displayed brightness of pixels that show a non-emissive surface.
    pub(super) objects_shown: f64,
    /// The 98th percentile of the displayed brightness of all pixels.
    pub(super) all_shown: f64,
    /// The fraction of camera rays that hit something.
    pub(super) hit_fraction: f64,
    /// The relative variance of one sample, with the effect of stratification; mean over the pixels.
    pub(super) variance: f64,
    /// Light, variance, and variance of BSDF-sampled light, by kind, by source, and by kind and material.
    pub(super) by_kind: BTreeMap<PathKind, [f64; 3]>,
    pub(super) by_source: BTreeMap<Source, [f64; 3]>,
    pub(super) by_material: BTreeMap<(PathKind, Option<MaterialId>), [f64; 3]>,
    /// The same in total.
    pub(super) all: [f64; 3],
}

/// The label of a source without a name.
fn unnamed(text: &str) -> Label {
    Label { text: text.to_owned(), is_name: false }
}

impl<'a> Evidence<'a> {
    pub(super) fn new(scene: &'a Subject, desc: &'a SceneDesc, g: Gathered) -> Evidence<'a> {
        let picture = PictureFacts::new(scene.film(), &g.colors);
        let hit_at = |i: usize| g.first_hits.get(i).copied().flatten().and_then(|s| s.hit);
        let lit = |i: usize| hit_at(i).is_some_and(|m: Hit| !m.emits);
        let objects = picture.shown.iter().enumerate().filter(|(i, _)| lit(*i)).map(|(_, v)| *v);
        let objects_shown = quantile(objects, 0.95);
        let all_shown = quantile(picture.shown.iter().copied(), 0.98);
        let rays = g.first_hits.iter().flatten().count().max(1) as f64;
        let hit_fraction = g.first_hits.iter().flatten().filter(|s| s.hit.is_some()).count() as f64 / rays;
        let mut e = Evidence {
            scene,
            desc,
            labels: Labels { scene, desc },
            picture,
            objects_shown,
            all_shown,
            hit_fraction,
            variance: 0.0,
            by_kind: BTreeMap::new(),
            by_source: BTreeMap::new(),
            by_material: BTreeMap::new(),
            all: [0.0; 3],
            g,
        };
        let known = e.g.paths.iter().flatten().filter(|p| p.samples >= 2).count().max(1) as f64;
        for p in e.g.paths.iter().flatten().filter(|p| p.samples >= 2) {
            // With few samples stratification has little effect.
            let variance =
                if e.scene.film().samples_per_pixel() >= 8 { p.stratified_variance } else { p.variance };
            e.variance += variance / known;
            for (key, c) in &p.contributions {
                let values = [c.light, c.variance, c.bsdf_sampled];
                let sums = [
                    &mut e.all,
                    e.by_kind.entry(key.kind).or_default(),
                    e.by_source.entry(key.source).or_default(),
                    e.by_material.entry((key.kind, key.material)).or_default(),
                ];
                for sum in sums {
                    for (s, v) in sum.iter_mut().zip(values) {
                        *s += v;
                    }
                }
            }
        }
        if e.g.by_light_paths.is_some()
            && let Some(caustics) = e.by_kind.remove(&PathKind::Caustic)
        {
            // Light paths compute the caustics without this noise.
            let left = 1.0 - caustics[1] / e.all[1].max(f64::MIN_POSITIVE);
            e.variance *= left.clamp(0.0, 1.0);
        }
        e
    }

    /// Whether the picture is almost black.
    pub(super) fn is_black(&self) -> bool {
        /// A fraction of the largest value in the file: about 15 of 255.
        const BLACK: f64 = 0.06;
        if self.picture.shown.is_empty() {
            return false;
        }
        // The displayed values exclude the light of light paths.
        if self.g.by_light_paths.is_some_and(|light| light * self.picture.factor > BLACK * BLACK) {
            return false;
        }
        if self.hit_fraction > 0.02 { self.objects_shown < BLACK } else { self.all_shown < BLACK }
    }

    /// All first hits, with the index of their pixel.
    pub(super) fn hits(&self) -> impl Iterator<Item = (usize, &FirstHit, Hit)> + '_ {
        let first_hits = self.g.first_hits.iter().enumerate();
        first_hits.filter_map(|(i, s)| s.as_ref().and_then(|s| Some((i, s, s.hit?))))
    }

    /// The name of a source of light.
    pub(super) fn source(&self, source: Source) -> Label {
        match source {
            Source::Light(i) => self.labels.light_label(i),
            Source::Object(i) => self.labels.object_label(i, self.scene.primitive_shape(i)),
            Source::Background => unnamed("background"),
            Source::Ambient => unnamed("ambient light"),
            Source::Unknown => unnamed("sum of many lights"),
        }
    }

    /// The name of a light or an emissive shape.
    pub(super) fn emitter_name(&self, emitter: ListedEmitter) -> Label {
        match emitter {
            ListedEmitter::Light(i) => self.labels.light_label(i),
            ListedEmitter::Shape { primitive, .. } => {
                self.labels.object_label(primitive, self.scene.primitive_shape(primitive))
            }
        }
    }

    /// The position of a light's definition in the scene file.
    pub(super) fn span_of(&self, emitter: ListedEmitter) -> Option<Span> {
        let light = self.light_number(emitter)?;
        self.desc.lights.get(light as usize)?.span
    }

    /// The index of a light in the description, for the key path `light.N.…`.
    pub(super) fn light_number(&self, emitter: ListedEmitter) -> Option<u32> {
        match emitter {
            ListedEmitter::Light(i) => self.scene.light_sources.get(i as usize).copied().flatten(),
            ListedEmitter::Shape { .. } => None,
        }
    }

    /// The film's samples per pixel.
    pub(super) fn samples(&self) -> u32 {
        self.scene.film().samples_per_pixel()
    }

    /// A sum over all pixels.
    pub(super) fn sum(&self, f: impl Fn(&PixelPaths) -> f64) -> f64 {
        self.g.paths.iter().flatten().map(f).sum()
    }
}
