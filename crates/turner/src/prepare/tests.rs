//! Updates give the bytes of fresh preparations, and prepare again only what an edit changes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use proptest::prelude::*;

use super::{Preparer, Rebuilt, UpdateOptions};
use crate::camera::{CameraDesc, PinholeDesc};
use crate::color::Spectrum;
use crate::description::{GroupDesc, ObjectContent, ObjectDesc, SceneDesc};
use crate::film::Antialias;
use crate::image::{Image, Pixels};
use crate::integrator::{IntegratorDesc, NormalsDesc, PathDesc, Prepared, SharedPathsMode};
use crate::light::{AmbientDesc, LightDesc, PointDesc};
use crate::material::{MaterialDesc, MatteMaterial, PrincipledMaterial};
use crate::math::{DAffine3, DMat3, DVec3};
use crate::render::{PassOptions, Renderer};
use crate::schema::{
    Asset, ColorSource, GroupId, ImageId, MaterialId, MeshData, MeshId, PrepareOptions, TextureId, Transform,
};
use crate::shape::{BoxDesc, MeshDesc, ShapeDesc, SphereDesc};
use crate::texture::TextureDesc;

/// A pyramid of four triangles over a square, with its apex at height `top`.
fn mesh(top: f32) -> Arc<MeshData> {
    let positions =
        vec![[-0.5, 0.0, -0.5], [0.5, 0.0, -0.5], [0.5, 0.0, 0.5], [-0.5, 0.0, 0.5], [0.0, top, 0.0]];
    let triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let uvs = positions.iter().map(|p: &[f32; 3]| [p[0] + 0.5, p[2] + 0.5]).collect();
    Arc::new(MeshData { positions, triangles, uvs, ..MeshData::default() })
}

fn picture(shade: u8) -> Arc<Image> {
    let samples = (0..16u8).flat_map(|i| [shade, i * 15, 255 - shade]).collect();
    Arc::new(Image { width: 4, height: 4, channels: 3, pixels: Pixels::U8(samples) })
}

fn grey(v: f32) -> ColorSource {
    ColorSource::Constant(Spectrum::grey(v))
}

fn point_light(position: [f64; 3], intensity: f64) -> LightDesc {
    LightDesc::Point(PointDesc { position: position.into(), intensity, ..Default::default() })
}

fn placed(content: ObjectContent, material: u32, at: [f64; 3]) -> ObjectDesc {
    let ball = SphereDesc { center: DVec3::ZERO, radius: 1.0 };
    let transform = Transform(DAffine3::from_translation(at.into()));
    let object = ObjectDesc::new(ShapeDesc::Sphere(ball));
    ObjectDesc { content, material: Some(MaterialId(material)), transform, ..object }
}

fn ball(material: u32, at: [f64; 3], radius: f64) -> ObjectDesc {
    let shape = ShapeDesc::Sphere(SphereDesc { center: DVec3::ZERO, radius });
    placed(ObjectContent::Shape(shape), material, at)
}

pub(super) fn shown(mesh: u32, material: u32, at: [f64; 3]) -> ObjectDesc {
    let shape = ShapeDesc::Mesh(MeshDesc { mesh: MeshId(mesh), ..MeshDesc::default() });
    placed(ObjectContent::Shape(shape), material, at)
}

/// Spheres, meshes in the world mesh and instances of a group, over a floor: matte, emissive, glass, textured.
pub(super) fn start() -> SceneDesc {
    let mut desc = SceneDesc::default();
    (desc.film.width, desc.film.height, desc.film.samples) = (20, 15, 2);
    desc.film.antialias = Antialias::MonteCarlo;
    desc.integrator = IntegratorDesc::Path(PathDesc { max_depth: 3, ..PathDesc::default() });
    desc.images.push(Asset { uri: "a.png".into(), data: picture(40) });
    desc.textures.push(image_texture().into());
    let principled = |m: PrincipledMaterial| MaterialDesc::Principled(m).into();
    desc.materials = vec![
        MaterialDesc::Matte(MatteMaterial { color: grey(0.5), ..MatteMaterial::default() }).into(),
        principled(PrincipledMaterial { emission_luminance: 3.0, ..PrincipledMaterial::default() }),
        principled(PrincipledMaterial { transmission_weight: grey(1.0), ..PrincipledMaterial::default() }),
        principled(PrincipledMaterial {
            base_color: ColorSource::Texture(TextureId(0)),
            ..PrincipledMaterial::default()
        }),
    ];
    desc.meshes = vec![
        Asset { uri: "a".into(), data: mesh(1.0) },
        Asset { uri: "b".into(), data: mesh(0.4) },
        Asset { uri: "c".into(), data: mesh(2.0) },
    ];
    let floor = BoxDesc {
        min: Some(DVec3::new(-4.0, -1.0, -4.0)),
        max: Some(DVec3::new(4.0, 0.0, 4.0)),
        center: None,
        size: None,
    };
    desc.groups.push(
        GroupDesc { objects: vec![ball(0, [0.0, 0.2, 0.0], 0.2), shown(2, 3, [0.4, 0.0, 0.0])], model: None }
            .into(),
    );
    let group = || ObjectContent::Instance(GroupId(0));
    desc.objects = vec![
        placed(ObjectContent::Shape(ShapeDesc::Box(floor)), 0, [0.0; 3]),
        ball(2, [0.0, 0.6, 1.0], 0.5),
        ball(1, [1.5, 2.0, 0.0], 0.3),
        shown(0, 3, [-1.0, 0.0, 0.0]),
        shown(1, 0, [1.0, 0.0, 0.5]),
        placed(group(), 0, [-1.5, 0.0, 1.0]),
        placed(group(), 3, [1.5, 0.0, 1.2]),
    ];
    desc.lights = vec![point_light([0.0, 4.0, 2.0], 12.0).into()];
    desc.camera = Some(camera(5.0).into());
    desc
}

fn image_texture() -> TextureDesc {
    use crate::texture::ImageDesc;
    TextureDesc::Image(ImageDesc { file: ImageId(0), ..Default::default() })
}

pub(super) fn camera(distance: f64) -> CameraDesc {
    CameraDesc::Pinhole(PinholeDesc {
        position: DVec3::new(0.3, 1.5, distance),
        look_at: DVec3::new(0.0, 0.6, 0.0),
        fov: Some(45.0),
        ..Default::default()
    })
}

/// The bits of the rendered picture, and the warnings.
pub(super) fn rendered(prepared: Prepared) -> (Vec<[u32; 4]>, Vec<String>) {
    let warnings = prepared.warnings.iter().map(|w| w.message.clone()).collect();
    let mut renderer = Renderer::new(prepared).unwrap();
    let never = AtomicBool::new(false);
    let options = PassOptions { threads: 2, cancel: &never, progress: None };
    assert!(renderer.pass(u32::MAX, &options).unwrap());
    (renderer.develop().linear.iter().map(|p| p.map(f32::to_bits)).collect(), warnings)
}

/// Whether an update gives the picture and the warnings of a fresh preparation.
pub(super) fn is_as_fresh(preparer: &mut Preparer, desc: &SceneDesc) -> bool {
    let fresh = desc.prepare(&PrepareOptions::default()).unwrap();
    rendered(preparer.update(desc).unwrap()) == rendered(fresh)
}

/// One edit, selected by two integers.
fn edit(desc: &mut SceneDesc, what: u8, by: u8) {
    let x = f64::from(by) / 64.0 - 2.0;
    let object = usize::from(by) % desc.objects.len().max(1);
    match what {
        0 => desc.camera = (!by.is_multiple_of(8)).then(|| camera(4.0 + x).into()),
        1 => desc.film.samples = 1 + u32::from(by % 3),
        2 => desc.film.exposure = x,
        3 => {
            let path = PathDesc { max_depth: u32::from(by % 4), ..PathDesc::default() };
            desc.integrator = match by % 5 {
                0 => IntegratorDesc::Path(PathDesc { shared_paths: SharedPathsMode::Always, ..path }),
                1 => IntegratorDesc::Normals(NormalsDesc::default()),
                2 => IntegratorDesc::Classic(Default::default()),
                _ => IntegratorDesc::Path(path),
            };
        }
        4 => {
            let material = MatteMaterial { color: grey(f32::from(by) / 255.0), ..Default::default() };
            desc.materials[0] = MaterialDesc::Matte(material).into();
        }
        5 => {
            let (emission_luminance, opacity) = (f64::from(by % 4), grey(f32::from(by % 3) * 0.5));
            let m = PrincipledMaterial { emission_luminance, opacity, ..Default::default() };
            desc.materials[usize::from(by) % 3 + 1] = MaterialDesc::Principled(m).into();
        }
        6 => desc.images[0].data = picture(by),
        7 => desc.lights.push(point_light([x, 3.0, x * x], 5.0).into()),
        8 if !desc.lights.is_empty() => {
            let light = usize::from(by) % desc.lights.len();
            desc.lights[light] = point_light([x, 2.5, 1.0], 1.0 + f64::from(by)).into();
        }
        9 => drop(desc.lights.pop()),
        10 if object > 0 => {
            desc.objects[object].transform.0.translation += DVec3::new(0.3 * x, 0.0, 0.2);
        }
        11 => desc.objects.push(match by % 3 {
            0 => ball(u32::from(by % 4), [x, 0.4, -0.5], 0.3),
            1 => shown(u32::from(by % 3), 0, [x, 0.0, -1.0]),
            _ => placed(ObjectContent::Instance(GroupId(0)), 0, [x, 0.0, -0.4]),
        }),
        12 if object > 0 => drop(desc.objects.remove(object)),
        13 => desc.meshes[usize::from(by) % 3].data = mesh(0.2 + f32::from(by) / 100.0),
        14 => desc.background.color = Spectrum::grey(f32::from(by % 5) * 0.2),
        15 => desc.objects[object].light_group = by.is_multiple_of(2).then(|| "group".to_owned()),
        16 => desc.studio = by.is_multiple_of(2).then(Default::default),
        17 => {
            let color = Spectrum::grey(f32::from(by) / 255.0);
            desc.lights.push(LightDesc::Ambient(AmbientDesc { color, intensity: 1.0 }).into());
        }
        18 => desc.objects[object].material = Some(MaterialId(u32::from(by) % 4)),
        19 => desc.film.shutter = [0.0, f64::from(by) / 255.0],
        20 => {
            let end = desc.objects[object].transform.0 * DAffine3::from_translation(DVec3::new(0.0, x, 0.0));
            desc.objects[object].motion = by.is_multiple_of(2).then_some(Transform(end));
        }
        21 => {
            let environment = crate::light::EnvironmentDesc {
                rotation: 40.0 * x,
                ..crate::light::EnvironmentDesc::studio()
            };
            desc.lights.push(LightDesc::Environment(environment).into());
        }
        _ => desc.groups[0].value.objects[0].transform.0.translation.y += 0.1,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn updates_have_the_bytes_of_fresh_preparations(
        edits in prop::collection::vec((0u8..23, any::<u8>()), 1..10),
    ) {
        let mut preparer = Preparer::new(PrepareOptions::default());
        let mut desc = start();
        preparer.update(&desc).unwrap();
        for (what, by) in edits {
            edit(&mut desc, what, by);
            prop_assert!(is_as_fresh(&mut preparer, &desc), "{what} {by}");
        }
    }
}

/// What an edit prepares again.
fn rebuilt(change: impl Fn(&mut SceneDesc)) -> Rebuilt {
    let mut preparer = Preparer::new(PrepareOptions::default());
    let mut desc = start();
    preparer.update(&desc).unwrap();
    change(&mut desc);
    preparer.update_with(&desc, &UpdateOptions::default()).unwrap().unwrap().rebuilt
}

#[test]
fn an_edit_remakes_what_it_changes() {
    let nothing = Rebuilt::default();
    let chooses = Rebuilt { integrator: true, ..nothing };
    assert_eq!(rebuilt(|_| ()), nothing);
    assert_eq!(rebuilt(|d| d.film.exposure = 1.0), nothing);
    assert_eq!(rebuilt(|d| d.camera = Some(camera(6.0).into())), chooses);
    assert_eq!(rebuilt(|d| d.film.samples = 7), chooses);
    assert_eq!(rebuilt(|d| d.integrator = IntegratorDesc::Path(PathDesc::default())), chooses);
    // A matte material affects neither geometry nor lights; an emissive one affects lights.
    assert_eq!(rebuilt(|d| edit(d, 4, 9)), Rebuilt { materials: 1, ..chooses });
    let emissive = |d: &mut SceneDesc| {
        let m = PrincipledMaterial { emission_luminance: 5.0, ..Default::default() };
        d.materials[1] = MaterialDesc::Principled(m).into();
    };
    assert_eq!(rebuilt(emissive), Rebuilt { materials: 1, light_tree: true, ..chooses });
    assert_eq!(rebuilt(|d| edit(d, 7, 9)), Rebuilt { lights: 1, light_tree: true, ..chooses });
    assert_eq!(rebuilt(|d| edit(d, 6, 9)), Rebuilt { textures: true, light_tree: true, ..chooses });
    let moved = Rebuilt { objects: true, light_tree: true, ..chooses };
    assert_eq!(rebuilt(|d| d.objects[1].transform.0.translation.x += 0.1), moved);
    let gathered = Rebuilt { world_mesh: true, ..moved };
    assert_eq!(rebuilt(|d| d.objects[3].transform.0.translation.x += 0.1), gathered);
    assert_eq!(rebuilt(|d| d.meshes[2].data = mesh(3.0)), Rebuilt { meshes: 1, ..gathered });
}

/// Cancelled at each step in turn.
#[test]
fn a_cancelled_update_leaves_the_next_one_right() {
    use super::PrepareStep::*;
    let mut preparer = Preparer::new(PrepareOptions::default());
    let mut desc = start();
    preparer.update(&desc).unwrap();
    for (what, step) in [(6, Surfaces), (4, Lights), (7, Objects), (10, Trees), (13, Trees), (5, Objects)] {
        edit(&mut desc, what, 67);
        let cancel = AtomicBool::new(false);
        let progress = |at| cancel.store(at == step, Ordering::Relaxed);
        let options =
            UpdateOptions { cancel: Some(&cancel), progress: Some(&progress), ..UpdateOptions::default() };
        assert!(preparer.update_with(&desc, &options).unwrap().is_none(), "{step:?}");
    }
    let fresh = rendered(desc.prepare(&PrepareOptions::default()).unwrap());
    assert!(rendered(preparer.update(&desc).unwrap()) == fresh);
}

/// The results of a failed update that stay cached are right for the next one.
#[test]
fn a_failed_update_leaves_the_next_one_right() {
    for what in [4, 5, 6, 7, 10, 13, 14] {
        let mut preparer = Preparer::new(PrepareOptions::default());
        let mut desc = start();
        preparer.update(&desc).unwrap();
        edit(&mut desc, what, 67);
        let mut bad = desc.clone();
        bad.objects[2].transform.0.matrix3 = DMat3::ZERO;
        assert!(preparer.update(&bad).is_err());
        let fresh = rendered(desc.prepare(&PrepareOptions::default()).unwrap());
        assert!(rendered(preparer.update(&desc).unwrap()) == fresh, "{what}");
    }
}
