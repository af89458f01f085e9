//! Python's values as the scene format's, and back.

use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyList, PyString};
use turner::schema::value::{Data, Entry, Table, Value};

use crate::arrays::{self, Arrays};
use crate::places::Places;

/// The deepest nesting of values, as in scene files.
const MAX_DEPTH: usize = 64;

/// The most elements of an array that becomes a list. Arrays of meshes, images and grids are not limited by it.
const MAX_LIST: usize = 1 << 22;

/// Reads values of Python.
pub(crate) struct Converter<'a> {
    /// Names values for messages.
    pub(crate) places: &'a Places,
    /// Takes the arrays that become meshes, images and grids.
    pub(crate) arrays: &'a mut Arrays,
}

impl Converter<'_> {
    /// The value of an object; `None` for Python's None, which stands for a missing key. `path` is its place for messages.
    ///
    /// Errors: objects that are no values of a scene; nesting that is too deep.
    pub(crate) fn value(&mut self, object: &Bound<'_, PyAny>, path: &str) -> PyResult<Option<Value>> {
        self.nested(object, path, "", 0)
    }

    fn nested(
        &mut self,
        object: &Bound<'_, PyAny>,
        path: &str,
        key: &str,
        depth: usize,
    ) -> PyResult<Option<Value>> {
        if depth > MAX_DEPTH {
            let start: String = path.chars().take(80).collect();
            return Err(PyValueError::new_err(format!("{start}…: values nest deeper than {MAX_DEPTH}")));
        }
        if object.is_none() {
            return Ok(None);
        }
        let plain = match object.getattr_opt("_plain_")? {
            Some(plain) => plain.call0()?,
            None => object.clone(),
        };
        let data = if let Ok(flag) = plain.cast::<PyBool>() {
            Data::Bool(flag.is_true())
        } else if let Ok(text) = plain.cast::<PyString>() {
            Data::String(text.to_str()?.to_owned())
        } else if let Ok(number) = plain.cast::<PyFloat>() {
            Data::Number(number.extract()?)
        } else if let Ok(number) = plain.cast::<PyInt>() {
            match number.extract::<i64>() {
                Ok(number) => Data::Integer(number),
                Err(_) => Data::Number(number.extract()?),
            }
        } else if let Ok(dict) = plain.cast::<PyDict>() {
            self.table(dict, path, depth)?
        } else if let Ok(array) = plain.cast::<PyUntypedArray>() {
            return self.array(array, path, key, depth);
        } else if plain.is_instance_of::<PyBytes>() {
            return Err(unknown(&plain, path));
        } else if plain.hasattr("__fspath__")? {
            Data::String(plain.call_method0("__fspath__")?.extract()?)
        } else if plain.hasattr("__index__")? {
            Data::Integer(plain.call_method0("__index__")?.extract()?)
        } else if plain.hasattr("__float__")? {
            Data::Number(plain.call_method0("__float__")?.extract()?)
        } else if let Ok(items) = plain.try_iter() {
            let mut list = Vec::new();
            for (i, item) in items.enumerate() {
                list.extend(self.nested(&item?, &format!("{path}[{i}]"), key, depth + 1)?);
            }
            Data::Array(list)
        } else {
            return Err(unknown(&plain, path));
        };
        Ok(Some(Value { data, span: self.places.span(path) }))
    }

    fn table(&mut self, dict: &Bound<'_, PyDict>, path: &str, depth: usize) -> PyResult<Data> {
        let dict = match arrays::is_mesh(dict)? {
            true => arrays::take_mesh(dict, path, self.arrays)?,
            false => dict.clone(),
        };
        let of_grid =
            matches!(dict.get_item("type")?, Some(kind) if arrays::GRIDS.contains(&kind.str()?.to_str()?));
        let mut table = Table::default();
        for (key, item) in &dict {
            let Ok(key) = key.cast::<PyString>() else {
                return Err(PyTypeError::new_err(format!("{path}: the keys of a dict must be text")));
            };
            let key = key.to_str()?;
            let place = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
            let kind = if of_grid && key == "file" { "grid" } else { key };
            if let Some(value) = self.nested(&item, &place, kind, depth + 1)? {
                table.entries.push(Entry { key: key.to_owned(), key_span: value.span, value });
            }
        }
        Ok(Data::Table(table))
    }

    /// An array: of a file, a transform, or a list of numbers.
    fn array(
        &mut self,
        array: &Bound<'_, PyUntypedArray>,
        path: &str,
        key: &str,
        depth: usize,
    ) -> PyResult<Option<Value>> {
        let span = self.places.span(path);
        let text = |uri| Ok(Some(Value { data: Data::String(uri), span }));
        let shape = array.shape().to_vec();
        match (key, shape.len()) {
            ("grid", 3) => return text(self.arrays.grid(array, path)?),
            ("file" | "image", 2 | 3) => return text(self.arrays.image(array, path)?),
            ("transform" | "motion", 2) if matches!(shape.as_slice(), [3 | 4, 4]) => {
                let dict = PyDict::new(array.py());
                dict.set_item("matrix", array.call_method0("tolist")?)?;
                return self.nested(&dict, path, "", depth + 1);
            }
            _ => {}
        }
        if array.len() > MAX_LIST {
            let message =
                format!("{path}: an array of {} elements; expected at most {MAX_LIST}", array.len());
            return Err(PyValueError::new_err(message));
        }
        self.nested(&array.call_method0("tolist")?, path, key, depth + 1)
    }
}

fn unknown(object: &Bound<'_, PyAny>, path: &str) -> PyErr {
    let kind = object.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
    let at = if path.is_empty() { String::new() } else { format!("{path}: ") };
    PyTypeError::new_err(format!(
        "{at}{kind} is no value of a scene; expected a number, text, a list, a dict, an array or one of turner's classes"
    ))
}

/// A value of the scene format as Python's.
pub(crate) fn to_python<'py>(py: Python<'py>, data: &Data) -> PyResult<Bound<'py, PyAny>> {
    Ok(match data {
        Data::Bool(v) => PyBool::new(py, *v).to_owned().into_any(),
        Data::Integer(v) => v.into_pyobject(py)?.into_any(),
        Data::Number(v) => v.into_pyobject(py)?.into_any(),
        Data::String(v) => v.into_pyobject(py)?.into_any(),
        Data::Array(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(to_python(py, &item.data)?)?;
            }
            list.into_any()
        }
        Data::Table(table) => {
            let dict = PyDict::new(py);
            for entry in &table.entries {
                dict.set_item(&entry.key, to_python(py, &entry.value.data)?)?;
            }
            dict.into_any()
        }
    })
}
