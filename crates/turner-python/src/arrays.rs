//! NumPy arrays as meshes, images and density grids. Each array is copied once, into the form of the renderer.

use std::collections::HashMap;
use std::sync::Arc;

use numpy::{Element, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use turner::color::srgb_decode;
use turner::image::{Image, Pixels};
use turner::schema::{GridData, MeshData};

/// The types of media and shapes whose `file` is a grid.
pub(crate) const GRIDS: [&str; 2] = ["grid", "distance_grid"];

/// Keys of a mesh that hold arrays. The first ones tell that a table is a mesh of arrays.
const LISTS: [&str; 10] = [
    "positions",
    "triangles",
    "polygons",
    "normals",
    "uvs",
    "uvs_1",
    "tangents",
    "colors",
    "face_materials",
    "radii",
];

/// The arrays of a scene or an edit, by the names that stand for them in its values.
#[derive(Debug, Default)]
pub(crate) struct Arrays {
    pub(crate) meshes: HashMap<String, Arc<MeshData>>,
    pub(crate) images: HashMap<String, Arc<Image>>,
    pub(crate) grids: HashMap<String, Arc<GridData>>,
}

/// An array in the memory order of C, of another type if need be.
fn in_order<T: Element + Copy>(array: &Bound<'_, PyAny>, kind: &str) -> PyResult<Vec<T>> {
    let ordered = array.py().import("numpy")?.call_method1("ascontiguousarray", (array, kind))?;
    let ordered = ordered.cast_into::<PyArrayDyn<T>>()?;
    Ok(ordered.to_vec()?)
}

/// The rows of an array of N columns.
fn rows<T: Element + Copy + Default, const N: usize>(
    array: &Bound<'_, PyAny>,
    kind: &str,
    place: &str,
) -> PyResult<Vec<[T; N]>> {
    let shape: Vec<usize> = array.py().import("numpy")?.call_method1("shape", (array,))?.extract()?;
    if !matches!(shape.as_slice(), [_, columns] if *columns == N) {
        return Err(PyValueError::new_err(format!(
            "{place}: an array of shape {shape:?}; expected (n, {N})"
        )));
    }
    let flat: Vec<T> = in_order(array, kind)?;
    Ok(flat.as_chunks::<N>().0.to_vec())
}

/// Whole numbers from 0, as `u32`.
fn indices(array: &Bound<'_, PyAny>, place: &str) -> PyResult<Vec<u32>> {
    let kind: String = array
        .py()
        .import("numpy")?
        .call_method1("asarray", (array,))?
        .getattr("dtype")?
        .getattr("kind")?
        .extract()?;
    if !matches!(kind.as_str(), "i" | "u") {
        return Err(PyTypeError::new_err(format!("{place}: expected an array of whole numbers")));
    }
    let wide: Vec<i64> = in_order(array, "int64")?;
    wide.into_iter()
        .map(|v| {
            u32::try_from(v).map_err(|_| {
                PyValueError::new_err(format!("{place}: {v} is no index; expected 0 to 4294967295"))
            })
        })
        .collect()
}

fn columns(array: &Bound<'_, PyAny>, place: &str) -> PyResult<usize> {
    let shape: Vec<usize> = array.py().import("numpy")?.call_method1("shape", (array,))?.extract()?;
    match shape.as_slice() {
        [_, columns] => Ok(*columns),
        _ => Err(PyValueError::new_err(format!(
            "{place}: an array of shape {shape:?}; expected two dimensions"
        ))),
    }
}

/// Whether a table is a mesh or a point cloud with an array among its lists.
pub(crate) fn is_mesh(dict: &Bound<'_, PyDict>) -> PyResult<bool> {
    let kind = dict.get_item("type")?;
    let is_mesh = kind.is_some_and(|kind| kind.str().is_ok_and(|kind| kind == "mesh" || kind == "points"));
    for key in LISTS {
        if is_mesh
            && let Some(list) = dict.get_item(key)?
            && list.cast::<PyUntypedArray>().is_ok()
        {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Colours of vertices: linear floats as they are, bytes decoded by the sRGB curve, as those of PLY files.
fn vertex_colors(array: &Bound<'_, PyAny>, place: &str) -> PyResult<Vec<[f32; 4]>> {
    let kind: String = array
        .py()
        .import("numpy")?
        .call_method1("asarray", (array,))?
        .getattr("dtype")?
        .getattr("name")?
        .extract()?;
    let decode = |v: f32| if kind == "uint8" { srgb_decode(v / 255.0) } else { v };
    let alpha = |v: f32| if kind == "uint8" { v / 255.0 } else { v };
    Ok(match columns(array, place)? {
        4 => rows::<f32, 4>(array, "float32", place)?
            .into_iter()
            .map(|[r, g, b, a]| [decode(r), decode(g), decode(b), alpha(a)])
            .collect(),
        _ => rows::<f32, 3>(array, "float32", place)?
            .into_iter()
            .map(|[r, g, b]| [decode(r), decode(g), decode(b), 1.0])
            .collect(),
    })
}

/// Takes the lists of a mesh into `arrays`. Returns the table with `file` in place of them.
pub(crate) fn take_mesh<'py>(
    dict: &Bound<'py, PyDict>,
    path: &str,
    arrays: &mut Arrays,
) -> PyResult<Bound<'py, PyDict>> {
    let out = dict.copy()?;
    let take = |key: &str| -> PyResult<Option<Bound<'py, PyAny>>> {
        let found = dict.get_item(key)?.filter(|list| !list.is_none());
        if found.is_some() {
            out.del_item(key)?;
        }
        Ok(found)
    };
    let at = |key: &str| format!("{path}.{key}");
    let mut mesh = MeshData::default();
    let Some(positions) = take("positions")? else {
        return Err(PyValueError::new_err(format!("{path}: a mesh of arrays needs `positions`")));
    };
    mesh.positions = rows(&positions, "float32", &at("positions"))?;
    if let Some(list) = take("triangles")? {
        if columns(&list, &at("triangles"))? != 3 {
            let message =
                format!("{}: expected three indices in each row; give others as `polygons`", at("triangles"));
            return Err(PyValueError::new_err(message));
        }
        mesh.triangles = indices(&list, &at("triangles"))?.as_chunks::<3>().0.to_vec();
    }
    if let Some(list) = take("polygons")?.filter(|_| mesh.triangles.is_empty()) {
        let sides = columns(&list, &at("polygons"))?;
        if sides < 3 {
            return Err(PyValueError::new_err(format!(
                "{}: a polygon has at least three corners",
                at("polygons")
            )));
        }
        for polygon in indices(&list, &at("polygons"))?.chunks_exact(sides) {
            mesh.triangles.extend((1..sides - 1).map(|i| [polygon[0], polygon[i], polygon[i + 1]]));
            mesh.polygons.push(sides as u32 - 2);
        }
        if sides == 3 {
            mesh.polygons.clear();
        }
    }
    if let Some(list) = take("normals")? {
        mesh.normals = rows(&list, "float32", &at("normals"))?;
    }
    if let Some(list) = take("uvs")? {
        mesh.uvs = rows(&list, "float32", &at("uvs"))?;
    }
    if let Some(list) = take("uvs_1")? {
        mesh.more_uvs.push(rows(&list, "float32", &at("uvs_1"))?);
    }
    if let Some(list) = take("tangents")? {
        mesh.tangents = rows(&list, "float32", &at("tangents"))?;
    }
    if let Some(list) = take("colors")? {
        mesh.colors = vertex_colors(&list, &at("colors"))?;
    }
    if let Some(list) = take("face_materials")? {
        let wide = indices(&list, &at("face_materials"))?;
        let narrow = |v: u32| {
            u16::try_from(v)
                .map_err(|_| PyValueError::new_err(format!("{}: {v} is above 65535", at("face_materials"))))
        };
        mesh.face_materials = wide.into_iter().map(narrow).collect::<PyResult<_>>()?;
    }
    mesh.check().map_err(|e| PyValueError::new_err(format!("{path}: {}", e.message)))?;
    let name = arrays.name("mesh");
    arrays.meshes.insert(name.clone(), Arc::new(mesh));
    out.set_item("file", name)?;
    Ok(out)
}

impl Arrays {
    /// A name that no file has.
    fn name(&self, kind: &str) -> String {
        format!("array:{kind}-{}", self.meshes.len() + self.images.len() + self.grids.len())
    }

    /// An image: (height, width) or (height, width, 1 to 4), row 0 at the top. `uint8` and `uint16` are encoded for a
    /// display, floats are linear.
    pub(crate) fn image(&mut self, array: &Bound<'_, PyUntypedArray>, path: &str) -> PyResult<String> {
        let shape = array.shape().to_vec();
        let (height, width, channels) = match *shape.as_slice() {
            [height, width] => (height, width, 1),
            [height, width, channels @ 1..=4] => (height, width, channels),
            _ => {
                let message = format!(
                    "{path}: an image of shape {shape:?}; expected (height, width) or (height, width, 1 to 4)"
                );
                return Err(PyValueError::new_err(message));
            }
        };
        let kind: String = array.getattr("dtype")?.getattr("name")?.extract()?;
        let pixels = match kind.as_str() {
            "uint8" => Pixels::U8(in_order(array, "uint8")?),
            "uint16" => Pixels::U16(in_order(array, "uint16")?),
            "float16" | "float32" | "float64" => Pixels::F32(in_order(array, "float32")?),
            other => {
                let message = format!("{path}: an image of {other}; expected uint8, uint16 or floats");
                return Err(PyTypeError::new_err(message));
            }
        };
        let too_large =
            |_| PyValueError::new_err(format!("{path}: an image of {width} x {height} pixels is too large"));
        let size = |v: usize| u32::try_from(v).map_err(too_large);
        let image = Image { width: size(width)?, height: size(height)?, channels: channels as u8, pixels };
        if !image.is_consistent() {
            return Err(PyValueError::new_err(format!("{path}: the image is empty")));
        }
        let name = self.name("image");
        self.images.insert(name.clone(), Arc::new(image));
        Ok(name)
    }

    /// A grid, (z, y, x): densities, or distances if some are negative.
    pub(crate) fn grid(&mut self, array: &Bound<'_, PyUntypedArray>, path: &str) -> PyResult<String> {
        let &[z, y, x] = array.shape() else {
            return Err(PyValueError::new_err(format!("{path}: expected a grid of shape (z, y, x)")));
        };
        let size = |v: usize| u32::try_from(v).unwrap_or(u32::MAX);
        let (size, values) = ([size(x), size(y), size(z)], in_order::<f32>(array, "float32")?);
        let has_distances = values.iter().any(|v| *v < 0.0);
        let grid = if has_distances {
            GridData::of_distances(size, values)
        } else {
            GridData::new(size, values, None)
        };
        let grid = grid.map_err(|e| PyValueError::new_err(format!("{path}: {e}")))?;
        let name = self.name("grid");
        self.grids.insert(name.clone(), Arc::new(grid));
        Ok(name)
    }
}
