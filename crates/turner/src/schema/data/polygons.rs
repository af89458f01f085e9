//! Polygons of a mesh, which is stored as triangles.

use super::MeshData;

impl MeshData {
    /// The number of polygons.
    pub fn polygon_count(&self) -> usize {
        if self.polygons.is_empty() { self.triangles.len() } else { self.polygons.len() }
    }

    /// The triangles of each polygon.
    pub fn polygon_triangles(&self) -> impl Iterator<Item = &[[u32; 3]]> {
        let mut rest = self.triangles.as_slice();
        let mut sizes = self.polygons.iter();
        std::iter::from_fn(move || {
            let size = sizes.next().map_or(1, |n| *n as usize);
            let (polygon, after) = rest.split_at_checked(size.max(1))?;
            rest = after;
            Some(polygon)
        })
    }

    /// The corners of each polygon, if all are fans around their first corner, as triangles are.
    pub fn fans(&self) -> Option<Vec<Vec<u32>>> {
        self.polygon_triangles().map(fan).collect()
    }
}

/// The corners of a polygon whose triangles are a fan around its first corner.
pub fn fan(triangles: &[[u32; 3]]) -> Option<Vec<u32>> {
    let [center, first, _] = *triangles.first()?;
    let mut corners = vec![center, first];
    for &[a, b, c] in triangles {
        if a != center || corners.last() != Some(&b) {
            return None;
        }
        corners.push(c);
    }
    Some(corners)
}

/// The corners of a polygon with n − 2 triangles, in the order of its triangles' corners; `None` if the triangles are
/// not those of one polygon, or a corner occurs twice.
pub fn boundary(triangles: &[[u32; 3]]) -> Option<Vec<u32>> {
    if let Some(corners) = fan(triangles) {
        return Some(corners);
    }
    let mut edges: Vec<(u32, u32)> =
        triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]).collect();
    edges.sort_unstable();
    let outer = |e: &&(u32, u32)| edges.binary_search(&(e.1, e.0)).is_err();
    let next: Vec<(u32, u32)> = edges.iter().filter(outer).copied().collect();
    if next.len() != triangles.len() + 2 {
        return None;
    }
    let first = triangles.first()?[0];
    let (mut corners, mut at) = (Vec::with_capacity(next.len()), first);
    loop {
        corners.push(at);
        at = next.get(next.binary_search_by_key(&at, |e| e.0).ok()?)?.1;
        if at == first || corners.len() > next.len() {
            break;
        }
    }
    (corners.len() == next.len()).then_some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_are_found_in_their_triangles() {
        assert_eq!(boundary(&[[4, 5, 6]]), Some(vec![4, 5, 6]));
        assert_eq!(boundary(&[[0, 1, 2], [0, 2, 3]]), Some(vec![0, 1, 2, 3]));
        // The other diagonal, and ears of a hexagon.
        assert_eq!(boundary(&[[0, 1, 3], [1, 2, 3]]), Some(vec![0, 1, 2, 3]));
        assert_eq!(boundary(&[[5, 0, 1], [1, 2, 3], [3, 4, 5], [5, 1, 3]]), Some(vec![5, 0, 1, 2, 3, 4]));
        // Two triangles that share only a corner, or are oriented against each other, or are the same.
        for no_polygon in [[[0, 1, 2], [2, 3, 4]], [[0, 1, 2], [0, 3, 2]], [[0, 1, 2], [1, 2, 0]]] {
            assert_eq!(boundary(&no_polygon), None, "{no_polygon:?}");
        }
        assert_eq!(boundary(&[]), None);
    }

    #[test]
    fn lists_of_polygons() {
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]];
        let mut mesh = MeshData { positions: vec![[0.0; 3]; 7], triangles, ..MeshData::default() };
        assert_eq!((mesh.polygon_count(), mesh.polygon_triangles().count()), (3, 3));
        mesh.polygons = vec![2, 1];
        mesh.check().unwrap();
        assert_eq!(mesh.fans(), Some(vec![vec![0, 1, 2, 3], vec![4, 5, 6]]));
        for bad in [vec![2], vec![2, 2], vec![3, 0], vec![u32::MAX, u32::MAX]] {
            mesh.polygons = bad;
            assert!(mesh.check().unwrap_err().message.contains("polygons"));
        }
    }
}
