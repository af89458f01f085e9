//! Converts descriptions of every type of every family with every key, generated from the format's own documentation.

use std::collections::BTreeSet;
use std::sync::Arc;

use turner::camera::CameraDesc;
use turner::description::{ModelDesc, ObjectContent, ObjectDesc, SceneAssets, SceneDesc, StudioDesc};
use turner::film::FilmDesc;
use turner::image::Image;
use turner::integrator::IntegratorDesc;
use turner::light::{BackgroundDesc, LightDesc};
use turner::material::MaterialDesc;
use turner::medium::MediumDesc;
use turner::schema::value::{Data, FileId, Span, Value};
use turner::schema::{
    EntryDoc, Field, Font, GridData, KeyEdit, KeyPart, LightProfile, MeasuredBrdf, MeasuredFile, MeshData,
    SceneError,
};
use turner::shape::ShapeDesc;
use turner::texture::TextureDesc;
use turner_io::assets::MemoryAssets;
use turner_io::convert::ConvertOptions;
use turner_io::scene::{LoadOptions, load_text};

use super::round_trip;

/// A random number generator (Steele, Lea & Flood 2014, SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Common parts of all scenes, for others to refer to.
const BASE: &str = "[texture.base]\ntype = \"marble\"\n\n[material.base]\ntype = \"metal\"\n\n[medium.base]\nextinction = 2\n\n";

fn assets() -> MemoryAssets {
    let mut assets = MemoryAssets::default();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/");
    assets.files.insert("p.png".into(), std::fs::read(format!("{data}basn2c08.png")).unwrap());
    assets.files.insert("m.ply".into(), std::fs::read(format!("{data}cube_blender_uv.ply")).unwrap());
    let profile = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1.5 3 5 1 2 0 0 0\n1 1 0\n0 45.1 90\n0 90 180 270 360\n\
                1 2.7 0.1\n4 5 6\n7 8 9\n4 5 6\n1 2.7 0.1\n";
    assets.files.insert("l.ies".into(), profile.into());
    let grid = turner_io::grid::encode([2, 1, 2], &[0.1, 2.0, 0.0, 7.25], Some(&[1.0, 0.3, 0.0, 2.0]));
    assets.files.insert("g.grid".into(), grid);
    let mut measured = Vec::new();
    turner_io::measured::write(&MeasuredFile::default().data, &mut measured).unwrap();
    assets.files.insert("b.bsdf".into(), measured);
    assets.files.insert("f.ttf".into(), include_bytes!("../../../src/testing/font.ttf").to_vec());
    assets
}

fn read(text: &str) -> Result<SceneDesc, String> {
    let loaded = load_text(text.to_owned(), "s.toml", &assets(), &LoadOptions::default());
    loaded.map(|l| l.desc).map_err(|e| e.error.message)
}

/// A number of the field's range, in one of the ways to write numbers.
fn number(field: &Field, random: &mut Random) -> String {
    let (min, max) = field.range.map_or((-1e9, 1e9), |r| (r.min.max(-1e12), r.max.min(1e12)));
    let v = match random.below(5) {
        0 => min + (max - min) * random.unit(),
        1 => random.unit(),
        2 => (random.unit() * 9.0).floor() + 1.0,
        3 => random.unit() * 1e-9,
        _ => f64::from((random.unit() * 100.0) as f32),
    };
    format!("{:?}", v.clamp(min, max))
}

fn integer(field: &Field, random: &mut Random) -> String {
    let (min, max) = field.range.map_or((0.0, 9.0), |r| (r.min.max(0.0), r.max.min(300.0)));
    format!("{}", min as u64 + random.next() % (max as u64 - min as u64 + 1))
}

fn color(field: &Field, random: &mut Random) -> String {
    match random.below(4) {
        0 => "\"tomato\"".into(),
        1 => "\"#3a5\"".into(),
        2 => format!("{:?}", random.unit() as f32),
        _ => {
            let one = |r: &mut Random| if field.range.is_some() { r.unit() } else { r.unit() * 40.0 - 9.0 };
            format!("[{}, {}, {}]", one(random), one(random), one(random) as f32)
        }
    }
}

fn source(field: &Field, random: &mut Random) -> String {
    match random.below(3) {
        0 => "\"base\"".into(),
        1 => "{ type = \"noise\", density = 3.25 }".into(),
        _ => color(field, random),
    }
}

fn transform(random: &mut Random) -> String {
    match random.below(5) {
        0 => "{ translate = [1, -2.5, 0.1] }".into(),
        1 => format!("{{ scale = {:?}, translate = [0, 0, 7] }}", 0.1 + random.unit()),
        2 => "{ scale = [1, -0.5, 3], rotate = [10, 20, 30] }".into(),
        3 => format!(
            "[{{ rotate = {{ axis = [1, 1, 0], angle = {:?} }} }}, {{ look_at = {{ to = [0, -1, 5] }} }}]",
            90.0 * random.unit()
        ),
        _ => "{ matrix = [[1, 0.1, 0, -0.0], [0, 1, -0.0, 5e-324], [0.3, 0, -2, 1e300]] }".into(),
    }
}

/// Lists of a mesh; their lengths must match.
fn of_a_mesh(key: &str) -> Option<&'static str> {
    Some(match key {
        "positions" => "[[0, 0, 0.1], [1e-7, 0, 0], [0, 1.7, 0]]",
        "triangles" => "[[0, 1, 2], [2, 1, 0]]",
        "polygons" => "[[0, 1, 2, 1], [2, 1, 0]]",
        "creases" => "[[0, 1, 2.5], [2, 2, 10]]",
        "normals" => "[[0, 0, 1], [0, 0, 1], [0.6, 0, 0.8]]",
        "uvs" | "uvs_1" => "[[0, 0], [1, 0.3], [0.1, 1]]",
        "tangents" => "[[1, 0, 0, 1], [1, 0, 0, -1], [0.8, 0, -0.6, 1]]",
        "colors" => "[[0.1, 0.2, 0.3, 1], [0, 0, 0, 0.5], [1, 1, 1, 1]]",
        "face_materials" => "[0, 1]",
        "materials" => "[\"base\", false, { type = \"matte\" }]",
        "radii" | "widths" => "[0.1, 0.2, 0.3]",
        "points" => "[[0, 0, 0.1], [1, 0.5, 0], [0, 1.7, 0]]",
        "strands" => "[3]",
        _ => return None,
    })
}

/// A value for a key, by the type names of the documentation.
fn value(entry: &EntryDoc, field: &Field, random: &mut Random) -> String {
    if matches!(entry.name, "mesh" | "points" | "curves")
        && let Some(lists) = of_a_mesh(field.name)
    {
        return lists.into();
    }
    let kind = (field.kind)();
    let several = |n: usize, random: &mut Random, one: &dyn Fn(&Field, &mut Random) -> String| {
        let items: Vec<String> = (0..n).map(|_| one(field, random)).collect();
        format!("[{}]", items.join(", "))
    };
    match kind.as_str() {
        "number" => number(field, random),
        "integer" => integer(field, random),
        "true | false" => ["true", "false"][random.below(2)].into(),
        "\"text\"" if field.name == "file" => "\"m.ply\"".into(),
        "\"text\"" => "\"any \\\" text\\u0007 ü\"".into(),
        "[x, y, z]" => several(3, random, &number),
        "[u, v]" | "[number, number]" => several(2, random, &number),
        "[[u, v], …]" => "[[0, 0.5], [2.5, 0], [1, 1e-3]]".into(),
        "[[[u, v], …], …]" => "[[[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]], []]".into(),
        "[[number, number, number, number], …]" => "[[1, 2, 0, 0.5], [0.1, 0, 1, 1]]".into(),
        "[[number, number, number, number, number], …]" => "[[0.5, 0, 0, 1, 2]]".into(),
        "[[number, number, number, number, number, number, number, number], …]" => {
            "[[0, 0, 0, 1, 0, 0, 0.5, -1]]".into()
        }
        "[{ type = shape, transform, material, inverse }, …]" => format!(
            "[{{ type = \"sphere\", radius = 0.5, material = \"base\", transform = {} }}, {{ type = \"union\", parts = [{{ type = \"box\", inverse = true }}] }}]",
            transform(random)
        ),
        "[number, number, number, number, number, number]" => several(6, random, &number),
        "[integer, integer, integer, integer]" => several(4, random, &integer),
        "[integer, …]" => several(3, random, &integer),
        "[\"aov\", …]" => "[\"albedo\", \"depth\", \"crypto_object\"]".into(),
        "color" => color(field, random),
        "color | texture" => source(field, random),
        "[color | texture, …]" => several(2, random, &source),
        "[[position, color | texture], …]" => {
            format!("[[0.25, {}], [0.5, {}]]", source(field, random), source(field, random))
        }
        "[color, …]" => several(3, random, &color),
        "\"image file\"" => "\"p.png\"".into(),
        "\"IES file\"" => "\"l.ies\"".into(),
        "\"BSDF file\"" => "\"b.bsdf\"".into(),
        "\"grid file\"" => "\"g.grid\"".into(),
        "\"font file\"" => "\"f.ttf\"".into(),
        "material" => "\"base\"".into(),
        "[material, …]" => "[\"base\", { type = \"plastic\" }]".into(),
        "medium" => ["\"base\"", "{ extinction = 0.7, albedo = 0.2 }"][random.below(2)].into(),
        "transform" => transform(random),
        "[width, height] | height" => {
            [number(field, random).replace('-', ""), "[4, 3.5]".into()][random.below(2)].clone()
        }
        "\"none\" | \"inverse-square\" | [constant, linear, quadratic]" => {
            ["\"none\"", "\"inverse-square\"", "[0.1, 0.5, 2]"][random.below(3)].into()
        }
        words if words.starts_with('"') && words.ends_with('"') => {
            let words: Vec<&str> = words.split(" | ").collect();
            words[random.below(words.len())].to_owned()
        }
        other => panic!("the generator does not know the type {other} of `{}` in {}", field.name, entry.name),
    }
}

/// The keys of one table.
fn keys(
    entry: &EntryDoc,
    round: usize,
    random: &mut Random,
    used: &mut Vec<&'static str>,
    is_new: impl Fn(&'static str) -> bool,
) -> String {
    used.clear();
    let mut text = String::new();
    for field in entry.fields {
        // A mesh is either in a file or inline.
        if matches!(entry.name, "mesh" | "points" | "curves") {
            let of_both = matches!(
                field.name,
                "materials"
                    | "smooth"
                    | "radius"
                    | "subdivision"
                    | "levels"
                    | "creases"
                    | "crease_angle"
                    | "keep_corners"
                    | "edge_length"
                    | "displacement"
                    | "displacement_scale"
                    | "displacement_midlevel"
                    | "width"
                    | "basis"
                    | "kind"
            );
            if !of_both && (field.name == "file") == round.is_multiple_of(2) {
                continue;
            }
        }
        // Keys that were not yet used are very likely to be chosen.
        let chance = if is_new(field.name) { 16 } else { 2 };
        if field.default.is_none() || random.below(chance) > 0 {
            text += &format!("{} = {}\n", field.name, value(entry, field, random));
            used.push(field.name);
        }
    }
    text
}

/// All tables of a scene: the section, its documentation, and whether the table has a `type` key.
fn everything() -> Vec<(&'static str, &'static EntryDoc, bool)> {
    let mut all: Vec<(&'static str, &'static EntryDoc, bool)> = Vec::new();
    for (section, entries) in [
        ("camera", CameraDesc::DOC.entries),
        ("view", CameraDesc::DOC.entries),
        ("integrator", IntegratorDesc::DOC.entries),
        ("texture", TextureDesc::DOC.entries),
        ("material", MaterialDesc::DOC.entries),
        ("medium", MediumDesc::DOC.entries),
        ("light", LightDesc::DOC.entries),
        ("object", ShapeDesc::DOC.entries),
    ] {
        all.extend(entries.iter().map(|entry| (section, *entry, true)));
    }
    all.extend([
        ("film", &FilmDesc::DOC, false),
        ("background", &BackgroundDesc::DOC, false),
        ("studio", &StudioDesc::DOC, false),
    ]);
    all
}

fn head(section: &str, i: usize) -> String {
    match section {
        "texture" | "material" | "medium" => format!("[{section}.\"{i} of \\u0001 them\"]\n"),
        "view" => format!("[[view]]\nname = \"view {i}\"\n"),
        "light" => {
            let motion = ["", "motion = { translate = [0, 1, 0] }\n", "motion = {}\n"][i % 3];
            format!("[[light]]\ngroup = \"key lights\"\nname = \"light {i}\"\n{motion}")
        }
        "object" => {
            format!(
                "[[object]]\nname = \"{i}\"\nlight_group = \"key lights\"\nshadow_catcher = true\n\
                 hidden_from_camera = true\n"
            )
        }
        _ => format!("[{section}]\n"),
    }
}

#[test]
fn every_kind_with_every_key_comes_back_the_same() {
    let mut random = Random(7);
    let mut covered = BTreeSet::new();
    for round in 0..32 {
        let mut text = String::from(BASE);
        let mut only_one = BTreeSet::new();
        for (i, (section, entry, has_type)) in everything().into_iter().enumerate() {
            let is_list = matches!(section, "texture" | "material" | "medium" | "view" | "light" | "object");
            // A section that exists once gets another type in each round.
            let of_it = everything().iter().filter(|(s, ..)| *s == section).count();
            let position = everything().iter().take(i).filter(|(s, ..)| *s == section).count();
            if !is_list && (position != round % of_it || !only_one.insert(section)) {
                continue;
            }
            let mut used = Vec::new();
            let is_new = |key: &'static str| !covered.contains(&(section, entry.name, key));
            // Contradictory keys are rejected; then try others.
            let thing = (0..200).find_map(|attempt| {
                let mut thing = head(section, i);
                if has_type {
                    thing += &format!("type = \"{}\"\n", entry.name);
                }
                // Contradictory keys are not combined.
                let is_new = |key| attempt < 10 && is_new(key);
                thing += &keys(entry, round, &mut random, &mut used, is_new);
                if section == "object" {
                    let motion = ["", "motion = { translate = [0, 1, 0] }\n", "motion = {}\n"][round % 3];
                    thing +=
                        &format!("material = \"base\"\ntransform = {}\n{motion}", transform(&mut random));
                }
                read(&format!("{BASE}{thing}")).ok().map(|_| thing)
            });
            let thing = thing.unwrap_or_else(|| {
                let thing = format!(
                    "{BASE}{}{}",
                    head(section, i),
                    keys(entry, round, &mut random, &mut used, is_new)
                );
                panic!("no {section} \"{}\" can be made: {:?}\n{thing}", entry.name, read(&thing).err())
            });
            covered.extend(used.iter().map(|key| (section, entry.name, *key)));
            text += &thing;
            text.push('\n');
        }
        let interpolation = ["step", "linear", "smooth"][round % 3];
        text += &format!(
            "[[animation]]\nname = \"{round}\"\ntarget = \"object.0.transform\"\ntimes = [0.25, 1.5]\nvalues = [{{ scale = 2 }}, \
             {{ scale = {round}.5 }}]\ninterpolation = \"{interpolation}\"\nrepeat = {}\n",
            round % 2 == 0
        );
        text += "[[group.\"a b\".object]]\ntype = \"sphere\"\n\n[[group.\"a b\".object]]\ntype = \"instance\"\ngroup = \"empty\"\n\n[group.empty]\n\n\
                 [[object]]\ntype = \"instance\"\ngroup = \"a b\"\nmaterial = { color = \"red\" }\n";
        let desc = read(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        edits_of_nothing_change_nothing(&desc);
        let (first, _) = round_trip(&desc, &ConvertOptions::default(), &format!("round {round}"));
        // Converting the result again gives the same text.
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out.toml");
        turner_io::convert::to_toml(&desc, &out, &ConvertOptions::default()).unwrap();
        assert_eq!(std::fs::read_to_string(&out).unwrap(), first);
    }
    let all =
        everything().into_iter().flat_map(|(s, e, _)| e.fields.iter().map(move |f| (s, e.name, f.name)));
    let missing: Vec<_> = all.filter(|key| !covered.contains(key)).collect();
    assert!(missing.is_empty(), "never written: {missing:?}");
}

/// Writes each part of a scene and reads it back as an edit; the edits must not change anything.
fn edits_of_nothing_change_nothing(desc: &SceneDesc) {
    let word = |word: &str| Data::String(word.to_owned());
    let edit = |path: &[&str], data: Data| {
        let part = |key: &&str| KeyPart { key: (*key).to_owned(), span: Span::NONE };
        KeyEdit { path: path.iter().map(part).collect(), value: Value::new(data) }
    };
    let mut edits = vec![
        edit(&["film", "width"], Data::Integer(desc.film.width.into())),
        edit(&["integrator", "type"], word(desc.integrator.type_name())),
        edit(&["background", "transparent"], Data::Bool(desc.background.transparent)),
    ];
    if let Some(studio) = &desc.studio {
        edits.push(edit(&["studio", "lights"], Data::Bool(studio.lights)));
    }
    if let Some(camera) = &desc.camera {
        edits.push(edit(&["camera", "type"], word(camera.value.type_name())));
    }
    let numbered = |list: &str, i: usize, kind: &str| edit(&[list, &i.to_string(), "type"], word(kind));
    edits.extend(desc.cameras.iter().enumerate().map(|(i, c)| numbered("view", i, c.value.type_name())));
    edits.extend(desc.lights.iter().enumerate().map(|(i, l)| numbered("light", i, l.value.type_name())));
    let kind = |object: &ObjectDesc| match &object.content {
        ObjectContent::Shape(shape) => shape.type_name(),
        ObjectContent::Instance(_) => "instance",
    };
    edits.extend(desc.objects.iter().enumerate().map(|(i, o)| numbered("object", i, kind(o))));
    let named = |section: &str, name: Option<&String>, i: usize, kind: &str| {
        let name = name.cloned().unwrap_or_else(|| format!("{section}-{}", i + 1));
        edit(&[section, &name, "type"], word(kind))
    };
    for (i, thing) in desc.textures.iter().enumerate() {
        edits.push(named("texture", thing.name.as_ref(), i, thing.value.type_name()));
    }
    for (i, thing) in desc.materials.iter().enumerate() {
        edits.push(named("material", thing.name.as_ref(), i, thing.value.type_name()));
    }
    for (i, thing) in desc.media.iter().enumerate() {
        edits.push(named("medium", thing.name.as_ref(), i, thing.value.type_name()));
    }
    edits.push(edit(&["group", "a b", "object", "0", "type"], word("sphere")));
    let mut edited = desc.clone();
    edited.edit(&edits, &mut NoFiles).unwrap_or_else(|e| panic!("{e}"));
    if let Err(difference) = desc.same_scene(&edited) {
        panic!("{}", difference.chars().take(4000).collect::<String>());
    }
    assert_eq!((desc.images.len(), desc.meshes.len()), (edited.images.len(), edited.meshes.len()));
}

/// A source for parts that are read back: their data is already loaded.
struct NoFiles;

impl SceneAssets for NoFiles {
    fn image(&mut self, uri: &str, _: FileId) -> Result<Arc<Image>, SceneError> {
        panic!("{uri} is read again")
    }
    fn mesh(&mut self, uri: &str, _: FileId) -> Result<Arc<MeshData>, SceneError> {
        panic!("{uri} is read again")
    }
    fn light_profile(&mut self, uri: &str, _: FileId) -> Result<Arc<LightProfile>, SceneError> {
        panic!("{uri} is read again")
    }
    fn measured_brdf(&mut self, uri: &str, _: FileId) -> Result<Arc<MeasuredBrdf>, SceneError> {
        panic!("{uri} is read again")
    }
    fn grid(&mut self, uri: &str, _: FileId) -> Result<Arc<GridData>, SceneError> {
        panic!("{uri} is read again")
    }
    fn font(&mut self, uri: &str, _: FileId) -> Result<Arc<dyn Font>, SceneError> {
        panic!("{uri} is read again")
    }
    fn model(&mut self, model: &ModelDesc, _: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        panic!("{} is read again", model.file)
    }
}

/// Each key of a material must affect the physically based material; otherwise it was forgotten there. Classic
/// materials, hair, Disney's and measured materials are only approximated, and mixes have none.
#[test]
fn every_key_of_a_material_counts() {
    let mut random = Random(11);
    let principled = |entry: &EntryDoc, keys: &str| {
        let desc = read(&format!("{BASE}[material.m]\ntype = \"{}\"\n{keys}", entry.name))?;
        let material = desc.materials.iter().find(|m| m.name.as_deref() == Some("m"));
        Ok::<_, String>(material.and_then(|m| m.value.principled()))
    };
    let is_approximated =
        |e: &&EntryDoc| matches!(e.name, "classic" | "mix" | "hair" | "disney" | "measured");
    for entry in MaterialDesc::DOC.entries.iter().filter(|e| !is_approximated(e)) {
        let plain = principled(entry, "").unwrap();
        for field in entry.fields {
            let counts = (0..60).any(|_| {
                let keys = format!("{} = {}\n", field.name, value(entry, field, &mut random));
                principled(entry, &keys).is_ok_and(|changed| changed != plain)
            });
            assert!(counts, "`{}` of the material {} changes nothing", field.name, entry.name);
        }
    }
}
