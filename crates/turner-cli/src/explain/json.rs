//! An explanation as JSON, documented in docs/explain.md: numbers in full, what is infinite or not there as null.
//!
//! What is written is a struct of its own for each kind of thing, serialised as it stands: a pixel may have thousands of shadow rays.

use serde::ser::Error;
use serde::{Serialize, Serializer};
use turner::color::Spectrum;
use turner::math::DVec3;
use turner::scene::MaterialId;

use super::classic_json::{self, Tree};
use super::model::SampleTree;
use super::names::Names;
use super::path_json::{self, Path};
use super::samples::{Explained, Record};

/// Changes when a key changes its meaning or goes away; new keys may come at any time.
const VERSION: u32 = 1;

/// Red, green, blue; as wide as all other numbers, so that readers in double precision find the value itself.
pub(super) fn color(s: Spectrum) -> [f64; 3] {
    s.to_array().map(f64::from)
}

pub(super) fn vector(v: DVec3) -> [f64; 3] {
    v.to_array()
}

/// A material: its number and name.
#[derive(Serialize)]
pub(super) struct Material<'a> {
    id: u32,
    name: Option<&'a str>,
}

pub(super) fn material<'a>(names: &Names<'a>, id: MaterialId) -> Material<'a> {
    Material { id: id.0, name: names.material_name(id) }
}

/// An object: the number of its primitive, its shape and its name, and the instance that placed it.
#[derive(Serialize)]
pub(super) struct Object<'a> {
    primitive: u32,
    shape: &'a str,
    name: Option<&'a str>,
    instance: Option<&'a str>,
}

pub(super) fn object<'a>(names: &Names<'a>, primitive: u32, shape: &'a str) -> Object<'a> {
    let name = names.scene.object_name(primitive);
    Object { primitive, shape, name: name.own, instance: name.instance }
}

/// Where a ray of the camera begins, and where it goes.
#[derive(Serialize)]
struct Camera {
    origin: [f64; 3],
    direction: [f64; 3],
}

#[derive(Serialize)]
struct Sample {
    place: [f64; 2],
    share: f64,
    color: [f64; 3],
    alpha: f64,
}

#[derive(Serialize)]
struct Square {
    corner: [f64; 2],
    size: f64,
    spread: f64,
}

#[derive(Serialize)]
struct Explanation<'a> {
    format: &'a str,
    version: u32,
    turner: &'a str,
    scene: &'a str,
    scene_hash: &'a str,
    integrator: &'a str,
    seed: u32,
    size: [u32; 2],
    pixel: [u32; 2],
    color: [f64; 3],
    alpha: f64,
    antialias: &'a str,
    sample_count: u64,
    samples: Vec<Sample>,
    squares: Vec<Square>,
    path_of: Option<&'a str>,
    exact: bool,
    explained: Each<'a>,
}

/// The samples that are explained, each made when it is written.
struct Each<'a>(&'a Explained<'a>);

impl Serialize for Each<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Explained { explanation, records, .. } = self.0;
        serializer
            .collect_seq(explanation.trees.iter().zip(records).map(|(tree, record)| self.one(tree, record)))
    }
}

/// One sample.
#[derive(Serialize)]
struct One<'a> {
    sample: usize,
    place: [f64; 2],
    sum: [f64; 3],
    rendered: [f64; 3],
    alpha: f64,
    exact: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    touches: Option<bool>,
    #[serde(flatten)]
    what: What<'a>,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum What<'a> {
    Tree(Tree<'a>),
    Path(Box<Path<'a>>),
    FirstHit(FirstHit<'a>),
}

impl<'a> Each<'a> {
    fn one(&self, tree: &SampleTree, record: &'a Record) -> One<'a> {
        let Explained { names, explanation, .. } = self.0;
        let wanted = explanation.path_of.is_some();
        One {
            sample: tree.number,
            place: tree.sample.place,
            sum: color(tree.sum),
            rendered: color(tree.sample.radiance.color),
            alpha: f64::from(tree.sample.radiance.alpha),
            exact: tree.is_exact(),
            touches: wanted.then(|| tree.nodes.iter().any(|n| n.touches)),
            what: match record {
                Record::Tree(record) => What::Tree(classic_json::of(names, record)),
                Record::Path(record) => What::Path(Box::new(path_json::of(names, record))),
                Record::Other => What::FirstHit(first_hit(names, tree)),
            },
        }
    }
}

/// The text of an explanation.
pub(super) fn of(explained: &Explained<'_>, hash: &str) -> Result<String, serde_json::Error> {
    let Explained { names, explanation: e, .. } = explained;
    let samples = e.pixel.samples.iter().map(|s| Sample {
        place: s.place,
        share: s.weight,
        color: color(s.radiance.color),
        alpha: f64::from(s.radiance.alpha),
    });
    let squares = e.pixel.squares.iter().map(|s| Square { corner: s.corner, size: s.size, spread: s.spread });
    let mut out = serde_json::to_vec(&Explanation {
        format: "turner-explanation",
        version: VERSION,
        turner: env!("CARGO_PKG_VERSION"),
        scene: &e.scene,
        scene_hash: hash,
        integrator: e.integrator,
        seed: e.seed,
        size: e.size,
        pixel: [e.pixel.x, e.pixel.y],
        color: color(e.color()),
        alpha: f64::from(e.pixel.color[3]),
        antialias: names.scene.film.antialias.word(),
        sample_count: e.pixel.count,
        samples: samples.collect(),
        squares: squares.collect(),
        path_of: e.path_of.as_deref(),
        exact: e.is_exact(),
        explained: Each(explained),
    })?;
    out.push(b'\n');
    String::from_utf8(out).map_err(serde_json::Error::custom)
}

/// What integrators for looking at things show: the first hit.
#[derive(Serialize)]
struct FirstHit<'a> {
    camera: Option<Camera>,
    hit: Option<Surface<'a>>,
}

#[derive(Serialize)]
struct Surface<'a> {
    t: f64,
    position: Option<[f64; 3]>,
    geometric_normal: [f64; 3],
    shading_normal: [f64; 3],
    object: Object<'a>,
    material: Material<'a>,
}

fn first_hit<'a>(names: &Names<'a>, tree: &SampleTree) -> FirstHit<'a> {
    let node = tree.nodes.first();
    let hit = node.and_then(|n| {
        let ray = turner::render::camera_ray(names.scene, tree.sample.id, tree.sample.place)?;
        let hit = names.scene.intersect(&ray)?;
        let surface = names.scene.surface(&ray, &hit);
        Some(Surface {
            t: hit.shape.t,
            position: n.to.map(vector),
            geometric_normal: vector(surface.ng),
            shading_normal: vector(surface.ns),
            object: object(names, names.scene.primitive_id(&hit), names.scene.shape_word(&hit)),
            material: material(names, surface.material),
        })
    });
    let camera = node.map(|n| Camera { origin: vector(n.from), direction: vector(n.direction) });
    FirstHit { camera, hit }
}
