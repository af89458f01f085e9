//! Colours of vertices or faces by the name that Mitsuba gives them.
//!
//! An attribute is `vertex_` or `face_` and a name. `color` are the properties `r g b` or `red green blue`, `NAME_color`
//! those with the postfixes `_r _g _b`, and `NAME` those with `_x _y _z`, `_0 _1 _2` or `_1 _2 _3`. One property
//! alone, with the first postfix, is grey; two or four are no colour. Values are not decoded.

use super::header::{self, Element};
use super::values::Values;
use super::{Fail, check_count, skip, skip_list};
use crate::mesh::{Place, error};

/// What an attribute belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Of {
    /// Vertices: colours are interpolated.
    Vertices,
    /// Faces: colours are constant on each.
    Faces,
}

impl Of {
    /// What an attribute belongs to, and the rest of its name.
    pub(crate) fn split(name: &str) -> Option<(Of, &str)> {
        let vertices = name.strip_prefix("vertex_").map(|rest| (Of::Vertices, rest));
        vertices.or_else(|| name.strip_prefix("face_").map(|rest| (Of::Faces, rest)))
    }
}

/// The colours of an attribute, one for each vertex or face of the file; `None` if it has none of this name.
///
/// Errors, as text: damaged files.
pub(crate) fn read(bytes: &[u8], of: Of, name: &str) -> Result<Option<Vec<[f32; 3]>>, String> {
    all(bytes, of, name).map_err(|fail| match fail.place {
        Place::Line(line) => format!("line {line}: {}", fail.problem),
        Place::Byte(at) => format!("byte {at}: {}", fail.problem),
    })
}

fn all(bytes: &[u8], of: Of, name: &str) -> Result<Option<Vec<[f32; 3]>>, Fail> {
    let header = header::read(bytes)?;
    let mut data = Values::new(bytes, header.len, header.lines + 1, header.encoding);
    for element in &header.elements {
        check_count(element, header.encoding, &data)?;
        let is_wanted = element.name == if of == Of::Vertices { "vertex" } else { "face" };
        if !is_wanted {
            skip(element, &mut data)?;
            continue;
        }
        let Some(columns) = columns(element, name) else { return Ok(None) };
        return values(element, columns, &mut data).map(Some);
    }
    Ok(None)
}

/// The postfixes of properties that belong together, in the order in which they are looked up.
const POSTFIXES: [[&str; 4]; 3] = [["x", "y", "z", "w"], ["0", "1", "2", "3"], ["1", "2", "3", "4"]];

/// The properties of red, green and blue. `None` if there are none, or two or four that belong together.
fn columns(element: &Element, name: &str) -> Option<[usize; 3]> {
    let of = |wanted: &str| element.properties.iter().position(|p| p.name == wanted && p.count.is_none());
    let three = |names: [&str; 3]| {
        let [r, g, b] = names.map(of);
        Some([r?, g?, b?])
    };
    let starts = |prefix: &str, ends: &[&str; 4]| of(&format!("{prefix}_{}", ends[0])).is_some();
    let with = |prefix: &str, ends: &[&str; 4]| match ends.map(|end| of(&format!("{prefix}_{end}"))) {
        [Some(r), Some(g), Some(b), None] => Some([r, g, b]),
        [Some(grey), None, ..] => Some([grey; 3]),
        _ => None,
    };
    let plain = || with(name, POSTFIXES.iter().find(|ends| starts(name, ends))?);
    if name == "color" {
        let short = three(["r", "g", "b"]);
        return short.or_else(|| three(["red", "green", "blue"])).or_else(plain);
    }
    const COLOR: [&str; 4] = ["r", "g", "b", "a"];
    match name.strip_suffix("_color") {
        Some(prefix) if starts(prefix, &COLOR) => with(prefix, &COLOR),
        _ => plain(),
    }
}

fn values(element: &Element, columns: [usize; 3], data: &mut Values<'_>) -> Result<Vec<[f32; 3]>, Fail> {
    let mut out = Vec::new();
    let memory = error::reserve(&mut out, element.count, "");
    memory.map_err(|_| data.fail(format!("not enough memory for {} colours", element.count)))?;
    let mut row = vec![0.0f64; element.properties.len()];
    for _ in 0..element.count {
        for (property, value) in element.properties.iter().zip(&mut row) {
            match property.count {
                None => *value = data.next(property.item)?,
                Some(count) => skip_list(count, property.item, data)?,
            }
        }
        let value = |i: usize| row.get(i).map_or(0.0, |v| *v as f32);
        out.push(columns.map(|i| if value(i).is_finite() { value(i).max(0.0) } else { 0.0 }));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                        property float warm_r\nproperty float warm_g\nproperty float warm_b\nproperty float heat_x\n\
                        element face 1\nproperty list uchar int vertex_indices\nproperty float red\n\
                        property float green\nproperty float blue\nproperty float id_0\nproperty float id_1\n\
                        property float id_2\nend_header\n0 0 0 1 2 3 9\n1 0 0 4 5 6 8\n0 1 0 7 8 nan -7\n\
                        3 0 1 2 0.5 0.25 0.125 5 6 7\n";

    /// One and three properties are colours; two and four are not, except for `r g b a`.
    #[test]
    fn the_number_of_properties_counts() {
        let found = |names: &str, wanted: &str| {
            let properties: String =
                names.split_whitespace().map(|name| format!("property float {name}\n")).collect();
            let values: String = (1..=names.split_whitespace().count()).map(|i| format!("{i} ")).collect();
            let file = format!("ply\nformat ascii 1.0\nelement vertex 1\n{properties}end_header\n{values}\n");
            read(file.as_bytes(), Of::Vertices, wanted).unwrap().map(|colors| colors[0])
        };
        for (names, wanted, expected) in [
            ("a_1", "a", Some([1.0; 3])),
            ("a_0 a_1 a_2", "a", Some([1.0, 2.0, 3.0])),
            ("a_1 a_2 a_3", "a", Some([1.0, 2.0, 3.0])),
            ("a_0 a_1", "a", None),
            ("a_0 a_1 a_2 a_3", "a", None),
            ("a_1 a_2 a_3 a_4", "a", None),
            ("a_x a_y", "a", None),
            ("a_x a_y a_z a_w", "a", None),
            ("a_r", "a_color", Some([1.0; 3])),
            ("a_r a_g", "a_color", None),
            ("a_r a_g a_b a_a", "a_color", None),
            ("r g b a", "color", Some([1.0, 2.0, 3.0])),
            ("color_0 color_1 color_2", "color", Some([1.0, 2.0, 3.0])),
        ] {
            assert_eq!(found(names, wanted), expected, "{names}");
        }
    }

    #[test]
    fn attributes_have_the_names_of_mitsuba() {
        let found = |name: &str| {
            let (of, rest) = Of::split(name).unwrap();
            read(FILE.as_bytes(), of, rest).unwrap()
        };
        assert_eq!(found("face_color"), Some(vec![[0.5, 0.25, 0.125]]));
        assert_eq!(found("face_id"), Some(vec![[5.0, 6.0, 7.0]]));
        let warm = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 0.0]];
        assert_eq!(found("vertex_warm_color"), Some(warm));
        assert_eq!(found("vertex_heat"), Some(vec![[9.0; 3], [8.0; 3], [0.0; 3]]));
        assert_eq!((found("vertex_color"), found("face_heat"), found("vertex_warm")), (None, None, None));
        assert_eq!(Of::split("color"), None);
        for cut in 0..FILE.len() - 2 {
            let _ = read(&FILE.as_bytes()[..cut], Of::Faces, "color");
        }
        assert!(read(&FILE.as_bytes()[..FILE.len() - 20], Of::Faces, "color").is_err());
    }
}
