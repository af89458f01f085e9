//! Primitive modes (glTF 2.0 §3.7.2.1): converts lists, strips, loops and fans to plain lists.

use super::accessors::Elements;
use super::budget::Budget;
use super::fault::{Fault, Outcome};

/// The elements of a primitive, as vertex indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Topology {
    /// Points.
    Points(Vec<u32>),
    /// Line segments.
    Lines(Vec<[u32; 2]>),
    /// Triangles, counter-clockwise seen from the front.
    Triangles(Vec<[u32; 3]>),
}

/// The vertex sequence of a primitive: its indices, or 0 to `count` without indices.
fn order(indices: Option<Elements<'_>>, count: usize, budget: &Budget, pointer: &str) -> Outcome<Vec<u32>> {
    let Some(indices) = indices else {
        let last = u32::try_from(count).map_err(|_| {
            Fault::too_large(pointer, format!("has {count} vertices; expected fewer than 2^32"))
        })?;
        let mut list = budget.list(count, pointer)?;
        list.extend(0..last);
        return Ok(list);
    };
    let at = || format!("/accessors/{}", indices.accessor.0);
    if indices.width != 1 || !indices.is_unsigned() || indices.normalized {
        let message = "holds indices; expected SCALAR elements of unsigned bytes, shorts or ints";
        return Err(Fault::at(at(), message));
    }
    let mut list = budget.list(indices.count, pointer)?;
    for i in 0..indices.count {
        let vertex = indices.index(i);
        if vertex as usize >= count {
            return Err(Fault::at(at(), format!("index {i} is {vertex}, but there are {count} vertices")));
        }
        list.push(vertex);
    }
    Ok(list)
}

impl Topology {
    /// Reads a primitive with `count` vertices. An unknown mode is an error. Degenerate triangles of strips and
    /// fans, which repeat a vertex, only join parts and are dropped. The flag is true if vertices are left over.
    pub(super) fn read(
        mode: u32,
        indices: Option<Elements<'_>>,
        count: usize,
        budget: &Budget,
        pointer: &str,
    ) -> Outcome<(Topology, bool)> {
        let v = order(indices, count, budget, pointer)?;
        let lines = v.len().saturating_sub(usize::from(mode != 2)).max(v.len() / 2);
        let mut list;
        let mut left_over = false;
        match mode {
            0 => return Ok((Topology::Points(v), false)),
            1..=3 => {
                let mut segments = budget.list(lines, pointer)?;
                if mode == 1 {
                    let (pairs, rest) = v.as_chunks();
                    segments.extend_from_slice(pairs);
                    left_over = !rest.is_empty();
                } else {
                    segments.extend(v.windows(2).map(|w| [w[0], w[1]]));
                    if let (2, [first, .., last]) = (mode, &v[..]) {
                        segments.push([*last, *first]);
                    }
                }
                return Ok((Topology::Lines(segments), left_over));
            }
            4 => {
                let (triangles, rest) = v.as_chunks();
                list = budget.list(triangles.len(), pointer)?;
                list.extend_from_slice(triangles);
                left_over = !rest.is_empty();
            }
            5 | 6 => {
                list = budget.list(v.len().saturating_sub(2), pointer)?;
                let corners = v.windows(3).enumerate().map(|(i, w)| match (mode, i % 2) {
                    (6, _) => [w[1], w[2], v[0]],
                    (_, 0) => [w[0], w[1], w[2]],
                    _ => [w[0], w[2], w[1]],
                });
                list.extend(corners.filter(|[a, b, c]| a != b && b != c && c != a));
            }
            _ => {
                let message = format!("is {mode}; expected 0 to 6");
                return Err(Fault::at(format!("{pointer}/mode"), message));
            }
        }
        Ok((Topology::Triangles(list), left_over))
    }

    /// The triangles of a Draco mesh of a primitive with `count` vertices.
    pub(super) fn of_faces(
        faces: &[[u32; 3]],
        count: usize,
        budget: &Budget,
        pointer: &str,
    ) -> Outcome<(Topology, bool)> {
        if let Some(vertex) = faces.as_flattened().iter().find(|vertex| **vertex as usize >= count) {
            let message = format!("its Draco mesh refers to vertex {vertex}, but there are {count}");
            return Err(Fault::at(pointer, message));
        }
        let mut list = budget.list(faces.len(), pointer)?;
        list.extend_from_slice(faces);
        Ok((Topology::Triangles(list), false))
    }

    /// Number of vertex references.
    fn corners(&self) -> usize {
        match self {
            Topology::Points(list) => list.len(),
            Topology::Lines(list) => 2 * list.len(),
            Topology::Triangles(list) => 3 * list.len(),
        }
    }

    fn flat(&mut self) -> &mut [u32] {
        match self {
            Topology::Points(list) => list,
            Topology::Lines(list) => list.as_flattened_mut(),
            Topology::Triangles(list) => list.as_flattened_mut(),
        }
    }

    /// If fewer vertices are referenced than `count`: returns the sorted list of referenced vertices and
    /// renumbers the references to positions in it. Primitives that share a large vertex buffer then store only
    /// their own vertices.
    pub(super) fn compact(
        &mut self,
        count: usize,
        budget: &Budget,
        pointer: &str,
    ) -> Outcome<Option<Vec<u32>>> {
        if self.corners() >= count {
            return Ok(None);
        }
        let mut used = budget.list::<u32>(self.corners(), pointer)?;
        used.extend_from_slice(self.flat());
        used.sort_unstable();
        used.dedup();
        for vertex in self.flat() {
            *vertex = used.binary_search(vertex).unwrap_or(0) as u32;
        }
        Ok(Some(used))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(mode: u32, count: usize) -> (Topology, bool) {
        Topology::read(mode, None, count, &Budget::of_file(0), "/p").unwrap()
    }

    #[test]
    fn every_mode_becomes_a_list() {
        assert_eq!(read(0, 2).0, Topology::Points(vec![0, 1]));
        assert_eq!(read(1, 5), (Topology::Lines(vec![[0, 1], [2, 3]]), true));
        assert_eq!(read(2, 3).0, Topology::Lines(vec![[0, 1], [1, 2], [2, 0]]));
        assert_eq!(read(3, 3).0, Topology::Lines(vec![[0, 1], [1, 2]]));
        assert_eq!(read(4, 7), (Topology::Triangles(vec![[0, 1, 2], [3, 4, 5]]), true));
        assert_eq!(read(5, 5).0, Topology::Triangles(vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]]));
        assert_eq!(read(6, 5).0, Topology::Triangles(vec![[1, 2, 0], [2, 3, 0], [3, 4, 0]]));
        for mode in 0..=6 {
            for count in 0..3 {
                read(mode, count);
            }
        }
        assert!(Topology::read(7, None, 3, &Budget::of_file(0), "/p").is_err());
    }

    #[test]
    fn unused_vertices_are_left_out() {
        let mut topology = Topology::Triangles(vec![[70, 50, 60], [60, 50, 90]]);
        let used = topology.compact(1000, &Budget::of_file(0), "/p").unwrap();
        assert_eq!(used, Some(vec![50, 60, 70, 90]));
        assert_eq!(topology, Topology::Triangles(vec![[2, 0, 1], [1, 0, 3]]));
        assert_eq!(topology.compact(5, &Budget::of_file(0), "/p").unwrap(), None);
    }
}
