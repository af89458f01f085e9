//! Curves (UsdGeomBasisCurves) and points (UsdGeomPoints).

use turner::description::ObjectContent;
use turner::schema::{MeshData, WarningKind};
use turner::shape::curves::{CurveBasis, CurveKind, CurvesDesc};
use turner::shape::{PointsDesc, ShapeDesc};

use super::materials::Colors;
use super::primvars::{Per, Primvar, integers, read, vectors};
use super::scene::{Scene, State};
use super::stage::Prim;
use super::value::Read;
use crate::scene_import::report::Fault;

/// The points of one curve, as Turner's basis wants them: indices into the file's points, or an end that is continued by
/// as much again.
enum Knot {
    At(usize),
    /// Twice the first less the second.
    Before(usize, usize),
}

/// How curves are written.
struct Writing {
    basis: CurveBasis,
    is_periodic: bool,
    is_pinned: bool,
}

fn writing(scene: &Scene<'_>, prim: &Prim) -> Read<Writing> {
    let word = |name| Ok(scene.stage.value(prim, name)?.and_then(|v| v.text().map(str::to_owned)));
    let (kind, basis, wrap) = (word("type")?, word("basis")?, word("wrap")?);
    let basis = match (kind.as_deref(), basis.as_deref()) {
        (Some("linear"), _) => CurveBasis::Linear,
        (_, Some("bspline")) => CurveBasis::BSpline,
        (_, Some("catmullRom")) => CurveBasis::CatmullRom,
        _ => CurveBasis::Bezier,
    };
    let is = |what: &str| wrap.as_deref() == Some(what);
    Ok(Writing { basis, is_periodic: is("periodic"), is_pinned: is("pinned") })
}

impl Writing {
    /// The points of a curve that begins at `first` and has `count` points; `None` if the basis has no such curve.
    fn knots(&self, first: usize, count: usize) -> Option<Vec<Knot>> {
        if count < 2 {
            return None;
        }
        let mut knots: Vec<Knot> = (first..first + count).map(Knot::At).collect();
        let last = first + count - 1;
        let again = match self.basis {
            _ if !self.is_periodic => 0,
            CurveBasis::BSpline => 3,
            CurveBasis::CatmullRom | CurveBasis::Linear | CurveBasis::Bezier => 1,
        };
        knots.extend((0..again).map(|i| Knot::At(first + i % count)));
        match self.basis {
            CurveBasis::BSpline if self.is_pinned => {
                knots.insert(0, Knot::Before(first, first + 1));
                knots.push(Knot::Before(last, last - 1));
            }
            // A curve begins at its second point and ends at its last but one.
            CurveBasis::CatmullRom if !self.is_periodic && !self.is_pinned => {
                knots.pop();
                knots.remove(0);
            }
            _ => {}
        }
        self.basis.segments(u32::try_from(knots.len()).ok()?).map(|_| knots)
    }
}

fn finite(v: [f32; 3]) -> bool {
    v.iter().all(|c| c.is_finite())
}

/// Adds curves.
pub(super) fn add_curves(scene: &mut Scene<'_>, prim: &Prim, state: &State) -> Result<(), Fault> {
    let stage = scene.stage;
    let points = stage.value(prim, "points")?.as_ref().and_then(vectors::<3>).unwrap_or_default();
    let counts = integers(stage.value(prim, "curveVertexCounts")?);
    let writing = writing(scene, prim)?;
    let widths = read::<1>(stage, prim, "primvars:widths", Per::Point)?;
    let widths = if widths.is_none() { read::<1>(stage, prim, "widths", Per::Point)? } else { widths };
    let normals = read::<3>(stage, prim, "normals", Per::Point)?.filter(|n| n.per == Per::Point);
    let colors = read::<3>(stage, prim, "primvars:displayColor", Per::Mesh)?;
    // Widths per point are "vertex"; "varying" ones belong to the ends of segments.
    let is_varying = widths.as_ref().is_some_and(|w| w.per == Per::Point && w.values.len() < points.len());
    let mut mesh = MeshData::default();
    let (mut first, mut omitted, mut varying) = (0_usize, false, 0_usize);
    for (curve, count) in counts.iter().enumerate() {
        let count = usize::try_from(*count).unwrap_or(0);
        let range = first..first.saturating_add(count);
        let list = points.get(range.clone()).filter(|list| list.iter().copied().all(finite));
        let knots = list.and_then(|_| writing.knots(first, count));
        let ends = writing.basis.segments(count as u32).map_or(0, |n| n as usize + 1);
        let own_varying = varying;
        varying += ends;
        first = range.end;
        let Some(knots) = knots else {
            omitted = true;
            continue;
        };
        let steps = (knots.len() - 1).max(1);
        for (i, knot) in knots.iter().enumerate() {
            let (point, position) = match *knot {
                Knot::At(at) => (at, points[at]),
                Knot::Before(a, b) => (a, std::array::from_fn(|k| 2.0 * points[a][k] - points[b][k])),
            };
            let width = |w: &Primvar<1>| match is_varying {
                true => {
                    let at = own_varying + (i * ends.saturating_sub(1) + steps / 2) / steps;
                    w.values.get(at).or(w.values.last()).copied()
                }
                false => w.index(curve, usize::MAX, point).and_then(|i| w.values.get(i as usize)).copied(),
            };
            mesh.positions.push(position);
            if let Some(widths) = &widths {
                mesh.widths
                    .push(width(widths).map_or(0.0, |[w]| if w.is_finite() { w.max(0.0) } else { 0.0 }));
            }
            if let Some(normals) = &normals {
                mesh.normals.push(normals.at_point(point).filter(|n| finite(*n)).unwrap_or([0.0, 1.0, 0.0]));
            }
            if let Some(colors) = &colors {
                let at = colors.index(curve, usize::MAX, point).and_then(|i| colors.values.get(i as usize));
                let [r, g, b] = at.copied().filter(|c| finite(*c)).unwrap_or([1.0; 3]);
                mesh.colors.push([r.max(0.0), g.max(0.0), b.max(0.0), 1.0]);
            }
        }
        mesh.strands.push(knots.len() as u32);
    }
    if omitted {
        scene.warn(
            WarningKind::Doubtful,
            "curves with too few points, or with points that are not finite: omitted",
        );
    }
    if mesh.strands.is_empty() {
        return Ok(());
    }
    if mesh.widths.iter().all(|w| *w == 0.0) {
        mesh.widths = Vec::new();
    }
    let kind = if mesh.normals.is_empty() { CurveKind::Tube } else { CurveKind::Ribbon };
    let material = scene.material(state.material.as_deref(), &[], Colors::of(&mesh))?;
    let id = scene.stock.mesh(super::paths::name(&prim.path).to_owned(), mesh);
    let desc = CurvesDesc { curves: id, width: None, basis: writing.basis, kind };
    scene.place(ObjectContent::Shape(ShapeDesc::Curves(desc)), Some(material), prim, state.transform)
}

/// Adds points.
pub(super) fn add_points(scene: &mut Scene<'_>, prim: &Prim, state: &State) -> Result<(), Fault> {
    let stage = scene.stage;
    let points = stage.value(prim, "points")?.as_ref().and_then(vectors::<3>).unwrap_or_default();
    let widths = read::<1>(stage, prim, "widths", Per::Point)?;
    let colors = read::<3>(stage, prim, "primvars:displayColor", Per::Mesh)?;
    let (mut mesh, mut radii) = (MeshData::default(), Vec::new());
    for (i, point) in points.iter().enumerate().filter(|(_, p)| finite(**p)) {
        let radius = widths.as_ref().and_then(|w| w.at_point(i)).map(|[w]| 0.5 * w);
        if widths.is_some() && !radius.is_some_and(|r| r > 0.0 && r.is_finite()) {
            continue;
        }
        radii.extend(radius);
        mesh.positions.push(*point);
        if let Some(colors) = &colors {
            let [r, g, b] = colors.at_point(i).filter(|c| finite(*c)).unwrap_or([1.0; 3]);
            mesh.colors.push([r.max(0.0), g.max(0.0), b.max(0.0), 1.0]);
        }
    }
    if mesh.positions.is_empty() {
        return Ok(());
    }
    let material = scene.material(state.material.as_deref(), &[], Colors::of(&mesh))?;
    let id = scene.stock.mesh(super::paths::name(&prim.path).to_owned(), mesh);
    let desc = PointsDesc { points: id, radius: None, radii };
    scene.place(ObjectContent::Shape(ShapeDesc::Points(desc)), Some(material), prim, state.transform)
}
