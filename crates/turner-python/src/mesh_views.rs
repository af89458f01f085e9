//! Arrays of meshes for Python, without a copy.
#![allow(unsafe_code)]

use std::sync::Arc;

use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use turner::schema::MeshData;

/// Keeps the lists of a mesh alive while arrays show them.
#[pyclass(frozen, module = "turner._turner")]
struct MeshOwner {
    mesh: Arc<MeshData>,
}

/// The lists of a mesh as read-only arrays that share its memory.
pub(crate) fn views(py: Python<'_>, mesh: Arc<MeshData>) -> PyResult<Bound<'_, PyDict>> {
    let owner = Bound::new(py, MeshOwner { mesh })?;
    let mesh = &owner.get().mesh;
    let out = PyDict::new(py);
    out.set_item("positions", view(&owner, mesh.positions.as_flattened(), 3)?)?;
    out.set_item("triangles", view(&owner, mesh.triangles.as_flattened(), 3)?)?;
    let lists: [(&str, &[f32], usize); 4] = [
        ("normals", mesh.normals.as_flattened(), 3),
        ("uvs", mesh.uvs.as_flattened(), 2),
        ("tangents", mesh.tangents.as_flattened(), 4),
        ("colors", mesh.colors.as_flattened(), 4),
    ];
    for (name, list, columns) in lists {
        if !list.is_empty() {
            out.set_item(name, view(&owner, list, columns)?)?;
        }
    }
    if !mesh.face_materials.is_empty() {
        let column = view(&owner, &mesh.face_materials, 1)?;
        out.set_item("face_materials", column.call_method1("reshape", (-1,))?)?;
    }
    Ok(out)
}

fn view<'py, T: Element>(
    owner: &Bound<'py, MeshOwner>,
    list: &[T],
    columns: usize,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let rows = ArrayView2::from_shape((list.len() / columns, columns), list)
        .map_err(|e| pyo3::exceptions::PyValueError::new_err(e.to_string()))?;
    // SAFETY: `list` belongs to the mesh in `owner`, which is frozen and holds it by an `Arc`, so that it is neither moved
    // nor changed while the array refers to its owner; the array is made read-only before Python sees it.
    let array = unsafe { PyArray2::borrow_from_array(&rows, owner.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    Ok(array)
}
