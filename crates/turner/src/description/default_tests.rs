//! `Default` of each type equals what an empty table of a scene file reads as.

use std::fmt::Debug;
use std::sync::Arc;

use super::borrowed_assets::{BorrowedAssets, WithBorrowed};
use super::write::Writer;
use crate::camera::{CameraDesc, PinholeDesc};
use crate::color::Transfer;
use crate::description::*;
use crate::film::{Antialias, FilmDesc};
use crate::image::{Image, Pixels};
use crate::integrator::{IntegratorDesc, PathDesc};
use crate::light::{LightDesc, PointDesc, SpotDesc};
use crate::material::{ClassicMaterial, MaterialDesc, MixMaterial};
use crate::math::DVec3;
use crate::medium::MediumDesc;
use crate::schema::value::{Data, FileId, Table, Value};
use crate::schema::{
    Asset, ErrorCode, FamilyDoc, KeyEdit, MediumId, MeshData, Named, PrepareOptions, SceneError, WriteContext,
};
use crate::shape::{ShapeDesc, SphereDesc};
use crate::texture::TextureDesc;

/// Assets without any files.
struct NoFiles;

fn refuse<T>() -> Result<T, SceneError> {
    Err(SceneError::new(ErrorCode::File, "there are no files"))
}

impl SceneAssets for NoFiles {
    fn image(&mut self, _: &str, _: FileId) -> Result<Arc<Image>, SceneError> {
        refuse()
    }
    fn mesh(&mut self, _: &str, _: FileId) -> Result<Arc<MeshData>, SceneError> {
        refuse()
    }
    fn model(&mut self, _: &ModelDesc, _: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        refuse()
    }
}

#[test]
fn an_empty_file_is_the_default_scene() {
    let file = Value::new(Data::Table(Table::default()));
    let read = read_scene(&file, &mut NoFiles).unwrap();
    assert_eq!(read.warnings.len(), 1, "that it is empty");
    assert_eq!(SceneDesc::default(), SceneDesc { warnings: Vec::new(), ..read });
}

#[test]
fn parts_of_an_empty_table_are_the_default_ones() {
    let section = |name: &str, value: Value| {
        let mut top = Table::default();
        top.push(name, value.data);
        read_scene(&Value::new(Data::Table(top)), &mut NoFiles).unwrap()
    };
    let empty = || Value::new(Data::Table(Table::default()));
    let in_list = || Value::new(Data::Array(vec![empty()]));
    let named = || {
        let mut table = Table::default();
        table.push("one", empty().data);
        Value::new(Data::Table(table))
    };
    assert_eq!(section("camera", empty()).camera.unwrap().value, CameraDesc::default());
    assert_eq!(section("view", in_list()).cameras[0].value, CameraDesc::default());
    assert_eq!(section("integrator", empty()).integrator, IntegratorDesc::default());
    assert_eq!(section("studio", empty()).studio, Some(StudioDesc::default()));
    assert_eq!(section("material", named()).materials[0].value, MaterialDesc::default());
    assert_eq!(section("medium", named()).media[0].value, MediumDesc::default());
    assert_eq!(section("group", named()).groups[0].value, GroupDesc::default());
}

/// A scene with an image and a mesh, for types that refer to one.
fn scene() -> SceneDesc {
    let pixels = Pixels::U8(vec![255; 3]);
    let image = Image { width: 1, height: 1, channels: 3, pixels };
    let mesh = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshData::default()
    };
    SceneDesc {
        images: vec![Asset { uri: "white.png".into(), data: Arc::new(image) }],
        meshes: vec![Asset { uri: "triangle.ply".into(), data: Arc::new(mesh) }],
        objects: vec![ObjectDesc::default()],
        integrator: IntegratorDesc::Path(PathDesc::default()),
        ..SceneDesc::default()
    }
}

/// Checks every type of a family: the keys that a file must give are those documented as required, the type reads back
/// as its default, and it can be prepared, except for those in `incomplete`.
fn check<T: Clone + Debug>(
    doc: &FamilyDoc,
    of_type: fn(&str) -> Option<T>,
    write: fn(&T, &mut dyn WriteContext) -> Result<Table, SceneError>,
    put: fn(&mut SceneDesc, T),
    incomplete: &[&str],
) {
    assert!(of_type("no such kind").is_none());
    for entry in doc.entries {
        let what = format!("the {} \"{}\"", doc.one, entry.name);
        let value = of_type(entry.name).unwrap_or_else(|| panic!("{what} has no default"));
        let mut desc = scene();
        put(&mut desc, value.clone());
        let mut lent = BorrowedAssets::of(&desc);

        let table = write(&value, &mut Writer::new(&desc, &mut lent)).unwrap();
        let keys: Vec<&str> = table.entries.iter().map(|e| e.key.as_str()).collect();
        let required = entry.fields.iter().filter(|f| f.default.is_none()).map(|f| f.name);
        let data = matches!(entry.name, "mesh" | "points" | "curves").then_some("file");
        let expected: Vec<&str> = std::iter::once("type").chain(required).chain(data).collect();
        assert_eq!(keys, expected, "{what}");

        let file = write_scene(&desc, &mut lent).unwrap();
        let read = read_scene(&file, &mut WithBorrowed { lent: &lent, files: &mut NoFiles });
        let read = read.unwrap_or_else(|e| panic!("{what}: {e}"));
        desc.same_scene(&read).unwrap_or_else(|e| panic!("{what}: {e}"));

        let prepared = desc.prepare(&PrepareOptions::default());
        let expected = !incomplete.contains(&entry.name);
        assert_eq!(prepared.is_ok(), expected, "{what}: {:?}", prepared.err());
    }
}

#[test]
fn every_kind_has_its_defaults() {
    let shape = |desc: &mut SceneDesc, shape| desc.objects = vec![ObjectDesc::new(shape)];
    // A text needs a font.
    check(&ShapeDesc::DOC, ShapeDesc::of_type, ShapeDesc::write, shape, &["text"]);
    let texture = |desc: &mut SceneDesc, texture: TextureDesc| desc.textures = vec![texture.into()];
    check(&TextureDesc::DOC, TextureDesc::of_type, TextureDesc::write, texture, &[]);
    let material = |desc: &mut SceneDesc, material: MaterialDesc| desc.materials = vec![material.into()];
    // A mix needs at least two materials.
    check(&MaterialDesc::DOC, MaterialDesc::of_type, MaterialDesc::write, material, &["mix"]);
    let medium = |desc: &mut SceneDesc, medium: MediumDesc| {
        desc.media = vec![medium.into()];
        desc.background.medium = Some(MediumId(0));
    };
    check(&MediumDesc::DOC, MediumDesc::of_type, MediumDesc::write, medium, &[]);
    let light = |desc: &mut SceneDesc, light: LightDesc| desc.lights = vec![light.into()];
    // A directional light needs `from` or `direction`.
    check(&LightDesc::DOC, LightDesc::of_type, LightDesc::write, light, &["directional"]);
    let camera = |desc: &mut SceneDesc, camera: CameraDesc| desc.camera = Some(camera.into());
    check(&CameraDesc::DOC, CameraDesc::of_type, CameraDesc::write, camera, &[]);
    let integrator = |desc: &mut SceneDesc, integrator| desc.integrator = integrator;
    check(&IntegratorDesc::DOC, IntegratorDesc::of_type, IntegratorDesc::write, integrator, &[]);
}

#[test]
fn the_first_kind_is_the_default() {
    assert_eq!(ShapeDesc::default(), ShapeDesc::Sphere(SphereDesc { center: DVec3::ZERO, radius: 1.0 }));
    assert_eq!(ObjectDesc::default(), ObjectDesc::new(ShapeDesc::default()));
    assert_eq!(CameraDesc::default(), CameraDesc::Pinhole(PinholeDesc::default()));
    assert_eq!(MaterialDesc::default(), MaterialDesc::Classic(ClassicMaterial::default()));
    assert_eq!(IntegratorDesc::default().type_name(), "classic");
    assert_eq!(MediumDesc::default().type_name(), "homogeneous");
}

#[test]
fn scenes_are_built_by_struct_update() {
    let camera = PinholeDesc { fov: Some(30.0), ..Default::default() };
    let scene = SceneDesc {
        camera: Some(CameraDesc::Pinhole(camera).into()),
        objects: vec![ObjectDesc::new(ShapeDesc::Sphere(SphereDesc { radius: 2.0, ..Default::default() }))],
        lights: vec![
            LightDesc::Point(PointDesc { intensity: 3.0, ..Default::default() }).into(),
            LightDesc::Spot(SpotDesc { angle: 12.0, ..Default::default() }).into(),
        ],
        materials: vec![Named::from(MaterialDesc::Mix(MixMaterial::default()))],
        ..Default::default()
    };
    let LightDesc::Spot(spot) = &scene.lights[1].value else { panic!("a spot light") };
    assert_eq!((spot.position, spot.look_at, spot.penumbra), (DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO, 5.0));
}

/// The film of a file with this integrator and these film keys, and the keys that it is written with.
fn film(integrator: &str, keys: &[(&str, Data)]) -> (FilmDesc, Vec<String>) {
    let (mut top, mut own, mut film) = (Table::default(), Table::default(), Table::default());
    own.push("type", Data::String(integrator.into()));
    keys.iter().for_each(|(key, data)| film.push(key, data.clone()));
    top.push("integrator", Data::Table(own));
    top.push("film", Data::Table(film));
    let read = read_scene(&Value::new(Data::Table(top)), &mut NoFiles).unwrap();
    let written = write_scene(&read, &mut BorrowedAssets::default()).unwrap();
    let again = read_scene(&written, &mut NoFiles).unwrap();
    assert_eq!(read.film, again.film, "{integrator}: what is written reads back");
    let Data::Table(root) = &written.data else { panic!("{written:?}") };
    let written = match root.get("film").map(|film| &film.data) {
        Some(Data::Table(film)) => film.entries.iter().map(|e| e.key.clone()).collect(),
        _ => Vec::new(),
    };
    (read.film, written)
}

#[test]
fn film_defaults_follow_the_integrator() {
    for entry in IntegratorDesc::DOC.entries {
        let (read, written) = film(entry.name, &[]);
        let (antialias, transfer, samples) = match entry.name {
            "path" => (Antialias::MonteCarlo, Transfer::Srgb, 64),
            "direct" => (Antialias::MonteCarlo, Transfer::Srgb, 16),
            "bounces" => (Antialias::MonteCarlo, Transfer::None, 16),
            _ => (Antialias::None, Transfer::None, 16),
        };
        let expected = FilmDesc { antialias, transfer, samples, ..FilmDesc::default() };
        assert_eq!((read, written.len()), (expected, 0), "{}", entry.name);
    }
    // Given keys win. They are written if they differ from the integrator's default.
    let given = [("transfer", Data::String("none".into())), ("samples", Data::Integer(16))];
    let (read, written) = film("path", &given);
    assert_eq!((read.antialias, read.transfer, read.samples), (Antialias::MonteCarlo, Transfer::None, 16));
    assert_eq!(written, ["samples", "transfer"]);
    assert_eq!(film("classic", &given).1.len(), 0);
}

#[test]
fn edits_keep_the_film_that_a_description_has() {
    let mut desc = SceneDesc::default();
    let path = KeyEdit::new("integrator.type", Data::String("path".into()));
    desc.edit(&[path, KeyEdit::new("film.width", Data::Integer(8))], &mut NoFiles).unwrap();
    assert_eq!(desc.film, FilmDesc { width: 8, ..FilmDesc::default() });
    // An edit that replaces all of it gives the film of a new file.
    desc.edit(&[KeyEdit::new("film", Data::Table(Table::default()))], &mut NoFiles).unwrap();
    assert_eq!(desc.film, FilmDesc::default_for("path"));
}
