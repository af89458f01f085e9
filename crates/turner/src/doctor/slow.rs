//! Rules for slow rendering.

use std::collections::BTreeMap;

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, short};
use crate::description::ObjectContent;
use crate::film::{Antialias, Denoise};
use crate::integrator::IntegratorDesc;
use crate::schema::{MaterialId, Quality, Remedy};
use crate::shape::ShapeDesc;

fn find(severity: Severity, code: &'static str, weight: f64, what: String) -> Finding {
    Finding::new(Question::Slow, severity, code, weight, what)
}

pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    out.extend(layers(e));
    out.extend(long_paths(e));
    out.extend(trees(e));
    out.extend(costly_object(e));
    out.extend(dense_mesh(e));
    out.extend(film(e));
    out.extend(caustics(e));
    out.extend(shadow_catchers(e));
    out.extend(denoiser(e));
}

/// Many transparent layers, which rays pass without scattering.
fn layers(e: &Evidence<'_>) -> Option<Finding> {
    let paths = e.sum(|p| f64::from(p.samples)).max(1.0);
    let per_path = e.sum(|p| p.passed as f64) / paths;
    let fraction = e.sum(|p| p.passed as f64) / e.sum(|p| p.vertices as f64).max(1.0);
    if per_path < 4.0 || fraction < 0.4 {
        return None;
    }
    let mut by: BTreeMap<MaterialId, u64> = BTreeMap::new();
    for (m, n) in e.g.paths.iter().flatten().flat_map(|p| &p.holes) {
        *by.entry(*m).or_default() += n;
    }
    let (&material, _) = by.iter().max_by_key(|(m, n)| (**n, std::cmp::Reverse(**m)))?;
    let name = e.labels.material_label(material);
    let what = format!("each path passes {} transparent layers, most of them of {name}", short(per_path));
    let severity = if per_path > 8.0 { Severity::Warning } else { Severity::Note };
    Some(
        find(severity, "transparent-layers", if per_path > 16.0 { 0.95 } else { 0.7 }, what)
            .why(format!("each layer needs another ray, for shadow rays as well: {} of all surfaces on paths are only passed", percent(fraction)))
            .remedy("use `alpha_mode = \"mask\"` where opacity is 0 or 1, which needs no extra ray; merge layers, or lower `max_transparent`")
            .about(name.text)
            .measure("layers-per-path", per_path, "count")
            .measure("surfaces-passed", fraction, "fraction"),
    )
}

/// Paths with many bounces.
fn long_paths(e: &Evidence<'_>) -> Option<Finding> {
    let paths = e.sum(|p| f64::from(p.samples)).max(1.0);
    let length = e.sum(|p| (p.vertices - p.passed) as f64) / paths;
    let longest = e.g.paths.iter().flatten().map(|p| p.longest).max().unwrap_or(0);
    if length < 12.0 {
        return None;
    }
    let mut by: BTreeMap<MaterialId, u64> = BTreeMap::new();
    for (n, m) in e.g.paths.iter().flatten().flat_map(|p| p.by_primitive.values()) {
        *by.entry(*m).or_default() += n;
    }
    let (&material, &count) = by.iter().max_by_key(|(m, n)| (**n, std::cmp::Reverse(**m)))?;
    let fraction = count as f64 / e.sum(|p| p.vertices as f64).max(1.0);
    let name = e.labels.material_label(material);
    let what =
        format!("paths hit {} surfaces on average, {} of them of {name}", short(length), percent(fraction));
    let mut finding = find(if length > 24.0 { Severity::Warning } else { Severity::Note }, "long-paths", 0.7, what)
        .why(format!("the longest path of the probe has {longest}: surfaces that reflect or transmit nearly all light keep paths alive"))
        .remedy("lower `max_depth`, lower albedos near 1 to 0.8, or start Russian roulette earlier with `rr_start`")
        .set("integrator.max_depth", 8)
        .about(name.text)
        .measure("surfaces-per-path", length, "count")
        .measure("longest-path", f64::from(longest), "count")
        .measure("fraction-of-material", fraction, "fraction");
    if let IntegratorDesc::Path(p) = &e.scene.integrator
        && let Some(rr_start) = p.rr_start.filter(|start| *start > 16)
    {
        finding = finding.set("integrator.rr_start", 3).measure("rr-start", f64::from(rr_start), "count");
    }
    Some(finding)
}

/// Large ray trees of the classic integrator.
fn trees(e: &Evidence<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let Some(t) = e.g.trees.filter(|t| t.samples > 0) else { return out };
    let (rays, shadow) = (t.rays as f64 / t.samples as f64, t.shadow_rays as f64 / t.samples as f64);
    if shadow > 64.0 && shadow > 4.0 * rays {
        let what = format!("each sample traces {} shadow rays", short(shadow));
        let lights: u32 = e.scene.lights.iter().map(|l| l.samples()).sum();
        out.push(
            find(if shadow > 200.0 { Severity::Warning } else { Severity::Note }, "shadow-rays", 0.8, what)
                .why(format!("each surface traces shadow rays to {lights} points on lights: `samples` for each light with an extent"))
                .remedy("lower `samples` of these lights and take more samples per pixel, or use \"path\", which takes one point per surface")
                .set("integrator.type", "path")
                .measure("shadow-rays-per-sample", shadow, "count")
                .measure("light-samples", f64::from(lights), "count"),
        );
    }
    if rays > 64.0 || t.dropped > 0 {
        let what = format!("a sample traces {} rays on average, down to depth {}", short(rays), t.depth);
        out.push(
            find(
                if t.dropped > 0 || rays > 500.0 { Severity::Warning } else { Severity::Note },
                "ray-trees",
                0.8,
                what,
            )
            .why("at glass each ray splits in two, so their number doubles with each bounce")
            .remedy("lower `max_depth`")
            .set("integrator.max_depth", 5)
            .measure("rays-per-sample", rays, "count")
            .measure("rays-dropped", t.dropped as f64, "count"),
        );
    }
    out
}

/// An object that is expensive to intersect.
fn costly_object(e: &Evidence<'_>) -> Option<Finding> {
    let mut by: BTreeMap<u32, (u64, u64, &'static str)> = BTreeMap::new();
    let (mut all, mut rays) = (0, 0);
    for first_hit in e.g.first_hits.iter().flatten() {
        all += first_hit.steps;
        rays += 1;
        if let Some(hit) = first_hit.hit {
            let entry = by.entry(hit.primitive).or_insert((0, 0, hit.shape));
            (entry.0, entry.1) = (entry.0 + first_hit.steps, entry.1 + 1);
        }
    }
    let mean = all as f64 / f64::from(rays.max(1));
    if mean < 150.0 {
        return None;
    }
    let (&primitive, &(steps, count, shape)) =
        by.iter().max_by_key(|(i, (n, ..))| (*n, std::cmp::Reverse(**i)))?;
    let (fraction, pixels) = (steps as f64 / all.max(1) as f64, count as f64 / f64::from(rays.max(1)));
    let name = e.labels.object_label(primitive, shape);
    let what = format!(
        "a camera ray tests {} boxes and shapes; rays to {name} take {} of that",
        short(mean),
        percent(fraction)
    );
    Some(
        find(Severity::Note, "costly-traversal", 0.6, what)
            .why(format!("it fills {} of the picture. Objects with overlapping boxes, long thin triangles and many shapes in one place cost most; the integrator \"cost\" shows where", percent(pixels)))
            .remedy("use instances of a group instead of one large object, or build the BVHs with higher quality")
            .or(Remedy::TreeQuality(Quality::High))
            .about(name.text)
            .measure("steps-per-ray", mean, "count")
            .measure("fraction-of-steps", fraction, "fraction")
            .measure("fraction-of-picture", pixels, "fraction"),
    )
}

/// Many more triangles than pixels.
fn dense_mesh(e: &Evidence<'_>) -> Option<Finding> {
    let pixels = f64::from(e.scene.film().width) * f64::from(e.scene.film().height);
    let triangles = e.scene.stats.triangles as f64;
    if triangles < 100_000.0 || triangles < 8.0 * pixels {
        return None;
    }
    let objects = e.desc.objects.iter().chain(e.desc.groups.iter().flat_map(|g| &g.value.objects));
    let meshes = objects.filter(|o| !o.hidden).filter_map(|o| match &o.content {
        ObjectContent::Shape(ShapeDesc::Mesh(m)) => {
            Some((o.name.clone(), e.desc.meshes.get(m.mesh.index())?))
        }
        _ => None,
    });
    let (name, mesh) = meshes.max_by_key(|(_, m)| m.data.triangles.len())?;
    let name = name.unwrap_or_else(|| mesh.uri.clone());
    let own = mesh.data.triangles.len() as f64;
    let what = format!(
        "{} triangles for {} pixels: {} per pixel, {} of them in \"{name}\"",
        short(triangles),
        short(pixels),
        short(triangles / pixels),
        percent(own / triangles)
    );
    Some(
        find(if triangles > 20.0 * pixels { Severity::Warning } else { Severity::Note }, "dense-mesh", 0.75, what)
            .why(format!("most of them are smaller than a pixel. They take {} of memory and time to load, and rays miss the CPU caches", crate::doctor::finding::short(e.scene.stats.mesh_bytes as f64 / 1e6) + " MB"))
            .remedy("simplify the mesh in the program that it comes from, or bake the detail into a normal map")
            .about(name)
            .measure("triangles", triangles, "count")
            .measure("triangles-per-pixel", triangles / pixels, "ratio")
            .measure("mesh-bytes", e.scene.stats.mesh_bytes as f64, "bytes"),
    )
}

/// More samples than needed, and other expensive film settings.
fn film(e: &Evidence<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let film = e.scene.film();
    let (pixels, samples) = (f64::from(film.width) * f64::from(film.height), f64::from(e.samples()));
    let enough = (e.variance / 1e-4).ceil().max(16.0);
    if samples > 1024.0 && samples > 8.0 * enough && !e.g.paths.is_empty() {
        let what =
            format!("{samples} samples per pixel are {} times as many as needed", short(samples / enough));
        out.push(
            find(Severity::Warning, "samples-excessive", 0.9, what)
                .why(format!(
                    "with {} samples the error is 0.0001 (relMSE), which is invisible",
                    short(enough)
                ))
                .remedy("lower `samples` of [film]")
                .set("film.samples", enough as u32)
                .measure("samples", samples, "count")
                .measure("samples-for-0.0001", enough, "count"),
        );
    } else if samples > 4096.0 && e.g.paths.is_empty() && !e.scene.integrator.capabilities().debug {
        let what = format!("{samples} samples per pixel are many for \"{}\"", e.scene.integrator.type_name());
        out.push(
            find(Severity::Warning, "samples-excessive", 0.9, what)
                .why("its samples differ only at edges and in soft shadows")
                .remedy("lower `samples` of [film]")
                .set("film.samples", 64)
                .measure("samples", samples, "count"),
        );
    }
    if pixels * samples > 5e10 {
        let what = format!(
            "{} samples in all: {}x{} pixels of {samples}",
            short(pixels * samples),
            film.width,
            film.height
        );
        out.push(
            find(Severity::Warning, "picture-huge", 0.85, what)
                .why("at a million samples per second that takes over half a day")
                .remedy("lower `width` and `height`, or `samples`")
                .or(Remedy::set("film.width", film.width.div_ceil(4))
                    .and("film.height", film.height.div_ceil(4)))
                .measure("samples-total", pixels * samples, "count"),
        );
    }
    if film.antialias == Antialias::Adaptive && film.max_subdivisions > 4 && film.threshold < 0.01 {
        let most = crate::math::elementary::pow(4.0, f64::from(film.max_subdivisions));
        let what = format!("adaptive anti-aliasing divides a pixel into up to {} squares", short(most));
        out.push(
            find(Severity::Warning, "adaptive-too-fine", 0.7, what)
                .why(format!("a difference of {} is enough to subdivide further", short(film.threshold)))
                .remedy("raise `threshold` of [film] to 0.05, or lower `max_subdivisions` to 3")
                .set("film.max_subdivisions", 3)
                .set("film.threshold", 0.05)
                .measure("squares-per-pixel", most, "count"),
        );
    }
    out
}

/// Light paths that `caustics = "auto"` chose and that take most of the time.
fn caustics(e: &Evidence<'_>) -> Option<Finding> {
    let [work, contribution, light_paths_only] = crate::lint::expensive_caustics(e.desc, &e.scene.prepared)?;
    let what = format!("light paths for caustics multiply the work per sample by about {}", short(work));
    let loss = match light_paths_only {
        a if a < 5e-4 => format!("caustics, {} of the light, then have more noise", percent(contribution)),
        _ => format!(
            "{} of the light then is missing, because only light paths find it",
            percent(light_paths_only)
        ),
    };
    let severity = if light_paths_only < 0.01 || work > 4.0 { Severity::Warning } else { Severity::Note };
    Some(
        find(severity, "caustics-costly", 0.9, what)
            .why(format!("`caustics = \"auto\"` traces light paths because they find caustics: {} of the light of the picture", percent(contribution)))
            .remedy(format!("switch them off with `caustics = \"off\"` in [integrator]: {loss}"))
            .set("integrator.caustics", "off")
            .measure("relative-time", work, "ratio")
            .measure("caustic-light", contribution, "fraction")
            .measure("light-lost-without-them", light_paths_only, "fraction"),
    )
}

/// Shadow catchers, such as the floor of the default studio: each of their samples takes two shadow rays.
fn shadow_catchers(e: &Evidence<'_>) -> Option<Finding> {
    let rays: Vec<_> = e.g.first_hits.iter().flatten().collect();
    let caught = rays.iter().filter(|first| first.hit.is_some_and(|hit| hit.catches_shadows)).count() as f64;
    let fraction = caught / rays.len().max(1) as f64;
    if fraction < 0.02 {
        return None;
    }
    let has_studio = e.desc.studio.is_some();
    let whose = if has_studio { "the floor of the studio" } else { "shadow catchers" };
    let what = format!("{whose}: {} of the camera rays take two shadow rays more", percent(fraction));
    let remedy = match has_studio {
        true => "leave the floor out with `ground = false` in [studio]: the model then has no shadow",
        false => "hide the shadow catchers, or make them smaller",
    };
    let finding = find(Severity::Note, "shadow-catcher-cost", 0.3, what)
        .why("each sample that meets a shadow catcher looks for its light twice and then continues behind it")
        .remedy(remedy)
        .measure("camera-rays", fraction, "fraction");
    Some(if has_studio { finding.set("studio.ground", false) } else { finding })
}

/// The denoiser, which models have without asking.
fn denoiser(e: &Evidence<'_>) -> Option<Finding> {
    /// Seconds for a pixel on one thread, with its camera rays.
    const SECONDS: f64 = 1.6e-6;
    let film = &e.desc.film;
    if !matches!(film.denoise, Denoise::On) {
        return None;
    }
    let seconds = film.region().area() as f64 * SECONDS;
    let what = format!("the denoiser takes about {} s of processor time at the end", short(seconds));
    Some(
        find(Severity::Note, "denoiser-cost", 0.2, what)
            .why("it fits the light around every pixel, and traces up to two more camera rays per pixel for edges")
            .remedy("choose `denoise = \"fast\"` in [film], a tenth of the time, or `\"off\"`")
            .set("film.denoise", "fast")
            .measure("processor-seconds", seconds, "seconds"),
    )
}
