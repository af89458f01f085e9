//! Why it takes long: what costs what.

use std::collections::BTreeMap;

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, short};
use crate::description::ObjectContent;
use crate::film::Antialias;
use crate::integrator::IntegratorDesc;
use crate::schema::{MaterialId, Quality, Remedy};
use crate::shape::ShapeDesc;

fn find(severity: Severity, code: &'static str, weight: f64, what: String) -> Finding {
    Finding::new(Question::Slow, severity, code, weight, what)
}

pub(super) fn ask(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    out.extend(layers(e));
    out.extend(long_paths(e));
    out.extend(trees(e));
    out.extend(costly_object(e));
    out.extend(dense_mesh(e));
    out.extend(film(e));
}

/// Surfaces that rays pass straight.
fn layers(e: &Evidence<'_>) -> Option<Finding> {
    let paths = e.sum(|p| f64::from(p.samples)).max(1.0);
    let per_path = e.sum(|p| p.passed as f64) / paths;
    let share = e.sum(|p| p.passed as f64) / e.sum(|p| p.vertices as f64).max(1.0);
    if per_path < 4.0 || share < 0.4 {
        return None;
    }
    let mut by: BTreeMap<MaterialId, u64> = BTreeMap::new();
    for (m, n) in e.g.paths.iter().flatten().flat_map(|p| &p.holes) {
        *by.entry(*m).or_default() += n;
    }
    let (&material, _) = by.iter().max_by_key(|(m, n)| (**n, std::cmp::Reverse(**m)))?;
    let name = e.labels.material(material);
    let what = format!("paths pass {} transparent layers of \"{name}\" each", short(per_path));
    let severity = if per_path > 8.0 { Severity::Warning } else { Severity::Note };
    Some(
        find(severity, "transparent-layers", if per_path > 16.0 { 0.95 } else { 0.7 }, what)
            .why(format!("each layer is a search of its own, for shadow rays as well: {} of all surfaces met are only passed", percent(share)))
            .remedy("use `alpha_mode = \"mask\"` where opacity is 0 or 1, which costs no search; merge layers, or lower `max_transparent`")
            .about(name)
            .measure("layers-per-path", per_path, "count")
            .measure("surfaces-passed", share, "share"),
    )
}

/// Paths of many scatterings.
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
    let share = count as f64 / e.sum(|p| p.vertices as f64).max(1.0);
    let name = e.labels.material(material);
    let what =
        format!("paths meet {} surfaces on average, {} of them of \"{name}\"", short(length), percent(share));
    let mut finding = find(if length > 24.0 { Severity::Warning } else { Severity::Note }, "long-paths", 0.7, what)
        .why(format!("the longest of the probe met {longest}: surfaces that return nearly all light, or let it through, keep paths alive"))
        .remedy("lower `max_depth`, or albedos near 1 to 0.8, or let Russian roulette begin earlier with `rr_start`")
        .set("integrator.max_depth", 8)
        .about(name)
        .measure("surfaces-per-path", length, "count")
        .measure("longest-path", f64::from(longest), "count")
        .measure("share-of-material", share, "share");
    if let IntegratorDesc::Path(p) = &e.scene.integrator
        && p.rr_start > 16
    {
        finding = finding.set("integrator.rr_start", 3).measure("rr-start", f64::from(p.rr_start), "count");
    }
    Some(finding)
}

/// Rays of the classic integrator.
fn trees(e: &Evidence<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let Some(t) = e.g.trees.filter(|t| t.samples > 0) else { return out };
    let (rays, shadow) = (t.rays as f64 / t.samples as f64, t.shadow_rays as f64 / t.samples as f64);
    if shadow > 64.0 && shadow > 4.0 * rays {
        let what = format!("{} shadow rays are sent for each sample", short(shadow));
        let lights: u32 = e.scene.lights.iter().map(|l| l.samples()).sum();
        out.push(
            find(if shadow > 200.0 { Severity::Warning } else { Severity::Note }, "shadow-rays", 0.8, what)
                .why(format!("each surface asks {lights} points of lights: `samples` of lights with an extent count for each"))
                .remedy("lower `samples` of these lights and take more samples per pixel, or use \"path\", which asks one point at a time")
                .set("integrator.type", "path")
                .measure("shadow-rays-per-sample", shadow, "count")
                .measure("points-of-lights", f64::from(lights), "count"),
        );
    }
    if rays > 64.0 || t.dropped > 0 {
        let what = format!("a sample's tree has {} rays on average, down to depth {}", short(rays), t.depth);
        out.push(
            find(
                if t.dropped > 0 || rays > 500.0 { Severity::Warning } else { Severity::Note },
                "ray-trees",
                0.8,
                what,
            )
            .why("at glass each ray becomes two: their number doubles with each depth")
            .remedy("lower `max_depth`")
            .set("integrator.max_depth", 5)
            .measure("rays-per-sample", rays, "count")
            .measure("rays-dropped", t.dropped as f64, "count"),
        );
    }
    out
}

/// An object whose search takes much.
fn costly_object(e: &Evidence<'_>) -> Option<Finding> {
    let mut by: BTreeMap<u32, (u64, u64, &'static str)> = BTreeMap::new();
    let (mut all, mut rays) = (0, 0);
    for sight in e.g.first_hits.iter().flatten() {
        all += sight.steps;
        rays += 1;
        if let Some(met) = sight.met {
            let entry = by.entry(met.primitive).or_insert((0, 0, met.shape));
            (entry.0, entry.1) = (entry.0 + sight.steps, entry.1 + 1);
        }
    }
    let mean = all as f64 / f64::from(rays.max(1));
    if mean < 150.0 {
        return None;
    }
    let (&primitive, &(steps, count, shape)) =
        by.iter().max_by_key(|(i, (n, ..))| (*n, std::cmp::Reverse(**i)))?;
    let (share, pixels) = (steps as f64 / all.max(1) as f64, count as f64 / f64::from(rays.max(1)));
    let name = e.labels.object(primitive, shape);
    let what = format!(
        "a camera ray goes through {} boxes and shapes; {} of that is rays to \"{name}\"",
        short(mean),
        percent(share)
    );
    Some(
        find(Severity::Note, "costly-search", 0.6, what)
            .why(format!("it fills {} of the picture. Objects whose boxes overlap, long thin triangles, and many shapes in one place take most; the integrator \"cost\" shows where", percent(pixels)))
            .remedy("make instances of a group rather than one large object, or build the trees with more care")
            .or(Remedy::TreeQuality(Quality::High))
            .about(name)
            .measure("steps-per-ray", mean, "count")
            .measure("share-of-steps", share, "share")
            .measure("share-of-picture", pixels, "share"),
    )
}

/// More triangles than the picture can show.
fn dense_mesh(e: &Evidence<'_>) -> Option<Finding> {
    let pixels = f64::from(e.scene.film().width) * f64::from(e.scene.film().height);
    let triangles = e.scene.stats.triangles as f64;
    if triangles < 100_000.0 || triangles < 8.0 * pixels {
        return None;
    }
    let objects = e.desc.objects.iter().chain(e.desc.groups.iter().flat_map(|g| &g.value.objects));
    let meshes = objects.filter_map(|o| match &o.content {
        ObjectContent::Shape(ShapeDesc::Mesh(m)) => {
            Some((o.name.clone(), e.desc.meshes.get(m.mesh.index())?))
        }
        _ => None,
    });
    let (name, mesh) = meshes.max_by_key(|(_, m)| m.data.triangles.len())?;
    let name = name.unwrap_or_else(|| mesh.uri.clone());
    let own = mesh.data.triangles.len() as f64;
    let what = format!(
        "{} triangles for {} pixels: {} to a pixel, {} of them of \"{name}\"",
        short(triangles),
        short(pixels),
        short(triangles / pixels),
        percent(own / triangles)
    );
    Some(
        find(if triangles > 20.0 * pixels { Severity::Warning } else { Severity::Note }, "dense-mesh", 0.75, what)
            .why(format!("most of them are smaller than a pixel: they take {} of memory and time to load, and rays no longer find neighbours in the cache", crate::doctor::finding::short(e.scene.stats.mesh_bytes as f64 / 1e6) + " MB"))
            .remedy("reduce the mesh in the program it comes from, or put the detail in a normal map")
            .about(name)
            .measure("triangles", triangles, "count")
            .measure("triangles-per-pixel", triangles / pixels, "ratio")
            .measure("mesh-bytes", e.scene.stats.mesh_bytes as f64, "bytes"),
    )
}

/// More samples than it takes.
fn film(e: &Evidence<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    let film = e.scene.film();
    let (pixels, samples) = (f64::from(film.width) * f64::from(film.height), f64::from(e.samples()));
    let enough = (e.variance / 1e-4).ceil().max(16.0);
    if samples > 1024.0 && samples > 8.0 * enough && !e.g.paths.is_empty() {
        let what =
            format!("{samples} samples per pixel are {} times as many as it takes", short(samples / enough));
        out.push(
            find(Severity::Warning, "samples-excessive", 0.9, what)
                .why(format!("with {} the error would be 0.0001 (relMSE), which nobody sees", short(enough)))
                .remedy("lower `samples` of [film]")
                .set("film.samples", enough as u32)
                .measure("samples", samples, "count")
                .measure("samples-for-0.0001", enough, "count"),
        );
    } else if samples > 4096.0 && e.g.paths.is_empty() && !e.scene.integrator.capabilities().debug {
        let what = format!("{samples} samples per pixel are many for \"{}\"", e.scene.integrator.type_name());
        out.push(
            find(Severity::Warning, "samples-excessive", 0.9, what)
                .why("its samples differ at edges and by soft shadows alone")
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
                .why("at a million samples a second that is over half a day")
                .remedy("lower `width` and `height`, or `samples`")
                .or(Remedy::set("film.width", film.width.div_ceil(4))
                    .and("film.height", film.height.div_ceil(4)))
                .measure("samples-in-all", pixels * samples, "count"),
        );
    }
    if film.antialias == Antialias::Adaptive && film.max_subdivisions > 4 && film.threshold < 0.01 {
        let most = crate::math::elementary::pow(4.0, f64::from(film.max_subdivisions));
        let what = format!("adaptive anti-aliasing divides a pixel into up to {} squares", short(most));
        out.push(
            find(Severity::Warning, "adaptive-too-fine", 0.7, what)
                .why(format!("a difference of {} is enough to divide it further", short(film.threshold)))
                .remedy("raise `threshold` of [film] to 0.05, or lower `max_subdivisions` to 3")
                .set("film.max_subdivisions", 3)
                .set("film.threshold", 0.05)
                .measure("squares-per-pixel", most, "count"),
        );
    }
    out
}
