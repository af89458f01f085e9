//! Explanations, findings, comparisons, files of pictures, and the command line.

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Instant;

use numpy::{PyReadonlyArray1, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use turner::compare::{Canvas, Metric, Pair};
use turner::doctor::{Options, examine};
use turner::explain::Names;
use turner_cli::explain::{Format, Wanted, written};
use turner_io::image::{ExtraChannel, MetaValue, Metadata, SampleKind};
use turner_io::{Save, SaveOptions, save_with};

use crate::errors::Origin;
use crate::plain::of_json;
use crate::scene::Made;

pub(crate) fn info<'py>(py: Python<'py>, made: &Made) -> PyResult<Bound<'py, PyAny>> {
    let (scene, view) = (&made.prepared.scene, &made.prepared.view);
    let out = PyDict::new(py);
    out.set_item("primitives", scene.stats.primitives)?;
    out.set_item("triangles", scene.stats.triangles)?;
    out.set_item("bounds", scene.stats.bounds.map(|b| (b.min.to_array(), b.max.to_array())))?;
    out.set_item("tree_bytes", scene.stats.tree_bytes)?;
    out.set_item("mesh_bytes", scene.stats.mesh_bytes)?;
    out.set_item("texture_bytes", scene.stats.texture_bytes)?;
    out.set_item("lights", scene.lights.len())?;
    out.set_item("materials", scene.materials.len())?;
    out.set_item("size", (view.film.width, view.film.height))?;
    out.set_item("samples", view.film.samples_per_pixel())?;
    out.set_item("camera", of_json(py, &turner_cli::camera::json(view).to_string())?)?;
    Ok(out.into_any())
}

pub(crate) fn explain(
    py: Python<'_>,
    made: &Made,
    pixel: (u32, u32),
    sample: Option<usize>,
    form: &str,
) -> PyResult<String> {
    let format = match form {
        "json" => Format::Json,
        "text" => Format::Text,
        "svg" => Format::Svg,
        "html" => Format::Html,
        other => {
            return Err(PyValueError::new_err(format!(
                "there is no form {other:?}; valid: json, text, svg, html"
            )));
        }
    };
    let names = Names { prepared: &made.prepared, desc: &made.desc, path_of: None };
    let wanted = Wanted { pixel, sample, all: false };
    let result = py.detach(|| written(&names, (String::new(), String::new()), &wanted, format, true));
    result
        .map(|(text, _)| text)
        .map_err(|e| Origin { sources: &made.sources, places: &made.places }.error(py, &e))
}

pub(crate) fn doctor(py: Python<'_>, made: &Made, seconds: f64, threads: usize) -> PyResult<String> {
    py.detach(|| {
        let start = Instant::now();
        let stop = || start.elapsed().as_secs_f64() > seconds;
        made.prepared.choose(threads);
        let examination =
            examine(&made.prepared, &made.desc, &Options { threads, stop: &stop, ..Options::default() });
        Ok(turner_cli::doctor::json_of(&examination, &made.sources).to_string())
    })
}

/// A picture in arrays of Python.
struct Arrays<'a> {
    size: (u32, u32),
    has_alpha: bool,
    linear: &'a [[f32; 4]],
    display: &'a [[u8; 4]],
}

impl Save for Arrays<'_> {
    fn size(&self) -> (u32, u32) {
        self.size
    }
    fn has_alpha(&self) -> bool {
        self.has_alpha
    }
    fn linear(&self, rows: std::ops::Range<u32>, _: usize) -> Cow<'_, [[f32; 4]]> {
        let width = self.size.0 as usize;
        Cow::Borrowed(&self.linear[rows.start as usize * width..rows.end as usize * width])
    }
    fn display(&self, rows: std::ops::Range<u32>, _: usize) -> Cow<'_, [[u8; 4]]> {
        let width = self.size.0 as usize;
        Cow::Borrowed(&self.display[rows.start as usize * width..rows.end as usize * width])
    }
}

/// A channel of a file: floats or whole numbers.
#[derive(FromPyObject)]
enum Plane<'py> {
    Float(PyReadonlyArray1<'py, f32>),
    Uint(PyReadonlyArray1<'py, u32>),
}

/// Writes a picture: PNG, JPEG, WebP, EXR or HDR, by the extension.
#[pyfunction]
pub fn save_picture(
    py: Python<'_>,
    path: PathBuf,
    image: PyReadonlyArray3<'_, f32>,
    display: PyReadonlyArray3<'_, u8>,
    has_alpha: bool,
    channels: Vec<(String, Bound<'_, PyAny>)>,
    metadata: std::collections::BTreeMap<String, String>,
) -> PyResult<()> {
    let shape = image.as_array().shape().to_vec();
    let &[height, width, 4] = shape.as_slice() else {
        return Err(PyValueError::new_err(format!(
            "an image of shape {shape:?}; expected (height, width, 4)"
        )));
    };
    if display.as_array().shape() != shape {
        return Err(PyValueError::new_err("image and display must have the same shape"));
    }
    let size = |v: usize| u32::try_from(v).map_err(|_| PyValueError::new_err("the picture is too large"));
    let picture = Arrays {
        size: (size(width)?, size(height)?),
        has_alpha,
        linear: image.as_slice()?.as_chunks::<4>().0,
        display: display.as_slice()?.as_chunks::<4>().0,
    };
    let planes = channels
        .into_iter()
        .map(|(name, plane)| Ok((name, plane.extract::<Plane<'_>>()?)))
        .collect::<PyResult<Vec<_>>>()?;
    let mut extra = Vec::with_capacity(planes.len());
    for (name, plane) in &planes {
        extra.push(match plane {
            Plane::Float(values) => ExtraChannel::new(name.as_str(), SampleKind::Float, values.as_slice()?),
            Plane::Uint(values) => ExtraChannel::new(name.as_str(), SampleKind::Uint, values.as_slice()?),
        });
    }
    let metadata: Metadata = metadata.into_iter().map(|(name, text)| (name, MetaValue::Text(text))).collect();
    let options = SaveOptions { channels: extra, metadata, ..SaveOptions::default() };
    py.detach(|| save_with(&path, &picture, &options))
        .map_err(|e| pyo3::exceptions::PyOSError::new_err(e.to_string()))
}

fn canvas(pixels: &[f32], shape: &[usize], is_linear: bool) -> PyResult<Canvas> {
    let &[height, width, 4] = shape else {
        return Err(PyValueError::new_err(format!(
            "an image of shape {shape:?}; expected (height, width, 4)"
        )));
    };
    let pixels = pixels.as_chunks::<4>().0.to_vec();
    let has_alpha = pixels.iter().any(|p| p[3] != 1.0);
    Ok(Canvas { width: width as u32, height: height as u32, pixels, has_alpha, is_linear })
}

/// All metrics of two pictures: premultiplied RGBA, linear light or display values from 0 to 1.
#[pyfunction]
pub fn compare<'py>(
    py: Python<'py>,
    reference: PyReadonlyArray3<'py, f32>,
    picture: PyReadonlyArray3<'py, f32>,
    is_linear: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let a = canvas(reference.as_slice()?, reference.as_array().shape(), is_linear)?;
    let b = canvas(picture.as_slice()?, picture.as_array().shape(), is_linear)?;
    let pair = Pair::new(a, b).map_err(|e| PyValueError::new_err(e.to_string()))?;
    let threads = turner_cli::threads(0);
    let measured = py.detach(|| Metric::ALL.map(|metric| (metric, metric.measure(&pair, threads))));
    let out = PyDict::new(py);
    for (metric, found) in measured {
        out.set_item(metric.word(), found.value)?;
    }
    out.set_item("non_finite", pair.unlike.count)?;
    Ok(out)
}

/// Runs the command line `turner` with these arguments and returns its exit code.
#[pyfunction]
pub fn run_command(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| turner_cli::run_from(arguments.into_iter().map(Into::into).collect()))
}
