//! Developed pictures as NumPy arrays. The memory of the renderer becomes that of the arrays.

use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use turner::film::{Aov, LabelKind, Picture};
use turner::integrator::Prepared;
use turner::render::{AovChannel, AovValues, CenterAov, Renderer, label_name};

use crate::plain::of_json;

/// What a film shows, developed without the GIL.
pub(crate) struct Developed {
    picture: Picture,
    aovs: Vec<Layer>,
    attributes: Vec<(String, String)>,
    names: Names,
}

/// An AOV or one layer of it.
struct Layer {
    name: String,
    channels: Vec<String>,
    values: AovValues,
}

/// The name of the layer that a channel belongs to.
fn layer_of(channel: &AovChannel) -> String {
    match channel.aov {
        // `light.key.R`: one layer a light group.
        Aov::LightGroups => {
            channel.name.rsplit_once('.').map_or(channel.name.clone(), |(layer, _)| layer.to_owned())
        }
        aov => aov.word().to_owned(),
    }
}

/// Channels one after another as channels side by side.
fn woven<T: Copy>(planes: &[Vec<T>]) -> Vec<T> {
    let count = planes.first().map_or(0, Vec::len);
    (0..count).flat_map(|i| planes.iter().filter_map(move |plane| plane.get(i).copied())).collect()
}

fn layer(name: String, channels: Vec<AovChannel>) -> Layer {
    let names = channels.iter().map(|channel| channel.name.clone()).collect();
    let (mut floats, mut numbers) = (Vec::new(), Vec::new());
    for channel in channels {
        match channel.values {
            AovValues::Float(values) => floats.push(values),
            AovValues::Uint(values) => numbers.push(values),
        }
    }
    let values = match (floats.pop(), numbers.pop()) {
        (Some(only), None) if floats.is_empty() => AovValues::Float(only),
        (None, Some(only)) if numbers.is_empty() => AovValues::Uint(only),
        (Some(last), None) => {
            floats.push(last);
            AovValues::Float(woven(&floats))
        }
        (_, last) => {
            numbers.extend(last);
            AovValues::Uint(woven(&numbers))
        }
    };
    Layer { name, channels: names, values }
}

/// Develops a film. No GIL is needed.
pub(crate) fn develop(renderer: &Renderer, threads: usize) -> Developed {
    let picture = renderer.develop_with(threads);
    let aovs = layers(renderer.develop_aovs(threads));
    let (attributes, names) = (renderer.aov_attributes(), names_of(renderer.prepared()));
    Developed { picture, aovs, attributes, names }
}

/// Channels as layers, in order.
fn layers(channels: Vec<AovChannel>) -> Vec<Layer> {
    let mut aovs: Vec<(String, Vec<AovChannel>)> = Vec::new();
    for channel in channels {
        let name = layer_of(&channel);
        match aovs.last_mut() {
            Some((last, channels)) if *last == name => channels.push(channel),
            _ => aovs.push((name, vec![channel])),
        }
    }
    aovs.into_iter().map(|(name, channels)| layer(name, channels)).collect()
}

/// For each kind of numbers among the AOVs: the names of all numbers.
fn names_of(prepared: &Prepared) -> Names {
    let (scene, asked) = (&prepared.scene, &prepared.view.film.aovs);
    let mut names = Vec::new();
    for (word, kind, count) in [
        ("object_id", LabelKind::Object, scene.stats.primitives as usize),
        ("material_id", LabelKind::Material, scene.materials.len()),
        ("instance_id", LabelKind::Instance, scene.entry_count()),
    ] {
        if asked.iter().any(|aov| aov.labels() == Some(kind)) {
            let all = (0..count as u32).map(|label| (label + 1, label_name(scene, kind, label))).collect();
            names.push((word, all));
        }
    }
    names
}

/// The names of numbers, by AOV.
type Names = Vec<(&'static str, Vec<(u32, String)>)>;

/// Labels without a picture, as a dict.
pub(crate) fn labels_dict<'py>(
    py: Python<'py>,
    prepared: &Prepared,
    aovs: Vec<CenterAov>,
) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    let film = &prepared.view.film;
    let [.., width, height] = film.crop.unwrap_or([0, 0, film.width, film.height]);
    let layer = |CenterAov { aov, values }| {
        let channels = aov.layout().channels.iter().map(|name| (*name).to_owned()).collect();
        Layer { name: aov.word().to_owned(), channels, values }
    };
    let layers = aovs.into_iter().map(layer).collect();
    put_layers(&out, layers, [height as usize, width as usize])?;
    put_names(&out, names_of(prepared))?;
    out.set_item("camera", of_json(py, &turner_cli::camera::json(&prepared.view).to_string())?)?;
    Ok(out)
}

fn put_layers(out: &Bound<'_, PyDict>, layers: Vec<Layer>, [height, width]: [usize; 2]) -> PyResult<()> {
    let py = out.py();
    let (arrays, channels) = (PyDict::new(py), PyDict::new(py));
    for Layer { name, channels: own, values } in layers {
        let depth = own.len();
        let shape: Vec<usize> = if depth == 1 { vec![height, width] } else { vec![height, width, depth] };
        match values {
            AovValues::Float(values) => arrays.set_item(&name, values.into_pyarray(py).reshape(shape)?)?,
            AovValues::Uint(values) => arrays.set_item(&name, values.into_pyarray(py).reshape(shape)?)?,
        }
        channels.set_item(&name, PyList::new(py, own)?)?;
    }
    out.set_item("aovs", arrays)?;
    out.set_item("channels", channels)
}

fn put_names(out: &Bound<'_, PyDict>, names: Names) -> PyResult<()> {
    let tables = PyDict::new(out.py());
    for (word, of_word) in names {
        let table = PyDict::new(out.py());
        for (number, name) in of_word {
            table.set_item(number, name)?;
        }
        tables.set_item(word, table)?;
    }
    out.set_item("names", tables)
}

impl Developed {
    /// A dict: `image` (height, width, 4) float32, linear and premultiplied; `display` (height, width, 4) uint8;
    /// `aovs`, a dict of arrays (height, width) or (height, width, channels); `channels`, their names in a file; `names` of
    /// the numbers; `attributes` of a file.
    pub(crate) fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let Developed { picture, aovs, attributes, names } = self;
        let (height, width) = (picture.height as usize, picture.width as usize);
        let out = PyDict::new(py);
        let image = picture.linear.into_flattened().into_pyarray(py).reshape([height, width, 4])?;
        let display = picture.display.into_flattened().into_pyarray(py).reshape([height, width, 4])?;
        out.set_item("image", image)?;
        out.set_item("display", display)?;
        out.set_item("has_alpha", picture.has_alpha)?;
        out.set_item("exposure", picture.exposure)?;
        out.set_item("missing", picture.missing)?;
        put_layers(&out, aovs, [height, width])?;
        put_names(&out, names)?;
        out.set_item("attributes", attributes.into_iter().collect::<std::collections::BTreeMap<_, _>>())?;
        Ok(out)
    }
}
