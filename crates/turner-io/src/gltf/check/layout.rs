//! Alignment, strides and uses of buffer views (glTF 2.0 §3.6.2.4).

use super::add;
use super::walk::Faults;
use crate::gltf::accessors::layout;
use crate::gltf::json::{Accessor, Document, Index};

/// What a buffer view is used for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Use {
    Vertices,
    Indices,
    Matrices,
    Images,
}

pub(super) fn check(document: &Document, faults: &mut Faults) {
    for (i, view) in document.buffer_views.iter().enumerate() {
        if view.extensions.as_deref().is_some_and(|e| e.meshopt.is_some()) {
            continue;
        }
        let (stride, length) =
            (view.byte_stride.map_or(0, |s| s.0), view.byte_length.map_or(u64::MAX, |l| l.0));
        if stride > length {
            add(
                faults,
                "/bufferViews",
                i,
                "/byteStride",
                format!("is {stride}; expected at most byteLength, {length}"),
            );
        }
        if stride > 0 && view.target == Some(Index(34963)) {
            add(faults, "/bufferViews", i, "/byteStride", "is given for indices, which are contiguous");
        }
    }
    for (i, accessor) in document.accessors.iter().enumerate() {
        place(document, accessor, i, faults);
    }
    uses(document, faults);
}

/// Where an accessor lies in its buffer view.
fn place(document: &Document, accessor: &Accessor, i: usize, faults: &mut Faults) {
    let Some(view) = accessor.buffer_view.and_then(|v| document.buffer_views.get(v.index())) else { return };
    let component = accessor.component_type.map_or(0, |t| t.0);
    let Some([part, size, last, columns]) = layout(component, accessor.kind.as_deref().unwrap_or("")) else {
        return;
    };
    let offset = accessor.byte_offset.0;
    // The columns of matrices begin at multiples of four bytes of the buffer view.
    let unit = if columns > 1 { 4 } else { part };
    if !offset.is_multiple_of(unit) || !offset.saturating_add(view.byte_offset.0).is_multiple_of(part) {
        add(faults, "/accessors", i, "/byteOffset", format!("does not lead to a multiple of {unit} bytes"));
    }
    if view.extensions.as_deref().is_some_and(|e| e.meshopt.is_some()) {
        return;
    }
    let stride = view.byte_stride.map_or(size, |s| s.0);
    if stride < size {
        add(
            faults,
            "/accessors",
            i,
            "",
            format!("has elements of {size} bytes, more than byteStride, {stride}"),
        );
    }
    let before = accessor.count.map_or(0, |c| c.0).saturating_sub(1);
    let end = before.saturating_mul(stride).saturating_add(last).saturating_add(offset);
    if let Some(length) = view.byte_length.filter(|l| end > l.0) {
        add(faults, "/accessors", i, "", format!("ends at byte {end} of a buffer view of {}", length.0));
    }
}

/// Buffer views that are used for different things, or whose stride does not suit their use.
fn uses(document: &Document, faults: &mut Faults) {
    let mut of_views: Vec<Option<(Use, Index)>> = vec![None; document.buffer_views.len()];
    let mut note = |view: Index,
                    of: Use,
                    accessor: Index,
                    pointer: (usize, &str, String),
                    faults: &mut Faults| {
        let (i, list, member) = pointer;
        let Some(json) = document.buffer_views.get(view.index()) else { return };
        let has_stride =
            json.byte_stride.is_some() || json.extensions.as_deref().is_some_and(|e| e.meshopt.is_some());
        if of != Use::Vertices && json.byte_stride.is_some() {
            add(faults, list, i, &member, "is in a buffer view with a byteStride; expected contiguous data");
        }
        match of_views.get_mut(view.index()) {
            Some(known @ None) => *known = Some((of, accessor)),
            Some(Some((other, _))) if *other != of => {
                add(faults, list, i, &member, "is in a buffer view with data of another kind");
            }
            Some(Some((_, other))) if of == Use::Vertices && *other != accessor && !has_stride => {
                add(faults, list, i, &member, "shares a buffer view without a byteStride; expected one");
            }
            _ => {}
        }
    };
    let view_of = |accessor: Index| document.accessors.get(accessor.index()).and_then(|a| a.buffer_view);
    for (m, mesh) in document.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some((accessor, view)) = primitive.indices.and_then(|a| Some((a, view_of(a)?))) {
                let at = (m, "/meshes", format!("/primitives/{p}/indices"));
                note(view, Use::Indices, accessor, at, faults);
            }
            let targets = primitive.targets.iter().flatten();
            for (name, &accessor) in primitive.attributes.iter().chain(targets) {
                let Some(view) = view_of(accessor) else { continue };
                let member = format!("/primitives/{p}/attributes/{name}");
                if !is_aligned(document, accessor, view) {
                    add(faults, "/meshes", m, &member, "is not aligned to 4 bytes");
                }
                note(view, Use::Vertices, accessor, (m, "/meshes", member), faults);
            }
        }
    }
    for (i, skin) in document.skins.iter().enumerate() {
        if let Some((accessor, view)) = skin.inverse_bind_matrices.and_then(|a| Some((a, view_of(a)?))) {
            note(view, Use::Matrices, accessor, (i, "/skins", "/inverseBindMatrices".to_owned()), faults);
        }
    }
    for (i, view) in document.images.iter().enumerate().filter_map(|(i, image)| Some((i, image.buffer_view?)))
    {
        note(view, Use::Images, Index(u32::MAX), (i, "/images", "/bufferView".to_owned()), faults);
    }
}

/// Whether the offset and the stride of vertex data are multiples of four bytes.
fn is_aligned(document: &Document, accessor: Index, view: Index) -> bool {
    let Some(json) = document.accessors.get(accessor.index()) else { return true };
    let Some(view) = document.buffer_views.get(view.index()) else { return true };
    let component = json.component_type.map_or(0, |t| t.0);
    let Some([_, size, ..]) = layout(component, json.kind.as_deref().unwrap_or("")) else { return true };
    let stride = view.byte_stride.map_or(size, |s| s.0);
    let one = json.count.is_none_or(|c| c.0 < 2);
    json.byte_offset.0.is_multiple_of(4) && (one || stride.is_multiple_of(4))
}
