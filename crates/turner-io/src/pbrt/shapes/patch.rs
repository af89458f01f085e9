//! Bilinear patches: parallelograms are two triangles, others are tessellated.

use turner::math::{DVec2, DVec3};
use turner::schema::{ErrorCode, MeshData};

use super::super::assembly::Assembly;
use super::super::params::Params;
use super::super::report::Fault;
use super::super::state::State;
use super::light_parts::LightParts;
use super::mesh::{corners, fitting};
use super::{Made, orient};

/// Quads along each side of a tessellated patch.
const PARTS: u32 = 12;

/// `bilinearmesh`: corners in the order (0, 0), (1, 0), (0, 1), (1, 1).
pub(super) fn patches(scene: &mut Assembly<'_>, state: &State, params: &mut Params) -> Result<Made, Fault> {
    let positions = params.take_triples("P");
    let count = positions.len();
    let patches: Vec<[u32; 4]> = if params.has("indices") {
        corners(params, "indices", count)?
    } else if count == 4 {
        params.pass(&["indices"]);
        vec![[0, 1, 2, 3]]
    } else {
        let message = format!("a bilinearmesh of {count} vertices needs \"integer indices\"");
        return Err(Fault::at(params.place, ErrorCode::MissingKey, message));
    };
    let normals = params.take_triples("N");
    let uvs = params.take_pairs("uv");
    params.pass(&["faceIndices"]);
    if params.has("emissionfilename") {
        params.pass(&["emissionfilename"]);
        scene.report.ignored(params.place_of("emissionfilename"), "the image of an emissive patch");
    }
    let normals = fitting(scene, params, "N", normals, count);
    let uvs = fitting(scene, params, "uv", uvs, count);
    let mut data = MeshData::default();
    let mut lights = Vec::new();
    let single = |v: DVec3| v.as_vec3().to_array();
    for patch in &patches {
        let p =
            patch.map(|i| DVec3::from(positions.get(i as usize).copied().unwrap_or_default().map(f64::from)));
        let [a, b, c, d] = p;
        let size = (b - a).length().max((c - a).length()).max((d - a).length());
        let is_flat = ((b - a).cross(c - a).dot(d - a)).abs() <= 1e-5 * size * size * size;
        // A flat patch that is not a parallelogram has a nonlinear (u, v) inside.
        let parts = if is_flat && (d - b - (c - a)).length() <= 1e-4 * size { 1 } else { PARTS };
        if parts > 1 {
            scene.divide(u64::from(parts + 1) * u64::from(parts + 1), params.place)?;
        }
        let area = light_area(p.map(|p| state.ctm[0].transform_vector3(p)));
        lights.push((2 * (parts * parts) as usize, area));
        let first = data.positions.len() as u32;
        let own =
            |list: &[[f32; 2]], i: usize, or: DVec2| match patch.get(i).and_then(|v| list.get(*v as usize)) {
                Some(uv) => DVec2::new(f64::from(uv[0]), f64::from(uv[1])),
                None => or,
            };
        let uv = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        let uv = [0, 1, 2, 3].map(|i| own(&uvs, i, uv[i]));
        for j in 0..=parts {
            for i in 0..=parts {
                let (u, v) = (f64::from(i) / f64::from(parts), f64::from(j) / f64::from(parts));
                let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
                let point = p.iter().zip(weights).fold(DVec3::ZERO, |sum, (p, w)| sum + *p * w);
                data.positions.push(single(point));
                let at = uv.iter().zip(weights).fold(DVec2::ZERO, |sum, (p, w)| sum + *p * w);
                data.uvs.push(at.as_vec2().to_array());
                let normal = if normals.is_empty() {
                    let along = (b - a) * (1.0 - v) + (d - c) * v;
                    let across = (c - a) * (1.0 - u) + (d - b) * u;
                    along.cross(across)
                } else {
                    let n = |i: u32| {
                        DVec3::from(normals.get(i as usize).copied().unwrap_or_default().map(f64::from))
                    };
                    patch.iter().zip(weights).fold(DVec3::ZERO, |sum, (i, w)| sum + n(*i) * w)
                };
                data.normals.push(single(normal.normalize_or(DVec3::Z)));
            }
        }
        for j in 0..parts {
            for i in 0..parts {
                let a = first + j * (parts + 1) + i;
                let (b, c, d) = (a + 1, a + parts + 1, a + parts + 2);
                data.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    orient(&mut data, state.reverse);
    Ok(Made::Mesh(data, LightParts::Runs(lights)))
}

/// The area with which pbrt divides the power of a patch: that of a rectangle, or the sum over three by three quads of
/// the cross products of their diagonals. p00, p10, p01, p11.
fn light_area([a, b, c, d]: [DVec3; 4]) -> f64 {
    const QUADS: u32 = 3;
    let point = |i: u32, j: u32| {
        let (u, v) = (f64::from(i) / f64::from(QUADS), f64::from(j) / f64::from(QUADS));
        a.lerp(c, v).lerp(b.lerp(d, v), u)
    };
    let quad = |(i, j): (u32, u32)| {
        let (rising, falling) = (point(i + 1, j + 1) - point(i, j), point(i + 1, j) - point(i, j + 1));
        0.5 * rising.cross(falling).length()
    };
    (0..QUADS).flat_map(|i| (0..QUADS).map(move |j| (i, j))).map(quad).sum()
}
