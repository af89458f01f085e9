//! The record of a pixel, from which text, drawing, page and JSON are written.
//!
//! Its fields are the keys of the JSON: docs/reference/explain.md documents them. Numbers have full precision; infinite
//! and absent values are null. Records are structs, not maps: a pixel may have thousands of shadow rays.

pub(super) mod classic;
pub(super) mod path;

use classic::Tree;
use path::Path;
use serde::ser::Error;
use serde::{Serialize, Serializer};
use turner::color::Spectrum;
use turner::integrator::classic::{CutReason, RayKind, Seen};
use turner::integrator::path::{End, Passage};
use turner::math::DVec3;
use turner::render::SampleRecord;
use turner::schema::MaterialId;

use turner::explain::{Names, Replay, SampleTree};

/// Increased when a key changes its meaning or is removed. New keys may appear at any time.
pub(super) const VERSION: u32 = 2;

/// The form in which JSON has a value of the renderer.
trait Plain {
    type Form: Serialize;
    fn form(&self) -> Self::Form;
}

/// Red, green, blue; as f64, so that a reader in double precision gets the exact f32 value.
impl Plain for Spectrum {
    type Form = [f64; 3];
    fn form(&self) -> [f64; 3] {
        self.to_array().map(f64::from)
    }
}

impl Plain for DVec3 {
    type Form = [f64; 3];
    fn form(&self) -> [f64; 3] {
        self.to_array()
    }
}

impl Plain for f32 {
    type Form = f64;
    fn form(&self) -> f64 {
        f64::from(*self)
    }
}

impl<T: Plain> Plain for Option<T> {
    type Form = Option<T::Form>;
    fn form(&self) -> Option<T::Form> {
        self.as_ref().map(T::form)
    }
}

/// Enumerations as their words.
macro_rules! words {
    ($($kind:ty),*) => {$(
        impl Plain for $kind {
            type Form = &'static str;
            fn form(&self) -> &'static str {
                self.word()
            }
        }
    )*};
}

words!(RayKind, Seen, CutReason, End, Passage);

/// Serialises a value in its plain form.
fn plain<T: Plain, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    value.form().serialize(serializer)
}

/// A material: index and name.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Material<'a> {
    pub(crate) id: u32,
    pub(crate) name: Option<&'a str>,
}

impl<'a> Material<'a> {
    fn new(names: &Names<'a>, id: MaterialId) -> Material<'a> {
        Material { id: id.0, name: names.material_name(id) }
    }
}

/// An object: primitive index, shape, name, and the instance that placed it.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Object<'a> {
    pub(crate) primitive: u32,
    pub(crate) shape: &'static str,
    pub(crate) name: Option<&'a str>,
    pub(crate) instance: Option<&'a str>,
}

impl<'a> Object<'a> {
    fn new(names: &Names<'a>, primitive: u32, shape: &'static str) -> Object<'a> {
        let name = names.prepared.scene.object_name(primitive);
        Object { primitive, shape, name: name.own, instance: name.instance }
    }
}

/// The camera ray.
#[derive(Serialize)]
pub(crate) struct Camera {
    #[serde(serialize_with = "plain")]
    pub(crate) origin: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) direction: DVec3,
}

/// One of the pixel's samples.
#[derive(Serialize)]
pub(crate) struct Listed {
    pub(crate) pixel_position: [f64; 2],
    pub(crate) weight: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) color: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) alpha: f32,
}

/// A square of adaptive anti-aliasing.
#[derive(Serialize)]
pub(crate) struct Square {
    pub(crate) corner: [f64; 2],
    pub(crate) size: f64,
    pub(crate) spread: f64,
}

/// A pixel, explained.
#[derive(Serialize)]
pub(crate) struct Explanation<'a> {
    pub(crate) format: &'static str,
    pub(crate) version: u32,
    pub(crate) turner: &'static str,
    /// The scene file, as it was given.
    pub(crate) scene: String,
    pub(crate) scene_hash: String,
    pub(crate) integrator: &'static str,
    pub(crate) seed: u32,
    /// Columns and rows of the picture.
    pub(crate) size: [u32; 2],
    pub(crate) pixel: [u32; 2],
    /// The pixel's colour, premultiplied by alpha.
    #[serde(serialize_with = "plain")]
    pub(crate) color: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) alpha: f32,
    pub(crate) antialias: &'static str,
    pub(crate) sample_count: u64,
    pub(crate) samples: Vec<Listed>,
    pub(crate) squares: Vec<Square>,
    /// The name given with `--path-of`.
    pub(crate) path_of: Option<String>,
    /// Whether the contributions of every explained sample sum to the sample to the last bit.
    pub(crate) exact: bool,
    /// The samples that are shown.
    pub(crate) explained: Vec<Sample<'a>>,
    /// How the samples are averaged, in a sentence.
    #[serde(skip)]
    pub(crate) averaging: String,
    /// Which samples are shown, in a sentence; `None` where all are.
    #[serde(skip)]
    pub(crate) choice: Option<String>,
}

impl Explanation<'_> {
    /// The trees of all samples that are shown.
    pub(super) fn trees(&self, names: &Names<'_>) -> Vec<SampleTree> {
        let tree = |s: &Sample<'_>| SampleTree::of(names, s.sample, &s.source.0, &s.source.1);
        self.explained.iter().map(tree).collect()
    }

    /// As JSON.
    pub(super) fn json(&self) -> Result<String, serde_json::Error> {
        let mut out = serde_json::to_vec(self)?;
        out.push(b'\n');
        String::from_utf8(out).map_err(serde_json::Error::custom)
    }
}

/// One sample.
#[derive(Serialize)]
pub(crate) struct Sample<'a> {
    /// Its index among the pixel's samples.
    pub(crate) sample: usize,
    pub(crate) pixel_position: [f64; 2],
    /// The sum of all contributions, in the order in which they were added.
    #[serde(serialize_with = "plain")]
    pub(crate) sum: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) rendered: Spectrum,
    #[serde(serialize_with = "plain")]
    pub(crate) alpha: f32,
    /// Whether the contributions sum to the sample to the last bit.
    pub(crate) exact: bool,
    /// With `--path-of`: whether it selects the sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) touches: Option<bool>,
    #[serde(flatten)]
    pub(crate) what: What<'a>,
    /// What it was made from.
    #[serde(skip)]
    source: (SampleRecord, Replay),
}

/// The record of the integrator that traced it.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub(crate) enum What<'a> {
    Tree(Tree<'a>),
    Path(Box<Path<'a>>),
    FirstHit(Box<FirstHit<'a>>),
}

impl<'a> Sample<'a> {
    pub(super) fn new(names: &Names<'a>, number: usize, sample: &SampleRecord, replay: Replay) -> Sample<'a> {
        let what = match &replay {
            Replay::Tree(record) => What::Tree(classic::of(names, record)),
            Replay::Path(record) => What::Path(Box::new(path::of(names, record))),
            Replay::FirstHit(record) => What::FirstHit(Box::new(FirstHit::new(names, record))),
        };
        let sum = replay.sum();
        let touches = match &what {
            What::Tree(tree) => tree.touches(),
            What::Path(path) => path.touches(),
            What::FirstHit(first) => first.hit.as_ref().is_some_and(|h| h.touches),
        };
        let bits = |s: Spectrum| s.to_array().map(f32::to_bits);
        let rendered = sample.radiance.color;
        Sample {
            sample: number,
            pixel_position: sample.place,
            sum,
            rendered,
            alpha: sample.radiance.alpha,
            // A non-finite sample has no meaningful sum.
            exact: bits(sum) == bits(rendered) || !rendered.is_finite(),
            touches: names.path_of.map(|_| touches),
            what,
            source: (*sample, replay),
        }
    }
}

/// For debug views: the first hit.
#[derive(Serialize)]
pub(crate) struct FirstHit<'a> {
    pub(crate) camera: Option<Camera>,
    pub(crate) hit: Option<Surface<'a>>,
}

#[derive(Serialize)]
pub(crate) struct Surface<'a> {
    /// Whether `--path-of` selects it.
    #[serde(skip)]
    pub(crate) touches: bool,
    pub(crate) t: f64,
    #[serde(serialize_with = "plain")]
    pub(crate) position: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) geometric_normal: DVec3,
    #[serde(serialize_with = "plain")]
    pub(crate) shading_normal: DVec3,
    pub(crate) object: Object<'a>,
    pub(crate) material: Material<'a>,
}

impl<'a> FirstHit<'a> {
    fn new(names: &Names<'a>, first: &turner::explain::FirstHit) -> FirstHit<'a> {
        let hit = first.hit.map(|hit| Surface {
            touches: names.touches(hit.primitive, hit.shape, hit.material),
            t: hit.t,
            position: hit.position,
            geometric_normal: hit.geometric_normal,
            shading_normal: hit.shading_normal,
            object: Object::new(names, hit.primitive, hit.shape),
            material: Material::new(names, hit.material),
        });
        FirstHit { camera: first.camera.map(|(origin, direction)| Camera { origin, direction }), hit }
    }
}
