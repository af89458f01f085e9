//! The schema of the scene format for Python, which makes its classes of it.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use turner::animation::AnimationDesc;
use turner::camera::CameraDesc;
use turner::description::{ModelDesc, StudioDesc};
use turner::film::{Aov, FilmDesc};
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::{EntryDoc, FamilyDoc};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_cli::reference::{Key, chapters, paragraph};

/// The families, with the keys that all members have besides their own.
const FAMILIES: [&FamilyDoc; 7] = [
    &CameraDesc::DOC,
    &IntegratorDesc::DOC,
    &ShapeDesc::DOC,
    &MaterialDesc::DOC,
    &TextureDesc::DOC,
    &MediumDesc::DOC,
    &LightDesc::DOC,
];

/// Sections and objects without a family.
const SINGLES: [&EntryDoc; 5] =
    [&FilmDesc::DOC, &BackgroundDesc::DOC, &StudioDesc::DOC, &AnimationDesc::DOC, &ModelDesc::DOC];

/// The schema: a list of dicts with `family` (empty for sections), `type`, `doc`, `example` and `keys`; each key has
/// `name`, `kind`, `default` (as text, None if required), `doc` and `words`. And the AOVs: name, doc, unit, channels.
#[pyfunction]
pub fn schema(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let entries = PyList::empty(py);
    for family in FAMILIES {
        for entry in family.entries {
            entries.append(described(py, family.one, entry)?)?;
        }
    }
    for entry in SINGLES {
        entries.append(described(py, "", entry)?)?;
    }
    let common = PyList::empty(py);
    for chapter in chapters().into_iter().filter(|chapter| chapter.heading == "Objects") {
        for key in chapter.intro.keys {
            common.append(of_page(py, &key)?)?;
        }
    }
    let aovs = PyList::empty(py);
    for aov in Aov::all() {
        let words = Aov::DOCS.iter().find(|(word, _)| *word == aov.word());
        let (doc, layout) = (words.map_or("", |(_, doc)| doc), aov.layout());
        aovs.append((aov.word(), doc, layout.unit, layout.channels.len()))?;
    }
    let out = PyDict::new(py);
    out.set_item("entries", entries)?;
    out.set_item("object_keys", common)?;
    out.set_item("aovs", aovs)?;
    Ok(out)
}

fn described<'py>(py: Python<'py>, family: &str, entry: &EntryDoc) -> PyResult<Bound<'py, PyDict>> {
    let keys = PyList::empty(py);
    for field in entry.fields {
        let key = PyDict::new(py);
        key.set_item("name", field.name)?;
        key.set_item("kind", (field.kind)())?;
        key.set_item("default", field.default.map(|show| show()))?;
        key.set_item("doc", paragraph(field.doc))?;
        key.set_item("words", (field.words)().to_vec())?;
        key.set_item("range", field.range.map(|range| range.to_string()))?;
        keys.append(key)?;
    }
    let out = PyDict::new(py);
    out.set_item("family", family)?;
    out.set_item("type", entry.name)?;
    out.set_item("doc", paragraph(entry.doc))?;
    out.set_item("example", entry.example)?;
    out.set_item("keys", keys)?;
    Ok(out)
}

fn of_page<'py>(py: Python<'py>, key: &Key) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    out.set_item("name", &key.name)?;
    out.set_item("kind", &key.kind)?;
    out.set_item("default", key.default.as_deref().map(|text| text.trim_matches('`')))?;
    out.set_item("doc", &key.doc)?;
    out.set_item("words", Vec::<(String, String)>::new())?;
    out.set_item("range", &key.range)?;
    Ok(out)
}
