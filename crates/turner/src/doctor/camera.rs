//! Rules for what the camera sees: crop, camera inside an object, invisible objects, direction, focus, obstructions.

use std::collections::BTreeMap;

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, rounded, short};
use super::first_hits::{directions, first};
use super::materials;
use crate::camera::CameraDesc;
use crate::math::elementary::acos;
use crate::math::{Bounds, DVec3, Ray};
use crate::schema::MaterialId;

const BLACK: Question = Question::Black;

pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    let Some(view) = View::new(e) else { return };
    if let Some(finding) = crop(e) {
        out.push(finding);
    }
    let inside = inside(e, &view);
    let is_inside = inside.is_some();
    out.extend(inside);
    out.extend(invisible(e));
    if is_inside {
        return;
    }
    out.extend(nothing_seen(e, &view));
    out.extend(blurred(e, &view));
    out.extend(near(e, &view));
}

/// The view of the camera.
struct View {
    position: DVec3,
    forward: DVec3,
    target: DVec3,
    /// Cosine of the largest angle between a camera ray and `forward`.
    cos_rim: f64,
    /// Approximately the largest angle between adjacent pixels, radians.
    pixel: f64,
}

impl View {
    fn new(e: &Evidence<'_>) -> Option<View> {
        let [position, look_at, _] = e.scene.prepared.view.camera_desc.clone().placement_mut().map(|v| *v);
        let forward = (look_at - position).normalize_or_zero();
        let rays = || e.g.first_hits.iter().flatten().map(|s| s.ray);
        rays().next()?;
        let cos_rim = rays().map(|r| r.direction.dot(forward)).fold(1.0, f64::min);
        let height = f64::from(e.scene.film().height.max(1));
        let pixel = 2.0 * acos(cos_rim.clamp(-1.0, 1.0)) / height;
        Some(View { position, forward, target: look_at, cos_rim, pixel })
    }
}

/// The bounds and the number of all bounded objects except those much larger than the rest, such as spheres that serve
/// as floors and boxes that contain the scene.
fn subject(e: &Evidence<'_>) -> Option<(Bounds, usize)> {
    let mut all: Vec<Bounds> = e.scene.all_bounds().map(|(_, b)| b).filter(Bounds::is_finite).collect();
    let size = |b: &Bounds| b.size().length();
    all.sort_by(|a, b| size(a).total_cmp(&size(b)));
    let typical = size(all.get(all.len() / 2)?);
    let subjects: Vec<Bounds> = all.into_iter().filter(|b| size(b) <= 50.0 * typical.max(1e-300)).collect();
    let bounds = subjects.iter().fold(Bounds::EMPTY, |a, b| a.union(b));
    (!bounds.is_empty()).then_some((bounds, subjects.len()))
}

/// A crop that shows no object, or only a dark part of the picture.
fn crop(e: &Evidence<'_>) -> Option<Finding> {
    let [(light, hit), (all, hit_all)] = e.g.crop?;
    let [x, y, width, height] = e.scene.film().crop?;
    let empty = hit == 0.0 && hit_all > 0.1;
    let dark = light <= 0.02 * all && all > 0.0;
    if !(empty || dark) {
        return None;
    }
    let what = format!(
        "the crop of {width}x{height} pixels at ({x}, {y}) shows {}",
        if empty { "no object" } else { "a dark part of the picture" }
    );
    let finding = Finding::new(BLACK, Severity::Error, "crop-misses", 0.97, what)
        .why("only the crop is rendered; the objects are elsewhere in the picture")
        .remedy("remove `crop` from [film], or move it over the objects")
        .set("film.crop", [0, 0, e.scene.film().width, e.scene.film().height]);
    let finding = finding.measure("brightness-in-crop", light, "radiance").measure(
        "picture-brightness",
        all,
        "radiance",
    );
    Some(finding.measure("hits-in-crop", hit, "fraction").measure("hits-in-picture", hit_all, "fraction"))
}

/// A camera inside a solid.
fn inside(e: &Evidence<'_>, view: &View) -> Option<Finding> {
    const DIRECTIONS: u32 = 64;
    let mut enclosing: BTreeMap<u32, (u32, &'static str, MaterialId)> = BTreeMap::new();
    for d in directions(DIRECTIONS) {
        if let Some(hit) = first(e.scene, &Ray::new(view.position, d)).filter(|m| !m.outside) {
            enclosing.entry(hit.primitive).or_insert((0, hit.shape, hit.material)).0 += 1;
        }
    }
    let (&primitive, &(count, shape, material)) =
        enclosing.iter().max_by_key(|(id, (n, ..))| (*n, std::cmp::Reverse(**id)))?;
    let fraction = f64::from(count) / f64::from(DIRECTIONS);
    // Also check the camera rays: with a near plane they may start outside the solid.
    let rays = e.g.first_hits.iter().flatten().count().max(1) as f64;
    let seen = e.hits().filter(|(_, _, m)| m.primitive == primitive && !m.outside).count() as f64 / rays;
    if fraction < 0.8 || seen < 0.8 {
        return None;
    }
    let name = e.labels.object_label(primitive, shape);
    let own = e.scene.primitive_bounds(primitive)?;
    let within = |p: DVec3| (p.cmpge(own.min) & p.cmple(own.max)).all();
    // A room contains most objects of the scene and most lights that have a position.
    let objects = e.scene.all_bounds().filter(|(id, _)| *id != primitive).map(|(_, b)| b.center());
    let lights = e.g.lights.iter().filter_map(|l| l.bounds).map(|b| b.center());
    let (mut held, mut others) = (0u64, 0u64);
    for center in objects.take(1 << 16).chain(lights) {
        others += 1;
        held += u64::from(within(center));
    }
    let is_room = if others > 0 { 2 * held >= others } else { !e.is_black() };
    let through = materials::transmits(e.scene, material);
    let severity = match (is_room, through) {
        (true, false) if !e.is_black() => return None,
        (true, _) => return None,
        (false, true) => Severity::Warning,
        (false, false) => Severity::Error,
    };
    let what = format!("the camera is inside {name}");
    let out = Finding::new(BLACK, severity, "camera-inside", 0.99, what)
        .why(format!(
            "{} of all directions from the camera hit its inner side first, as do {} of the camera rays; the other objects are outside",
            percent(fraction),
            percent(seen)
        ))
        .remedy(format!("move the camera out of it: `[camera] position` is ({})", point(view.position)))
        .about(name.text)
        .measure("directions-enclosed", fraction, "fraction")
        .measure("rays-enclosed", seen, "fraction");
    Some(out)
}

fn point(p: DVec3) -> String {
    format!("{}, {}, {}", short(p.x), short(p.y), short(p.z))
}

/// Objects that are invisible because their opacity is 0.
fn invisible(e: &Evidence<'_>) -> Option<Finding> {
    let gone = |i: usize| e.desc.materials.get(i).and_then(|m| materials::invisible(&m.value));
    let named: Vec<(usize, f64)> = (0..e.desc.materials.len()).filter_map(|i| Some((i, gone(i)?))).collect();
    if named.is_empty() {
        return None;
    }
    let of: BTreeMap<u32, usize> = e
        .scene
        .primitive_materials()
        .filter_map(|(id, m)| named.iter().find(|(i, _)| *i == m.index()).map(|(i, _)| (id, *i)))
        .collect();
    let boxes: Vec<(Bounds, usize)> =
        e.scene.all_bounds().filter_map(|(id, b)| Some((b, *of.get(&id)?))).take(4096).collect();
    let rays = e.g.first_hits.iter().flatten().count().max(1) as f64;
    let mut through: BTreeMap<usize, u32> = BTreeMap::new();
    for first_hit in e.g.first_hits.iter().flatten() {
        if let Some((_, i)) = boxes.iter().find(|(b, _)| enters(b, &first_hit.ray)) {
            *through.entry(*i).or_default() += 1;
        }
    }
    let (&i, &count) = through.iter().max_by_key(|(i, n)| (**n, std::cmp::Reverse(**i)))?;
    let fraction = f64::from(count) / rays;
    let opacity = gone(i)?;
    let name = e.labels.material_label(MaterialId(i as u32));
    let severity = if e.hit_fraction < 0.01 || e.is_black() || boxes.len() as u64 == e.scene.stats.primitives
    {
        Severity::Error
    } else {
        Severity::Warning
    };
    let what = format!("objects with {name} are invisible: its opacity is {}", short(opacity));
    Some(
        Finding::new(BLACK, severity, "objects-invisible", 0.98, what)
            .why(format!(
                "{} of the camera rays pass through their bounding boxes and hit nothing there",
                percent(fraction)
            ))
            .remedy(format!("raise `opacity` of {name} to 1, or remove it"))
            .set(&format!("material.{}.opacity", name.text), 1.0)
            .about(name.text)
            .at(e.desc.materials.get(i).and_then(|m| m.span))
            .measure("opacity", opacity, "fraction")
            .measure("rays-through", fraction, "fraction"),
    )
}

/// Whether a ray intersects a box (slab test).
fn enters(b: &Bounds, ray: &Ray) -> bool {
    let inverse = ray.direction.recip();
    let (a, z) = ((b.min - ray.origin) * inverse, (b.max - ray.origin) * inverse);
    let near = a.min(z).max_element().max(ray.t_min);
    near <= a.max(z).min_element().min(ray.t_max)
}

/// Camera rays that hit no bounded object although there are some.
fn nothing_seen(e: &Evidence<'_>, view: &View) -> Option<Finding> {
    let (bounds, count) = subject(e)?;
    let bounded = e.hits().filter(|(_, _, m)| !m.unbounded).count();
    let rays = e.g.first_hits.iter().flatten().count().max(1) as f64;
    let fraction = bounded as f64 / rays;
    if bounded > 0 && !(fraction < 0.01 && e.is_black()) {
        return None;
    }
    let severity = if e.hit_fraction < 0.01 || e.is_black() { Severity::Error } else { Severity::Warning };
    let center = bounds.center();
    let to = center - view.position;
    let (distance, radius) = (to.length(), 0.5 * bounds.size().length());
    let cosine = to.normalize_or_zero().dot(view.forward);
    let angle = acos(cosine.clamp(-1.0, 1.0)).to_degrees();
    let rim = acos(view.cos_rim.clamp(-1.0, 1.0)).to_degrees();
    let reach = if distance > radius { (radius / distance).min(1.0) } else { 1.0 };
    let half = crate::math::elementary::asin(reach).to_degrees();
    let find = |code, weight, what: String| {
        Finding::new(BLACK, severity, code, weight, what)
            .measure("rays-that-hit-objects", fraction, "fraction")
            .measure("angle-off-axis", angle, "degrees")
            .measure("distance", distance, "units")
            .measure("radius-of-objects", radius, "units")
    };
    if angle - half > rim {
        let what = format!(
            "the camera looks past the objects: the centre of all {count} is {} degrees off its axis, and it sees {} degrees around the axis",
            short(angle),
            short(rim)
        );
        return Some(
            find("camera-looks-away", 0.96, what)
                .why(format!("none of its rays hits an object; the objects are around ({})", point(center)))
                .remedy(format!("aim the camera: `[camera] look_at = [{}]`", point(center)))
                .set("camera.look_at", center.to_array().map(rounded)),
        );
    }
    if let CameraDesc::Pinhole(pinhole) = &e.scene.prepared.view.camera_desc
        && pinhole.near > (distance - radius).max(0.0)
        && pinhole.near > 0.0
    {
        let what = format!("the near plane of the camera, at {}, clips everything", short(pinhole.near));
        return Some(
            find("camera-near-clips", 0.96, what)
                .why(format!("the objects are {} units away", short(distance)))
                .remedy("lower `near` of [camera]")
                .set("camera.near", 0.0)
                .measure("near", pinhole.near, "units"),
        );
    }
    if let CameraDesc::Pinhole(pinhole) = &e.scene.prepared.view.camera_desc
        && let Some(far) = pinhole.far
        && far < distance + radius
    {
        let what = format!("the far plane of the camera, at {}, clips everything", short(far));
        return Some(
            find("camera-far-clips", 0.96, what)
                .why(format!("the objects are {} units away", short(distance)))
                .remedy("raise `far` of [camera]")
                .set("camera.far", rounded(2.0 * (distance + radius)))
                .measure("far", far, "units"),
        );
    }
    let pixels = 2.0 * (radius / distance.max(1e-300)) / view.pixel.max(1e-300);
    if pixels < 4.0 {
        let what =
            format!("all objects together are {} pixels wide: too small or too far away", short(pixels));
        return Some(
            find("objects-too-small", 0.96, what)
                .why(format!(
                    "the objects are {} units across and {} units away: their units may differ from those of the camera position (1 m is 1000 mm)",
                    short(2.0 * radius),
                    short(distance)
                ))
                .remedy(format!("scale the objects by about {}, or move the camera closer", short(0.3 * distance / radius.max(1e-300))))
                .measure("size-in-picture", pixels, "pixels"),
        );
    }
    let what = "no camera ray hits an object, though there are objects in view".to_owned();
    let one_sided = e.desc.materials.iter().any(|m| m.value.cutout(true).is_some_and(|c| c.one_sided));
    let (why, remedy) = if one_sided {
        (
            "materials with `double_sided = false` are invisible from the back",
            "flip the surfaces, or set `double_sided = true`",
        )
    } else {
        (
            "rays pass between the objects or through holes in them",
            "move the camera; the integrator \"depth\" shows what its rays hit",
        )
    };
    Some(find("objects-not-hit", 0.9, what).why(why).remedy(remedy))
}

/// A lens with nothing in focus.
fn blurred(e: &Evidence<'_>, view: &View) -> Option<Finding> {
    let prepared = &e.scene.prepared.view;
    let is_thin = matches!(prepared.camera_desc, CameraDesc::ThinLens(_));
    let (radius, focus) = prepared.camera.model(1, 1).lens?;
    // The diameter of the circle of confusion of points at a depth, measured in the plane of focus, in pixels.
    let pixels = |depth: f64| {
        let circle = 2.0 * radius * (depth - focus).abs() / depth.max(1e-300);
        circle / (focus * view.pixel).max(1e-300)
    };
    let depths: Vec<f64> = e.hits().map(|(_, s, m)| m.t * s.ray.direction.dot(view.forward)).collect();
    if depths.len() < 8 {
        return None;
    }
    let sharpest = super::picture::quantile(depths.iter().map(|d| pixels(*d)), 0.1);
    let fraction = sharpest / f64::from(e.scene.film().height.max(1));
    if fraction < 0.03 {
        return None;
    }
    let nearest = super::picture::quantile(depths.iter().copied(), 0.3);
    let what = format!(
        "nothing is in focus: 90 % of the visible surfaces are blurred over {} pixels or more",
        short(sharpest)
    );
    let severity = if fraction > 0.1 { Severity::Error } else { Severity::Warning };
    let smaller = if is_thin { "lens_radius" } else { "aperture_diameter" };
    let finding =
        Finding::new(Question::Broken, severity, "out-of-focus", 0.5, what)
            .why(format!("the plane of focus is {} units away, with a lens of radius {}; most visible surfaces are {} units away or more", short(focus), short(radius), short(nearest)))
            .remedy(format!("set `focus_distance` of [camera] to that distance, or make `{smaller}` smaller"))
            .set("camera.focus_distance", rounded(nearest))
            .measure("blur", sharpest, "pixels")
            .measure("focus", focus, "units")
            .measure("distance", nearest, "units");
    Some(if is_thin { finding.set("camera.lens_radius", rounded(radius * 0.02 / fraction)) } else { finding })
}

/// An object close to the camera fills the picture.
fn near(e: &Evidence<'_>, view: &View) -> Option<Finding> {
    let rays = e.g.first_hits.iter().flatten().count();
    let mut by: BTreeMap<u32, (usize, &'static str, MaterialId, Vec<f64>)> = BTreeMap::new();
    for (_, _, hit) in e.hits() {
        let entry = by.entry(hit.primitive).or_insert((0, hit.shape, hit.material, Vec::new()));
        entry.0 += 1;
        entry.3.push(hit.t);
    }
    let (&primitive, (count, shape, material, distances)) =
        by.iter().max_by_key(|(id, (n, ..))| (*n, std::cmp::Reverse(**id)))?;
    let fraction = *count as f64 / rays.max(1) as f64;
    let distance = super::picture::quantile(distances.iter().copied(), 0.5);
    let own = e.scene.primitive_bounds(primitive);
    let others = e.scene.all_bounds().filter(|(id, _)| *id != primitive).map(|(_, b)| b);
    let rest = others.fold(Bounds::EMPTY, |a, b| a.union(&b));
    if fraction < 0.95 || rest.is_empty() || !materials::is_opaque(e.scene, *material) {
        return None;
    }
    let (to_target, to_rest) =
        ((view.target - view.position).length(), (rest.center() - view.position).length());
    // No obstruction if the camera looks at the object or the object contains everything.
    let is_target = own.is_some_and(|b| {
        let grown = 1e-3 * b.size().length();
        (view.target.cmpge(b.min - grown) & view.target.cmple(b.max + grown)).all()
    });
    if distance > 0.5 * to_rest.min(to_target) || is_target {
        return None;
    }
    let name = e.labels.object_label(primitive, shape);
    let severity = if e.is_black() { Severity::Error } else { Severity::Warning };
    let what = format!("{name} is right in front of the camera and hides everything");
    Some(
        Finding::new(BLACK, severity, "camera-blocked", 0.95, what)
            .why(format!(
                "{} of the camera rays end at it, {} units away; the point that the camera looks at is {} units away",
                percent(fraction),
                short(distance),
                short(to_target)
            ))
            .remedy("move the camera or the object, or clip it with `near` of [camera]")
            .set("camera.near", rounded(distance * 1.5))
            .about(name.text)
            .measure("rays-blocked", fraction, "fraction")
            .measure("distance", distance, "units")
            .measure("distance-to-target", to_target, "units"),
    )
}
