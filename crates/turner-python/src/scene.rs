//! The class behind `turner.Scene`: a description, what names its positions, and its preparations.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use turner::animation::AnimationDesc;
use turner::description::{ObjectDesc, SceneDesc, SceneLight, read_scene};
use turner::film::FilmDesc;
use turner::integrator::Prepared;
use turner::prepare::{Preparer, UpdateOptions};
use turner::render::{PassOptions, center_aovs};
use turner::schema::value::{Data, Value};
use turner::schema::{ErrorCode, KeyEdit, KeyPart, Limits, Named, PrepareOptions, SceneError, WarningKind};
use turner::shape::ShapeDesc;
use turner_io::convert::{ConvertOptions, to_glb, to_toml};
use turner_io::image::KeptPictures;
use turner_io::load_with;
use turner_io::scene::{LoadError, LoadOptions, Loaded, ModelOverrides, Override, Sources, load_text};

use crate::arrays::Arrays;
use crate::assets::{Assets, Folders};
use crate::errors::Origin;
use crate::mesh_views;
use crate::picture;
use crate::places::Places;
use crate::renderer::Renderer;
use crate::tools;
use crate::value::{Converter, to_python};
use crate::work::attend;

/// A scene. Key paths are those of scene files: `film.samples`, `object.0.radius`, `material.gold`.
#[pyclass(frozen, module = "turner._turner")]
pub struct Scene {
    state: Mutex<State>,
    places: Arc<Places>,
    preparer: Arc<Mutex<Preparer>>,
    /// The folder that relative paths start from.
    folder: PathBuf,
    options: LoadOptions,
    /// Whether it comes from a model or another program's scene, whose description no person wrote.
    is_import: bool,
}

/// What edits replace.
#[derive(Clone)]
struct State {
    desc: Arc<SceneDesc>,
    sources: Arc<Sources>,
}

/// A description and what it was prepared to.
pub(crate) struct Made {
    pub(crate) desc: Arc<SceneDesc>,
    pub(crate) sources: Arc<Sources>,
    pub(crate) places: Arc<Places>,
    pub(crate) prepared: Prepared,
}

fn limits(megabytes: Option<u64>) -> Limits {
    let mut limits = Limits::default();
    if let Some(megabytes) = megabytes {
        limits.memory = Arc::new(turner::schema::Memory::new(megabytes.saturating_mul(1 << 20), || None));
    }
    limits
}

impl Scene {
    fn new(desc: SceneDesc, sources: Sources, places: Places, folder: &Path, options: LoadOptions) -> Scene {
        let prepare = PrepareOptions { limits: options.limits.clone(), ..PrepareOptions::default() };
        Scene {
            state: Mutex::new(State { desc: Arc::new(desc), sources: Arc::new(sources) }),
            places: Arc::new(places),
            preparer: Arc::new(Mutex::new(Preparer::new(prepare))),
            folder: folder.to_owned(),
            options,
            is_import: false,
        }
    }

    fn loaded(
        py: Python<'_>,
        loaded: Result<Loaded, LoadError>,
        folder: &Path,
        options: LoadOptions,
    ) -> PyResult<Scene> {
        let places = Places::default();
        match loaded {
            Ok(Loaded { desc, sources, .. }) => Ok(Scene::new(desc, sources, places, folder, options)),
            Err(LoadError { error, sources }) => {
                Err(Origin { sources: &sources, places: &places }.error(py, &error))
            }
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn snapshot(&self) -> State {
        self.lock().clone()
    }

    /// An error with the places of this scene.
    fn error(&self, py: Python<'_>, error: &SceneError) -> PyErr {
        Origin { sources: &self.snapshot().sources, places: &self.places }.error(py, error)
    }

    /// Values by their key paths, and their arrays.
    fn edits(&self, values: &Bound<'_, PyDict>) -> PyResult<(Vec<KeyEdit>, Arrays)> {
        let mut arrays = Arrays::default();
        let mut edits = Vec::with_capacity(values.len());
        for (path, value) in values {
            let path: String = path.extract()?;
            let mut converter = Converter { places: &self.places, arrays: &mut arrays };
            let Some(value) = converter.value(&value, &path)? else {
                return Err(PyValueError::new_err(format!("{path}: expected a value, found None")));
            };
            let span = value.span;
            let parts = KeyPart::split(&path).into_iter().map(|part| KeyPart { span, ..part });
            edits.push(KeyEdit { path: parts.collect(), value });
        }
        Ok((edits, arrays))
    }

    /// Changes the description. No GIL is needed.
    fn apply(
        &self,
        arrays: &Arrays,
        change: impl FnOnce(&mut SceneDesc, &mut Assets<'_>) -> Result<(), SceneError>,
    ) -> Result<(), SceneError> {
        let folders = Folders::new(&self.folder, &self.options);
        let mut state = self.lock();
        let mut desc = (*state.desc).clone();
        let sources = state.sources.clone();
        change(&mut desc, &mut Assets::new(arrays, &folders, &sources, &self.options, &self.folder))?;
        state.desc = Arc::new(desc);
        Ok(())
    }

    /// Prepares the scene with further values, which the scene does not keep. Ctrl-C cancels it.
    pub(crate) fn made(&self, py: Python<'_>, values: &Bound<'_, PyDict>) -> PyResult<Made> {
        let (edits, arrays) = self.edits(values)?;
        let State { desc, sources } = self.snapshot();
        let cancel = AtomicBool::new(false);
        let work = || {
            let desc = if edits.is_empty() {
                desc
            } else {
                Arc::new(self.edited(&desc, &edits, &arrays, &sources)?)
            };
            let wanted = UpdateOptions { cancel: Some(&cancel), ..UpdateOptions::default() };
            let mut preparer = self.preparer.lock().unwrap_or_else(PoisonError::into_inner);
            let stopped = || SceneError::new(ErrorCode::Internal, "the preparation was cancelled");
            let update = preparer.update_with(&desc, &wanted)?.ok_or_else(stopped)?;
            Ok((desc, update.prepared))
        };
        match attend(py, || cancel.store(true, Ordering::SeqCst), work, |_| Ok(()))? {
            Ok((desc, prepared)) => Ok(Made { desc, sources, places: self.places.clone(), prepared }),
            Err(error) => Err(Origin { sources: &sources, places: &self.places }.error(py, &error)),
        }
    }

    fn edited(
        &self,
        desc: &SceneDesc,
        edits: &[KeyEdit],
        arrays: &Arrays,
        sources: &Sources,
    ) -> Result<SceneDesc, SceneError> {
        let folders = Folders::new(&self.folder, &self.options);
        let mut copy = desc.clone();
        copy.edit(edits, &mut Assets::new(arrays, &folders, sources, &self.options, &self.folder))?;
        Ok(copy)
    }
}

#[pymethods]
impl Scene {
    /// Loads a scene or a model.
    #[staticmethod]
    #[pyo3(signature = (path, integrator=None, time=None, animation=None, variant=None, defines=Vec::new(), overrides=Vec::new(), max_texture_size=None, allow_outside=false, allow_paths=Vec::new(), max_memory=None))]
    #[expect(clippy::too_many_arguments)]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        integrator: Option<String>,
        time: Option<f64>,
        animation: Option<String>,
        variant: Option<String>,
        defines: Vec<(String, String)>,
        overrides: Vec<(String, String)>,
        max_texture_size: Option<u32>,
        allow_outside: bool,
        allow_paths: Vec<PathBuf>,
        max_memory: Option<u64>,
    ) -> PyResult<Scene> {
        let options = LoadOptions {
            max_texture_size,
            models: ModelOverrides { time, animation, variant, frame: None },
            defines,
            integrator,
            overrides: overrides.into_iter().map(|(path, value)| Override { path, value }).collect(),
            allow_outside,
            allow_paths,
            limits: limits(max_memory),
            kept_pictures: Some(KeptPictures::default()),
            ..LoadOptions::default()
        };
        let loaded = py.detach(|| load_with(&path, &options));
        // Later edits read with the same rules, but replace nothing.
        let later = LoadOptions { overrides: Vec::new(), integrator: None, ..options };
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
        let is_import = path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("toml"));
        Scene::loaded(py, loaded, &folder, later).map(|scene| Scene { is_import, ..scene })
    }

    /// Reads a scene from text.
    #[staticmethod]
    fn parse(py: Python<'_>, text: String, folder: PathBuf) -> PyResult<Scene> {
        let options = LoadOptions { kept_pictures: Some(KeptPictures::default()), ..LoadOptions::default() };
        let loaded = py.detach(|| {
            let bare = |error| LoadError { error, sources: Sources::default() };
            let assets =
                turner_io::assets::FolderAssets::new(&folder).map_err(|e| bare(e.to_scene_error()))?;
            load_text(text, "text", &assets, &options)
        });
        Scene::loaded(py, loaded, &folder, options)
    }

    /// A scene of a table of sections, as in a scene file.
    #[staticmethod]
    fn build(py: Python<'_>, root: &Bound<'_, PyDict>, folder: PathBuf) -> PyResult<Scene> {
        let (places, mut arrays) = (Places::default(), Arrays::default());
        let value = Converter { places: &places, arrays: &mut arrays }.value(root, "")?;
        let value = value.unwrap_or_else(|| Value::new(Data::Bool(false)));
        let options = LoadOptions::default();
        let sources = Sources::default();
        let desc = py.detach(|| {
            let folders = Folders::new(&folder, &options);
            read_scene(&value, &mut Assets::new(&arrays, &folders, &sources, &options, &folder))
        });
        match desc {
            Ok(desc) => Ok(Scene::new(desc, sources, places, &folder, options)),
            Err(error) => Err(Origin { sources: &sources, places: &places }.error(py, &error)),
        }
    }

    /// A copy: its edits do not change this scene. Meshes and images are shared.
    fn copy(&self) -> Scene {
        let State { desc, sources } = self.snapshot();
        let (sources, places) = ((*sources).clone(), (*self.places).clone());
        let copy = Scene::new((*desc).clone(), sources, places, &self.folder, self.options.clone());
        Scene { is_import: self.is_import, ..copy }
    }

    /// The value at a key path; None if it is at its default or the scene does not have it.
    fn get<'py>(&self, py: Python<'py>, path: &str) -> PyResult<Bound<'py, PyAny>> {
        let value = self.snapshot().desc.value_at(path).map_err(|e| self.error(py, &e))?;
        value.map_or_else(|| Ok(py.None().into_bound(py)), |value| to_python(py, &value.data))
    }

    /// The film's values of the keys whose default depends on the integrator.
    fn film_defaults<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let film = FilmDesc::default_for(self.snapshot().desc.integrator.type_name());
        let out = PyDict::new(py);
        out.set_item("antialias", film.antialias.word())?;
        out.set_item("samples", film.samples)?;
        out.set_item("transfer", film.transfer.word())?;
        Ok(out)
    }

    /// Sets values by their key paths: all of them, or none if one is wrong.
    fn edit(&self, py: Python<'_>, values: &Bound<'_, PyDict>) -> PyResult<()> {
        let (edits, arrays) = self.edits(values)?;
        py.detach(|| self.apply(&arrays, |desc, assets| desc.edit(&edits, assets)))
            .map_err(|e| self.error(py, &e))
    }

    /// Adds objects, lights, views or animations. Returns their key paths.
    fn add(&self, py: Python<'_>, section: &str, values: &Bound<'_, PyList>) -> PyResult<Vec<String>> {
        let count = |desc: &SceneDesc| match section {
            "object" => Ok(desc.objects.len()),
            "light" => Ok(desc.lights.len()),
            "view" => Ok(desc.cameras.len()),
            "animation" => Ok(desc.animations.len()),
            _ => Err(PyValueError::new_err(format!("nothing can be added to `{section}`"))),
        };
        let first = count(&self.snapshot().desc)?;
        let mut arrays = Arrays::default();
        let mut found = Vec::with_capacity(values.len());
        for (i, value) in values.iter().enumerate() {
            let path = format!("{section}.{}", first + i);
            let mut converter = Converter { places: &self.places, arrays: &mut arrays };
            found.extend(converter.value(&value, &path)?);
        }
        let paths = py.detach(|| {
            let mut paths = Vec::new();
            self.apply(&arrays, |desc, assets| {
                paths = found.iter().map(|_| placeholder(desc, section)).collect();
                let edit = |(path, value): (&String, &Value)| {
                    let parts =
                        KeyPart::split(path).into_iter().map(|part| KeyPart { span: value.span, ..part });
                    KeyEdit { path: parts.collect(), value: value.clone() }
                };
                let edits: Vec<KeyEdit> = paths.iter().zip(&found).map(edit).collect();
                desc.edit(&edits, assets)
            })
            .map(|()| paths)
        });
        paths.map_err(|e| self.error(py, &e))
    }

    /// Removes parts by their key paths, with all that refers to them.
    fn remove(&self, py: Python<'_>, paths: Vec<String>) -> PyResult<()> {
        let none = Arrays::default();
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        py.detach(|| self.apply(&none, |desc, _| desc.remove(&paths))).map_err(|e| self.error(py, &e))
    }

    /// Renames a part. Returns its new key path.
    fn rename(&self, py: Python<'_>, path: &str, name: &str) -> PyResult<String> {
        let (none, mut renamed) = (Arrays::default(), String::new());
        let result = py.detach(|| {
            self.apply(&none, |desc, _| {
                renamed = desc.rename(path, name)?;
                Ok(())
            })
        });
        result.map(|()| renamed).map_err(|e| self.error(py, &e))
    }

    /// The names of a section's parts, in order. Objects, lights and views may have none.
    fn names(&self, section: &str) -> PyResult<Vec<Option<String>>> {
        let desc = self.snapshot().desc;
        let names = desc.names();
        let all = |names: Vec<String>| names.into_iter().map(Some).collect();
        Ok(match section {
            "object" => desc.objects.iter().map(|part| part.name.clone()).collect(),
            "light" => desc.lights.iter().map(|part| part.name.clone()).collect(),
            "view" => desc.cameras.iter().map(|part| part.name.clone()).collect(),
            "animation" => desc.animations.iter().map(|part| part.name.clone()).collect(),
            "texture" => all(names.textures),
            "material" => all(names.materials),
            "medium" => all(names.media),
            "group" => all(names.groups),
            _ => return Err(PyValueError::new_err(format!("`{section}` is no list of parts"))),
        })
    }

    /// Issues the warnings of loading.
    fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let State { desc, sources } = self.snapshot();
        let told: Vec<_> = desc.warnings.iter().filter(|w| w.kind != WarningKind::Note).cloned().collect();
        Origin { sources: &sources, places: &self.places }.warn(py, &told)
    }

    /// A renderer of the scene, with further values that the scene does not keep.
    fn renderer(&self, py: Python<'_>, values: &Bound<'_, PyDict>, threads: usize) -> PyResult<Renderer> {
        Renderer::new(py, self.made(py, values)?, threads)
    }

    /// AOVs of what the centres of pixels show, without light: a dict of `aovs`, `channels`, `names` and `camera`.
    fn labels<'py>(
        &self,
        py: Python<'py>,
        values: &Bound<'_, PyDict>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        let made = self.made(py, values)?;
        let cancel = AtomicBool::new(false);
        let options = PassOptions { threads, cancel: &cancel, progress: None };
        let work = || center_aovs(&made.prepared, &options);
        let aovs = attend(py, || cancel.store(true, Ordering::SeqCst), work, |_| Ok(()))?;
        let aovs = aovs.map_err(|e| self.error(py, &e))?.unwrap_or_default();
        picture::labels_dict(py, &made.prepared, aovs)
    }

    /// What the scene contains: sizes, bounds, memory, the camera as numbers.
    fn info<'py>(&self, py: Python<'py>, values: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyAny>> {
        tools::info(py, &self.made(py, values)?)
    }

    /// The explanation of a pixel as "json", "text", "html" or "svg".
    fn explain(
        &self,
        py: Python<'_>,
        values: &Bound<'_, PyDict>,
        pixel: (u32, u32),
        sample: Option<usize>,
        form: &str,
    ) -> PyResult<String> {
        tools::explain(py, &self.made(py, values)?, pixel, sample, form)
    }

    /// The doctor's findings as JSON.
    fn doctor(
        &self,
        py: Python<'_>,
        values: &Bound<'_, PyDict>,
        seconds: f64,
        threads: usize,
    ) -> PyResult<String> {
        tools::doctor(py, &self.made(py, values)?, seconds, threads)
    }

    /// Writes the scene: .toml with its files beside it, or .glb. Returns the paths of the files.
    fn write(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<Vec<PathBuf>> {
        let State { mut desc, sources } = self.snapshot();
        if self.is_import && !is_glb(&path) {
            let mut copy = (*desc).clone();
            let needed = turner_cli::convert::adds_parts(&copy);
            let made = needed.then(|| self.made(py, &PyDict::new(py))).transpose()?;
            turner_cli::convert::settle(&mut copy, made.as_ref().map(|made| &made.prepared));
            desc = Arc::new(copy);
        }
        let options = ConvertOptions {
            source: "Python".to_owned(),
            overwrite,
            strict: false,
            pictures: self.options.kept_pictures.clone().unwrap_or_default(),
        };
        let converted = py.detach(|| match is_glb(&path) {
            true => to_glb(&desc, &path, &options),
            false => to_toml(&desc, &path, &options),
        });
        let origin = Origin { sources: &sources, places: &self.places };
        let converted = converted.map_err(|e| origin.error(py, &e))?;
        origin.warn(py, &converted.warnings)?;
        Ok(converted.files.into_iter().map(|file| file.path).collect())
    }

    /// Writes the scene as it is, so that the file loads as the same scene. `write` makes imported scenes readable instead.
    fn write_exactly(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let State { desc, sources } = self.snapshot();
        let pictures = self.options.kept_pictures.clone().unwrap_or_default();
        let options = ConvertOptions { source: "Python".to_owned(), pictures, ..ConvertOptions::default() };
        let written = py.detach(|| to_toml(&desc, &path, &options));
        let origin = Origin { sources: &sources, places: &self.places };
        written.map(drop).map_err(|e| origin.error(py, &e))
    }

    /// The arrays of an object's mesh as read-only views: a dict with `positions`, `triangles`, `normals`, …; those that the
    /// mesh does not have are missing.
    fn mesh<'py>(slf: &Bound<'py, Self>, object: usize) -> PyResult<Bound<'py, PyDict>> {
        let desc = slf.get().snapshot().desc;
        let Some(own) = desc.objects.get(object) else {
            return Err(PyIndexError::new_err(format!("the scene has {} objects", desc.objects.len())));
        };
        match &own.content {
            turner::description::ObjectContent::Shape(ShapeDesc::Mesh(mesh)) => {
                let data = desc.meshes.get(mesh.mesh.index()).map(|asset| asset.data.clone());
                let data = data.ok_or_else(|| PyIndexError::new_err("the object has no mesh"))?;
                mesh_views::views(slf.py(), data)
            }
            _ => Err(PyValueError::new_err("the object is no mesh")),
        }
    }

    /// All meshes of the scene's files and objects, each as [`Scene::mesh`] gives them.
    fn meshes<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let desc = slf.get().snapshot().desc;
        desc.meshes.iter().map(|asset| mesh_views::views(slf.py(), asset.data.clone())).collect()
    }
}

fn is_glb(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"))
}

/// Adds a part with its defaults, which an edit replaces. Returns its key path.
fn placeholder(desc: &mut SceneDesc, section: &str) -> String {
    match section {
        "object" => desc.add_object(ObjectDesc::default()),
        "light" => desc.add_light(SceneLight::default()),
        "view" => desc.add_view("view", Default::default()),
        _ => {
            desc.animations.push(Named { value: AnimationDesc::default(), ..Named::default() });
            format!("animation.{}", desc.animations.len() - 1)
        }
    }
}
