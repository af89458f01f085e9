//! The value types of attributes.

/// What the components of a type are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Base {
    Bool,
    Int,
    Single,
    Double,
    Text,
    Asset,
    Dictionary,
    /// A type without effect on a picture.
    Unknown,
}

/// A type: the base, the number of components, and whether it is an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Type {
    pub(super) base: Base,
    pub(super) width: usize,
    pub(super) is_array: bool,
}

impl Type {
    /// The type with a name such as `point3f`.
    pub(super) fn of(name: &str, is_array: bool) -> Type {
        let (base, width) = match name {
            "bool" => (Base::Bool, 1),
            "uchar" | "int" | "uint" | "int64" | "uint64" => (Base::Int, 1),
            "int2" => (Base::Int, 2),
            "int3" => (Base::Int, 3),
            "int4" => (Base::Int, 4),
            "half" | "float" => (Base::Single, 1),
            "double" | "timecode" => (Base::Double, 1),
            "string" | "token" | "pathExpression" => (Base::Text, 1),
            "asset" => (Base::Asset, 1),
            "dictionary" => (Base::Dictionary, 1),
            "matrix2d" => (Base::Double, 4),
            "matrix3d" => (Base::Double, 9),
            "matrix4d" | "frame4d" => (Base::Double, 16),
            "quath" | "quatf" => (Base::Single, 4),
            "quatd" => (Base::Double, 4),
            _ => vector(name).unwrap_or((Base::Unknown, 1)),
        };
        Type { base, width, is_array }
    }
}

/// `float3`, `texCoord2f` and the like.
fn vector(name: &str) -> Option<(Base, usize)> {
    let stem = name.trim_end_matches(['f', 'h', 'd']);
    let role = stem.trim_end_matches(['2', '3', '4']);
    let width = match stem.strip_prefix(role)? {
        "2" => 2,
        "3" => 3,
        "4" => 4,
        _ => return None,
    };
    let precision = name.strip_prefix(stem)?;
    let base = match (role, precision) {
        ("float" | "half", "") => Base::Single,
        ("double", "") => Base::Double,
        ("point" | "normal" | "vector" | "color" | "texCoord", "f" | "h") => Base::Single,
        ("point" | "normal" | "vector" | "color" | "texCoord", "d") => Base::Double,
        _ => return None,
    };
    Some((base, width))
}
