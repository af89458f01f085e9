//! Which parts of a shape are lights. In pbrt each shape is one light, and each triangle or patch of a mesh is a shape
//! of its own. `power` is that of each light, so that the radiance of a part follows from its area.

use std::collections::BTreeMap;

use turner::math::{DMat3, DVec3};
use turner::schema::MeshData;

/// Most lights of different areas in a mesh; areas that differ little become one.
const MAX_AREAS: usize = 4096;

/// The lights of a shape.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::pbrt) enum LightParts {
    /// The whole shape, of this area.
    Whole(f64),
    /// Each triangle.
    Triangles,
    /// Consecutive triangles: how many, and the area of their light.
    Runs(Vec<(usize, f64)>),
}

impl LightParts {
    /// The areas of the lights, each at most once, and the index of each triangle's area, if there are several.
    pub(super) fn areas(&self, data: &MeshData, m: &DMat3) -> (Vec<f64>, Vec<u16>) {
        let of_triangles: Vec<f64> = match self {
            LightParts::Whole(area) => return (vec![*area], Vec::new()),
            LightParts::Triangles => data.triangles.iter().map(|t| triangle_area(data, t, m)).collect(),
            LightParts::Runs(runs) => {
                let each = runs.iter().flat_map(|&(count, area)| std::iter::repeat_n(area, count));
                each.take(data.triangles.len()).collect()
            }
        };
        // The last bits of single-precision corners say nothing. Few bits are kept only where there are too many areas.
        for dropped in [8, 12, 16, 20, 23] {
            if let Some(found) = grouped(&of_triangles, dropped) {
                return found;
            }
        }
        (vec![of_triangles.iter().sum::<f64>() / of_triangles.len().max(1) as f64], Vec::new())
    }
}

/// Groups areas that are equal but for the last `dropped` bits of their single-precision values; `None` if these are too
/// many. Triangles of area 0, which emit nothing, are in the first group.
fn grouped(of_triangles: &[f64], dropped: u32) -> Option<(Vec<f64>, Vec<u16>)> {
    let half = if dropped > 0 { 1 << (dropped - 1) } else { 0 };
    let key = |area: f64| ((area as f32).to_bits() + half) >> dropped;
    // Number, sum and count of each group.
    let mut groups: BTreeMap<u32, (u16, f64, f64)> = BTreeMap::new();
    for &area in of_triangles.iter().filter(|a| **a > 0.0) {
        let next = groups.len() as u16;
        let group = groups.entry(key(area)).or_insert((next, 0.0, 0.0));
        (group.1, group.2) = (group.1 + area, group.2 + 1.0);
        if groups.len() > MAX_AREAS {
            return None;
        }
    }
    let mut areas = vec![0.0; groups.len()];
    for &(number, sum, count) in groups.values() {
        if let Some(area) = areas.get_mut(usize::from(number)) {
            *area = sum / count;
        }
    }
    if areas.len() < 2 {
        return Some((areas, Vec::new()));
    }
    let number = |area: &f64| groups.get(&key(*area)).map_or(0, |group| group.0);
    Some((areas, of_triangles.iter().map(number).collect()))
}

/// The area of a transformed triangle.
fn triangle_area(data: &MeshData, triangle: &[u32; 3], m: &DMat3) -> f64 {
    let [a, b, c] = triangle.map(|i| {
        let p = data.positions.get(i as usize).copied().unwrap_or_default();
        *m * DVec3::from(p.map(f64::from))
    });
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_grouped() {
        let (areas, of) = grouped(&[2.0, 1.0, 0.0, 2.0 + 1e-9, 4.0], 8).unwrap();
        assert_eq!(of, [0, 1, 0, 0, 2]);
        assert!((areas[0] - 2.0).abs() < 1e-8 && areas[1..] == [1.0, 4.0], "{areas:?}");
        let many: Vec<f64> = (0..100_000).map(|i| 1.0 + f64::from(i)).collect();
        let data = MeshData { triangles: vec![[0; 3]; many.len()], ..MeshData::default() };
        let runs = LightParts::Runs(many.iter().map(|&area| (1, area)).collect());
        let (areas, of) = runs.areas(&data, &DMat3::IDENTITY);
        assert!(areas.len() <= MAX_AREAS && of.len() == many.len());
        for (area, &group) in many.iter().zip(&of) {
            assert!((areas[usize::from(group)] / area - 1.0).abs() < 4e-3);
        }
    }
}
