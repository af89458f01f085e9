//! Keyframes of scene files, and of glTF files that they become.

use std::path::Path;

use turner::camera::CameraDesc;
use turner::description::{ObjectContent, SceneDesc};
use turner::light::LightDesc;
use turner::math::{DAffine3, DMat3, DVec3};
use turner::schema::transform::rotation;
use turner_io::convert::{ConvertOptions, to_glb};
use turner_io::scene::{LoadOptions, ModelOverrides, Override, load};

const SCENE: &str = r#"
[camera]
position = [0, 1, 8]
look_at = [0, 1, 0]

[[animation]]
target = "camera.position"
times = [0, 2]
values = [[0, 1, 8], [4, 1, 8]]

[[animation]]
target = "object.ball.transform"
times = [0, 1, 2]
values = [
    { rotate = [0, 0, 0], translate = [0, 0, 0] },
    { rotate = [0, 0, 90], translate = [0, 1.5, 0] },
    { rotate = [0, 0, 180], translate = [0, 0, 0] },
]
interpolation = "smooth"

[[animation]]
target = "light.lamp.position"
times = [0, 2]
values = [[0, 5, 0], [2, 5, 0]]

[[animation]]
target = "light.lamp.intensity"
times = [0, 2]
values = [1, 3]

[[animation]]
target = "material.paint.base_color"
times = [0, 1]
values = [[1, 0, 0], [0, 0, 1]]
interpolation = "step"

[material.paint]
type = "principled"

[[light]]
name = "lamp"
type = "point"
position = [0, 5, 0]
attenuation = "inverse-square"

[[object]]
name = "ball"
type = "box"
material = "paint"

[[object]]
name = "floor"
type = "rectangle"
"#;

fn at(path: &Path, time: f64, blur: bool) -> SceneDesc {
    let models = ModelOverrides { time: Some(time), frame: Some(0.5), ..ModelOverrides::default() };
    let overrides = if blur { vec![Override::parse("film.motion_blur=true").unwrap()] } else { Vec::new() };
    let options = LoadOptions { models, overrides, ..LoadOptions::default() };
    load(path, &options).unwrap_or_else(|e| panic!("{}: {}", path.display(), e.error)).desc
}

/// The transform in the scene of an object called `name`, and its motion.
fn placed(desc: &SceneDesc, name: &str) -> (DAffine3, Option<DAffine3>) {
    for object in &desc.objects {
        let own = (object.transform.0, object.motion.map(|motion| motion.0));
        if object.name.as_deref() == Some(name) {
            return own;
        }
        if let ObjectContent::Instance(group) = object.content {
            let inside = &desc.groups[group.index()].value.objects;
            if let Some(found) = inside.iter().find(|own| own.name.as_deref() == Some(name)) {
                let motion = found.motion.map(|motion| own.0 * motion.0);
                return (own.0 * found.transform.0, motion);
            }
        }
    }
    panic!("no object {name}")
}

fn camera(desc: &SceneDesc) -> &CameraDesc {
    desc.camera.as_ref().map_or_else(|| &desc.cameras[0].value, |camera| &camera.value)
}

fn lamp(desc: &SceneDesc) -> DVec3 {
    match &desc.lights[0].value {
        LightDesc::Point(lamp) => lamp.position,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_scene_has_the_values_of_its_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, SCENE).unwrap();
    let desc = at(&path, 0.5, false);
    // Smooth: the tangent at the top of the path is 0, that of the steady rotation is 90 degrees a second.
    let t: f64 = 0.5;
    let height = 1.5 * (3.0 * t * t - 2.0 * t * t * t);
    let angle = 90.0 * (3.0 * t * t - 2.0 * t * t * t) + 90.0 * (t * t * t - t * t);
    let expected = DAffine3 { matrix3: rotation(DVec3::Z, angle), translation: DVec3::new(0.0, height, 0.0) };
    assert!(placed(&desc, "ball").0.abs_diff_eq(expected, 1e-12), "{:?}", placed(&desc, "ball").0);
    assert_eq!(lamp(&desc), DVec3::new(0.5, 5.0, 0.0));
    assert!(!desc.moves());
    let blurred = at(&path, 1.0, true);
    let (_, motion) = placed(&blurred, "ball");
    assert!((motion.unwrap().translation.y - 0.75).abs() < 1e-12);
    assert_eq!(placed(&blurred, "floor").1, None);
    let moved = |motion: Option<turner::schema::Transform>| motion.unwrap().0.translation;
    assert!(moved(blurred.lights[0].motion).abs_diff_eq(DVec3::X * 0.5, 1e-12));
    assert!(camera(&blurred).motion().is_some());
}

#[test]
fn keyframes_become_a_gltf_animation() {
    let folder = tempfile::tempdir().unwrap();
    let (path, glb) = (folder.path().join("scene.toml"), folder.path().join("scene.glb"));
    std::fs::write(&path, SCENE).unwrap();
    let desc = at(&path, 0.0, false);
    let written = to_glb(&desc, &glb, &ConvertOptions::default()).unwrap();
    let said = format!("{:?}", written.warnings);
    assert!(said.contains("animations of other keys"), "{said}");
    for time in [0.0, 0.3, 1.0, 1.77, 2.0, 5.0] {
        let [own, again] = [&path, &glb].map(|path| at(path, time, false));
        let difference = |a: DAffine3, b: DAffine3| {
            (a.matrix3 - b.matrix3)
                .to_cols_array()
                .into_iter()
                .chain((a.translation - b.translation).to_array())
                .fold(0.0, |m: f64, v| m.max(v.abs()))
        };
        let apart = difference(placed(&own, "ball").0, placed(&again, "ball").0);
        // Between samples a curve is a line.
        assert!(apart < 2e-3, "{time}: {apart}");
        assert!(placed(&again, "floor").0.matrix3.abs_diff_eq(DMat3::IDENTITY, 1e-6));
        assert!((lamp(&own) - lamp(&again)).length() < 1e-5);
        let places = [&own, &again].map(|desc| *camera(desc).clone().placement_mut()[0]);
        assert!((places[0] - places[1]).length() < 1e-5, "{time}: {places:?}");
    }
    // Motion blur of a file of keyframes.
    let blurred = at(&glb, 1.0, true);
    let (_, motion) = placed(&blurred, "ball");
    assert!((motion.unwrap().translation.y - 0.75).abs() < 2e-3, "{motion:?}");
    assert_eq!(placed(&blurred, "floor").1, None);
    assert!(blurred.lights[0].motion.is_some() && camera(&blurred).motion().is_some());
    assert!(!at(&glb, 1.0, false).moves());
}
