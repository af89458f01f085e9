//! Curves without lights, as the shape "curves": those that follow one another with the same material and transform are
//! one object.

use std::sync::Arc;

use turner::description::ObjectContent;
use turner::math::DVec3;
use turner::schema::{MaterialId, MeshData, Transform};
use turner::shape::ShapeDesc;
use turner::shape::curves::{CurveBasis, CurveKind, CurvesDesc};

use super::super::assembly::Assembly;
use super::super::report::Fault;
use super::super::source::Place;
use super::super::state::State;

/// The last object of curves, to which further curves are added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Open {
    /// Number of objects with it, number of groups, and whether it is in an object definition.
    objects: usize,
    groups: usize,
    in_object: bool,
}

/// The Bézier points, widths and normals of one curve. The width changes linearly along it; `normals` are those at the ends
/// of the segments.
pub(super) fn fibre(segments: &[Vec<DVec3>], widths: [f64; 2], normals: Option<&[DVec3]>) -> MeshData {
    let single = |v: DVec3| v.as_vec3().to_array();
    let cubic = |s: &[DVec3]| match *s {
        [a, b, c] => [a, a.lerp(b, 2.0 / 3.0), c.lerp(b, 2.0 / 3.0), c],
        [a, b, c, d] => [a, b, c, d],
        _ => [DVec3::ZERO; 4],
    };
    let mut data = MeshData::default();
    for (i, segment) in segments.iter().enumerate() {
        let points = cubic(segment);
        data.positions.extend(points.iter().skip(usize::from(i > 0)).map(|p| single(*p)));
    }
    let count = data.positions.len();
    let along = |i: usize| i as f64 / (count.max(2) - 1) as f64;
    data.widths = (0..count).map(|i| (widths[0] + (widths[1] - widths[0]) * along(i)) as f32).collect();
    if let Some(normals) = normals {
        let at = |i: usize| normals.get((i + 1) / 3).or(normals.last()).copied().unwrap_or(DVec3::Z);
        data.normals = (0..count).map(|i| single(at(i))).collect();
    }
    data.strands = vec![count as u32];
    data
}

/// Adds a curve to the last object, or as a new object.
pub(super) fn place(
    scene: &mut Assembly<'_>,
    state: &State,
    (data, kind): (MeshData, CurveKind),
    material: Option<MaterialId>,
    in_object: bool,
    place: Place,
) -> Result<(), Fault> {
    /// Most points of one object.
    const MOST: usize = 1 << 29;
    let open = Open { objects: scene.objects.len(), groups: scene.groups.len(), in_object };
    if scene.open_curves == Some(open) && !data.positions.is_empty() {
        let last_mesh = scene.meshes.len().saturating_sub(1);
        let (start, end) = (Transform(state.ctm[0]), Transform(state.ctm[1]));
        let fits = scene.objects.last().is_some_and(|last| {
            let shape = match &last.content {
                ObjectContent::Shape(ShapeDesc::Curves(desc)) => {
                    desc.kind == kind && desc.curves.index() == last_mesh
                }
                _ => false,
            };
            let motion = (start != end).then_some(end);
            shape && last.material == material && last.transform == start && last.motion == motion
        });
        let known = scene.meshes.last_mut().and_then(|mesh| Arc::get_mut(&mut mesh.data));
        if let (true, Some(known)) = (fits, known)
            && known.normals.is_empty() == data.normals.is_empty()
            && known.positions.len() + data.positions.len() < MOST
        {
            known.positions.extend(data.positions);
            known.widths.extend(data.widths);
            known.normals.extend(data.normals);
            known.strands.extend(data.strands);
            return Ok(());
        }
    }
    let curves = scene.mesh(String::new(), data);
    let desc = CurvesDesc { curves, width: None, basis: CurveBasis::Bezier, kind };
    scene.place(ObjectContent::Shape(ShapeDesc::Curves(desc)), material, state, place)?;
    scene.open_curves = Some(Open { objects: scene.objects.len(), ..open });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pbrt::tests::world;
    use turner::material::MaterialDesc;

    /// Curves of one state are one object; another material, kind or transform begins a new one, as does an object
    /// definition.
    #[test]
    fn curves_that_follow_one_another_are_one_object() {
        let curve = |kind: &str| {
            format!(
                "Shape \"curve\" \"string type\" \"{kind}\" \"point3 P\" [0 0 0 1 0 0 2 1 0 3 0 0] \"float width0\" .4 \"float width1\" .1\n"
            )
        };
        let flat = curve("flat");
        let scene = world(&format!(
            "Material \"hair\" \"float eumelanin\" 2 \"float beta_m\" 0.5\n{flat}{flat}{}\
             Translate 1 0 0 {flat}\nMaterial \"diffuse\" {flat}{flat}\n\
             ObjectBegin \"a\" {flat} ObjectEnd ObjectInstance \"a\"",
            curve("cylinder")
        ));
        let data = |i: usize| {
            let ObjectContent::Shape(ShapeDesc::Curves(desc)) = &scene.objects[i].content else { panic!() };
            (desc.kind, scene.meshes[desc.curves.index()].data.clone())
        };
        let kinds: Vec<_> = (0..4).map(|i| (data(i).0, data(i).1.strands.len())).collect();
        use CurveKind::{Flat, Tube};
        assert_eq!(kinds, [(Flat, 2), (Tube, 1), (Flat, 1), (Flat, 2)]);
        assert_eq!(scene.groups[0].value.objects.len(), 1);
        let widths = &data(0).1.widths;
        assert!((widths[1] - 0.3).abs() < 1e-6 && widths[3] == 0.1 && widths[4] == 0.4, "{widths:?}");
        let found = scene.materials.iter().find_map(|m| match &m.value {
            MaterialDesc::Hair(hair) => Some(hair),
            _ => None,
        });
        let hair = found.unwrap();
        assert_eq!((hair.eumelanin, hair.pheomelanin, hair.beta_m, hair.beta_n), (2.0, 0.0, 0.5, 0.3));
    }

    /// A B-spline and a curve of degree 2 become the same cubic segments.
    #[test]
    fn segments_share_their_ends() {
        let line: Vec<DVec3> = (0..4).map(|i| DVec3::X * f64::from(i)).collect();
        let bend = vec![DVec3::X * 3.0, DVec3::new(4.0, 3.0, 0.0), DVec3::X * 5.0];
        let data = fibre(&[line, bend], [0.6, 0.0], Some(&[DVec3::Y, DVec3::Z, DVec3::X]));
        data.check().unwrap();
        assert_eq!(data.positions.len(), 7);
        assert_eq!(data.positions[5], [13.0 / 3.0, 2.0, 0.0]);
        assert_eq!(data.normals[3], [0.0, 0.0, 1.0]);
        assert_eq!(data.normals[6], [1.0, 0.0, 0.0]);
        assert!((data.widths[3] - 0.3).abs() < 1e-6 && data.widths[6] == 0.0);
    }
}
