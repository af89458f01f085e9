//! Colours of vertices or faces by the name that Mitsuba gives them.
//!
//! An attribute is `vertex_` or `face_` and a name. `color` are the properties `r g b` or `red green blue`, `NAME_color`
//! those with the postfixes `_r _g _b`, and `NAME` those with `_x _y _z`, `_0 _1 _2` or `_1 _2 _3`. One property
//! alone, with the first postfix, is grey. Values are not decoded.

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

/// The properties of red, green and blue.
fn columns(element: &Element, name: &str) -> Option<[usize; 3]> {
    let of = |wanted: &str| element.properties.iter().position(|p| p.name == wanted && p.count.is_none());
    let three = |names: [String; 3]| {
        let [r, g, b] = names.map(|n| of(&n));
        Some([r?, g?, b?])
    };
    let with = |prefix: &str, ends: [&str; 3]| three(ends.map(|end| format!("{prefix}_{end}")));
    let one = |name: String| of(&name).map(|i| [i; 3]);
    let plain = || {
        let full = with(name, ["x", "y", "z"]).or_else(|| with(name, ["0", "1", "2"]));
        let full = full.or_else(|| with(name, ["1", "2", "3"]));
        full.or_else(|| one(format!("{name}_x"))).or_else(|| one(format!("{name}_0")))
    };
    if name == "color" {
        let short = three(["r", "g", "b"].map(str::to_owned));
        let long = || three(["red", "green", "blue"].map(str::to_owned));
        return short.or_else(long).or_else(plain);
    }
    match name.strip_suffix("_color") {
        Some(prefix) => with(prefix, ["r", "g", "b"]).or_else(|| one(format!("{prefix}_r"))).or_else(plain),
        None => plain(),
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
