//! Rules for broken scenes: non-finite samples, wrong normals, inverted meshes, lost precision, ignored settings.

use std::collections::BTreeMap;

use super::evidence::Evidence;
use super::finding::{Finding, Question, Severity, percent, short};
use super::materials;
use crate::description::{ObjectContent, ObjectDesc};
use crate::math::{Bounds, DVec3};
use crate::schema::value::Span;
use crate::schema::{MaterialId, MeshData, Remedy, WarningKind};
use crate::shape::ShapeDesc;

fn find(severity: Severity, code: &'static str, weight: f64, what: String) -> Finding {
    Finding::new(Question::Broken, severity, code, weight, what)
}

pub(super) fn check(e: &Evidence<'_>, out: &mut Vec<Finding>) {
    out.extend(non_finite(e));
    out.extend(normals(e));
    out.extend(inside_out(e));
    out.extend(backs(e));
    out.extend(far_away(e));
    out.extend(warnings(e));
    if !e.g.complete {
        let seen = e.g.paths.iter().flatten().count();
        let what =
            format!("the time limit ended the examination after {seen} of {} pixels", e.g.pixels.len());
        out.push(
            find(Severity::Note, "examination-cut", 0.1, what)
                .why("this scene takes much longer to probe than most. The findings are right, but others may be missing")
                .remedy("raise the time limit")
                .or(Remedy::Seconds(60.0))
                .measure("pixels-examined", seen as f64, "count"),
        );
    }
}

/// Samples that are NaN or infinite.
fn non_finite(e: &Evidence<'_>) -> Option<Finding> {
    let paths = e.sum(|p| f64::from(p.samples));
    let of_paths = e.sum(|p| f64::from(p.non_finite));
    let of_colors = e.g.colors.iter().filter(|c| c.iter().any(|v| !v.is_finite())).count() as f64;
    let (bad, all) = if paths > 0.0 { (of_paths, paths) } else { (of_colors, e.g.colors.len() as f64) };
    if bad == 0.0 || all == 0.0 || !e.g.complete {
        return None;
    }
    let what = format!("{} of the samples are non-finite", percent(bad / all));
    Some(
        find(Severity::Error, "non-finite", 1.0, what)
            .why("the film drops them; a pixel with no other samples is magenta. Products of values in the scene overflow")
            .remedy("look for lights, emission and colours of 1e30 and more; `turner explain` at a magenta pixel shows where it begins. If there are none, this is a bug: please report it")
            .measure("samples", bad / all, "fraction"),
    )
}

/// Shading normals on the other side of the surface than the geometric normal.
fn normals(e: &Evidence<'_>) -> Option<Finding> {
    let hits: Vec<_> = e.hits().map(|(_, _, m)| m).collect();
    let bad: Vec<_> = hits.iter().filter(|m| !m.valid_normals).collect();
    let first = bad.first()?;
    let fraction = bad.len() as f64 / hits.len().max(1) as f64;
    if fraction < 0.01 {
        return None;
    }
    let name = e.labels.object_label(first.primitive, first.shape);
    let what = format!(
        "{} of the visible surfaces have shading normals that point to the other side; one of them is {name}",
        percent(fraction)
    );
    Some(
        find(Severity::Warning, "bad-normals", 0.6, what)
            .why("the normals in the mesh file disagree with the winding of its triangles: surfaces look black or torn")
            .remedy("recompute the normals in the program that the mesh comes from, or ignore them with `smooth = false`")
            .about(name.text)
            .measure("surfaces", fraction, "fraction"),
    )
}

/// Maximum number of triangles that are checked.
const MAX_TRIANGLES: usize = 4_000_000;

/// Closed meshes with clockwise winding.
fn inside_out(e: &Evidence<'_>) -> Vec<Finding> {
    let mut flipped: BTreeMap<u32, bool> = BTreeMap::new();
    let mut left = MAX_TRIANGLES;
    let mut is_flipped = |index: u32, mesh: &MeshData| {
        *flipped.entry(index).or_insert_with(|| {
            left = left.saturating_sub(mesh.triangles.len());
            left > 0 && volume(mesh).is_some_and(|v| v < 0.0)
        })
    };
    let mut out = Vec::new();
    let objects = e.desc.objects.iter().chain(e.desc.groups.iter().flat_map(|g| &g.value.objects));
    for object in objects.filter(|object| !object.hidden) {
        let ObjectContent::Shape(ShapeDesc::Mesh(m)) = &object.content else { continue };
        let Some(asset) = e.desc.meshes.get(m.mesh.index()) else { continue };
        if !is_flipped(m.mesh.0, &asset.data) {
            continue;
        }
        out.push(flipped_mesh(
            e,
            object,
            &asset.uri,
            object.material.or(m.materials.iter().flatten().next().copied()),
        ));
    }
    out.truncate(8);
    out
}

fn flipped_mesh(e: &Evidence<'_>, object: &ObjectDesc, uri: &str, material: Option<MaterialId>) -> Finding {
    let principled = material.and_then(|id| materials::principled(e.desc, id)).unwrap_or_default();
    let name = object
        .name
        .clone()
        .unwrap_or_else(|| if uri.is_empty() { "a mesh".to_owned() } else { uri.to_owned() });
    let emits = principled.emission_luminance > 0.0;
    let (severity, effect) = if !principled.double_sided && !principled.is_transmissive() {
        let effect = if emits { "emits light inwards only" } else { "is visible from inside only" };
        (Severity::Error, effect)
    } else if principled.is_transmissive() && !principled.thin_walled {
        (Severity::Error, "refracts light like an air bubble in glass")
    } else {
        (Severity::Note, "looks right, because its material is double-sided")
    };
    let what = format!("the mesh \"{name}\" is inside out: its normals point inwards");
    find(severity, "mesh-inside-out", 0.96, what)
        .why(format!("it is closed, and seen from outside its triangles wind clockwise; so it {effect}"))
        .remedy("reverse the winding (flip the normals in the program that it comes from), or set `double_sided = true`")
        .about(name)
        .at(object.span)
}

/// The signed volume of a closed mesh, negative if its normals point inwards; `None` for an open mesh. It is the sum of
/// the signed volumes of the tetrahedra between the triangles and one point (divergence theorem).
fn volume(mesh: &MeshData) -> Option<f64> {
    let point = |i: u32| mesh.positions.get(i as usize).copied().map(|p| DVec3::from(p.map(f64::from)));
    let (mut edges, mut sum) = (Vec::with_capacity(mesh.triangles.len() * 3), 0.0);
    let origin = point(0)?;
    // Vertices at the same position count as one vertex.
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let bits = |i: &u32| mesh.positions.get(*i as usize).map(|p| p.map(|v| (v + 0.0).to_bits()));
    order.sort_by_key(bits);
    let mut own = vec![0u32; mesh.positions.len()];
    let mut last: Option<u32> = None;
    for i in &order {
        let same = last.filter(|l| bits(l) == bits(i));
        last = Some(same.unwrap_or(*i));
        if let (Some(slot), Some(l)) = (own.get_mut(*i as usize), last) {
            *slot = l;
        }
    }
    for t in &mesh.triangles {
        let [a, b, c] = [point(t[0])? - origin, point(t[1])? - origin, point(t[2])? - origin];
        sum += a.dot(b.cross(c)) / 6.0;
        let corner = |i: u32| own.get(i as usize).copied().unwrap_or(i);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            edges.push((corner(t[i]), corner(t[j])));
        }
    }
    // A closed, consistently oriented mesh has each edge once in each direction.
    let mut there = edges.clone();
    let mut back: Vec<(u32, u32)> = edges.into_iter().map(|(a, b)| (b, a)).collect();
    there.sort_unstable();
    back.sort_unstable();
    (there == back && !there.is_empty()).then_some(sum)
}

/// One-sided surfaces whose back faces the camera.
fn backs(e: &Evidence<'_>) -> Option<Finding> {
    if !e.desc.materials.iter().any(|m| m.value.cutout(true).is_some_and(|c| c.one_sided)) {
        return None;
    }
    let mut passed: BTreeMap<u32, (u32, &'static str)> = BTreeMap::new();
    for first_hit in e.g.first_hits.iter().flatten() {
        let mut ray = first_hit.ray;
        ray.t_max = first_hit.hit.map_or(ray.t_max, |m| m.t);
        for (primitive, shape) in e.scene.backs_on(&ray) {
            passed.entry(primitive).or_insert((0, shape)).0 += 1;
        }
    }
    for (_, _, hit) in e.hits() {
        // Objects with a visible front face are closed or curved.
        passed.remove(&hit.primitive);
    }
    let (&primitive, &(count, shape)) =
        passed.iter().max_by_key(|(i, (n, _))| (*n, std::cmp::Reverse(**i)))?;
    let fraction = f64::from(count) / e.g.first_hits.iter().flatten().count().max(1) as f64;
    let name = e.labels.object_label(primitive, shape);
    let severity = if fraction > 0.2 || e.is_black() || e.hit_fraction < 0.01 {
        Severity::Error
    } else {
        Severity::Warning
    };
    let what = format!("the camera sees the back of {name}, which is invisible");
    Some(
        find(severity, "back-faces-culled", 0.94, what)
            .why(format!("{} of the camera rays pass through it: its material has `double_sided = false`, and its normals point away from the camera", percent(fraction)))
            .remedy("flip it (swap `edge_u` and `edge_v`, or reverse the winding of a mesh), or set `double_sided = true`")
            .about(name.text)
            .measure("rays-through", fraction, "fraction"),
    )
}

/// A scene that is so far from the origin that coordinates lose precision.
fn far_away(e: &Evidence<'_>) -> Option<Finding> {
    let all = e.scene.all_bounds().map(|(_, b)| b).filter(Bounds::is_finite);
    let bounds = all.fold(Bounds::EMPTY, |a, b| a.union(&b));
    if bounds.is_empty() {
        return None;
    }
    let (offset, size) = (bounds.center().length(), bounds.size().length());
    let ratio = offset / size.max(1e-300);
    if ratio < 1e5 {
        return None;
    }
    let what = format!("the scene is far from the origin: {} times its own size", short(ratio));
    let single = e.scene.stats.triangles > 0;
    Some(
        find(if single && ratio > 1e6 { Severity::Warning } else { Severity::Note }, "far-from-origin", 0.5, what)
            .why("mesh vertices have seven digits. The few digits left there may show as torn surfaces and shadows")
            .remedy(format!("move everything by ({}, {}, {})", short(-bounds.center().x), short(-bounds.center().y), short(-bounds.center().z)))
            .measure("distance", offset, "units")
            .measure("size", size, "units"),
    )
}

/// Warnings from loading and preparation that have no finding of their own.
fn warnings(e: &Evidence<'_>) -> Vec<Finding> {
    let own = crate::lint::with_findings(e.desc, &e.scene.prepared);
    let mut by: BTreeMap<(&str, &str), (u64, Option<Span>)> = BTreeMap::new();
    for w in e.scene.prepared.warnings.iter().filter(|w| own.iter().all(|own| own.message != w.message)) {
        let code = match w.kind {
            WarningKind::Ignored => "ignored",
            WarningKind::Doubtful => "doubtful",
            WarningKind::Approximated | WarningKind::Note => continue,
        };
        let (count, span) = by.entry((code, w.message.as_str())).or_default();
        (*count, *span) = (*count + w.count, span.or(w.span));
    }
    let finding = |(code, message): (&'static str, &str), (count, span): (u64, Option<Span>)| {
        find(Severity::Warning, code, 0.3, message.to_owned())
            .why(if code == "ignored" {
                "the scene has it, but the picture does not show it"
            } else {
                "this is probably not what you want"
            })
            .remedy("`turner info` lists all warnings with their lines")
            .at(span)
            .measure("times", count as f64, "count")
    };
    let mut out = Vec::new();
    for ((code, message), found) in by.iter().take(8) {
        let code = if *code == "ignored" { "ignored" } else { "doubtful" };
        out.push(finding((code, *message), *found));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron(order: [usize; 3]) -> MeshData {
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        MeshData {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: triangles.iter().map(|t: &[u32; 3]| order.map(|i| t[i])).collect(),
            ..MeshData::default()
        }
    }

    #[test]
    fn the_volume_of_a_closed_mesh_has_a_sign() {
        let v = volume(&tetrahedron([0, 1, 2])).unwrap();
        assert!((v - 1.0 / 6.0).abs() < 1e-9, "{v}");
        assert!(volume(&tetrahedron([0, 2, 1])).unwrap() < 0.0);
        let mut open = tetrahedron([0, 1, 2]);
        open.triangles.pop();
        assert_eq!(volume(&open), None);
    }
}
