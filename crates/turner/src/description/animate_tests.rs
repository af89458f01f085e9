use std::sync::Arc;

use crate::animation::{AnimationDesc, Interpolation, Keyframes};
use crate::camera::{CameraDesc, PinholeDesc};
use crate::description::SceneDesc;
use crate::description::borrowed_assets::BorrowedAssets;
use crate::description::{ModelDesc, ObjectDesc, SceneAssets, read_scene, write_scene};
use crate::image::Image;
use crate::light::{LightDesc, PointDesc};
use crate::math::{DAffine3, DMat3, DVec3};
use crate::schema::transform::rotation;
use crate::schema::value::Value;
use crate::schema::value::{Data, FileId, Table};
use crate::schema::{Font, GridData, KeyEdit, LightProfile, MeshData, Transform};
use crate::schema::{Named, SceneError};
use crate::testing::scenes::{sphere, v};

/// No scene of these tests names a file.
struct NoFiles;

impl SceneAssets for NoFiles {
    fn image(&mut self, _: &str, _: FileId) -> Result<Arc<Image>, SceneError> {
        unreachable!()
    }
    fn mesh(&mut self, _: &str, _: FileId) -> Result<Arc<MeshData>, SceneError> {
        unreachable!()
    }
    fn light_profile(&mut self, _: &str, _: FileId) -> Result<Arc<LightProfile>, SceneError> {
        unreachable!()
    }
    fn grid(&mut self, _: &str, _: FileId) -> Result<Arc<GridData>, SceneError> {
        unreachable!()
    }
    fn font(&mut self, _: &str, _: FileId) -> Result<Arc<dyn Font>, SceneError> {
        unreachable!()
    }
    fn model(&mut self, _: &ModelDesc, _: FileId) -> Result<Arc<SceneDesc>, SceneError> {
        unreachable!()
    }
}

fn number(v: f64) -> Value {
    Value::new(Data::Number(v))
}

fn vector(v: [f64; 3]) -> Value {
    Value::new(Data::Array(v.map(number).to_vec()))
}

fn table(entries: &[(&str, Value)]) -> Value {
    let mut table = Table::default();
    entries.iter().for_each(|(key, value)| table.push(key, value.data.clone()));
    Value::new(Data::Table(table))
}

fn animation(target: &str, keys: &[(f64, Value)], interpolation: Interpolation) -> AnimationDesc {
    AnimationDesc {
        target: target.to_owned(),
        times: keys.iter().map(|(time, _)| *time).collect(),
        values: Keyframes(keys.iter().map(|(_, value)| value.clone()).collect()),
        interpolation,
        repeat: false,
    }
}

fn named(value: AnimationDesc) -> Named<AnimationDesc> {
    Named { name: None, span: None, value }
}

/// The intensity of the only light at a time.
fn intensity(own: &AnimationDesc, time: f64) -> f64 {
    let mut desc =
        SceneDesc { lights: vec![LightDesc::Point(PointDesc::default()).into()], ..SceneDesc::default() };
    desc.animations.push(named(own.clone()));
    desc.animate(time, None, &mut NoFiles).unwrap();
    match &desc.lights[0].value {
        LightDesc::Point(light) => light.intensity,
        _ => panic!("no point light"),
    }
}

#[test]
fn numbers_follow_the_interpolation() {
    let keys = [(1.0, number(2.0)), (2.0, number(6.0)), (4.0, number(7.0)), (5.0, number(3.0))];
    let of = |kind| animation("light.0.intensity", &keys, kind);
    let [step, linear, smooth] = [Interpolation::Step, Interpolation::Linear, Interpolation::Smooth].map(of);
    for own in [&step, &linear, &smooth] {
        for (time, expected) in [(-1.0, 2.0), (1.0, 2.0), (2.0, 6.0), (4.0, 7.0), (5.0, 3.0), (9.0, 3.0)] {
            assert!((intensity(own, time) - expected).abs() < 1e-12, "{own:?} at {time}");
        }
    }
    assert_eq!(intensity(&step, 3.9), 6.0);
    assert_eq!(intensity(&linear, 1.25), 3.0);
    assert_eq!(intensity(&linear, 3.0), 6.5);
    // No overshoot, no jumps of the slope, and rest at both ends and at the largest value.
    let at = |time: f64| intensity(&smooth, time);
    let slope = |time: f64| (at(time + 1e-5) - at(time - 1e-5)) / 2e-5;
    let values: Vec<f64> = (0..=400).map(|i| at(1.0 + f64::from(i) / 100.0)).collect();
    assert!(values[..=300].windows(2).all(|w| w[1] >= w[0] - 1e-12));
    assert!(values[300..].windows(2).all(|w| w[1] <= w[0] + 1e-12));
    for time in [1.0, 4.0, 5.0] {
        assert!(slope(time).abs() < 1e-3, "{time}: {}", slope(time));
    }
    assert!((slope(2.0 - 1e-4) - slope(2.0 + 1e-4)).abs() < 1e-2 && slope(2.0) > 0.3);
    // Two keyframes: 3t² − 2t³.
    let two = animation("light.0.intensity", &keys[..2], Interpolation::Smooth);
    assert!((intensity(&two, 1.25) - (2.0 + 4.0 * (3.0 / 16.0 - 2.0 / 64.0))).abs() < 1e-12);
}

#[test]
fn animations_repeat() {
    let keys = [(1.0, number(2.0)), (3.0, number(6.0))];
    let own = AnimationDesc { repeat: true, ..animation("light.0.intensity", &keys, Interpolation::Linear) };
    for (time, expected) in [(2.0, 4.0), (4.0, 4.0), (3.5, 3.0), (0.0, 4.0), (-3.5, 5.0)] {
        assert!((intensity(&own, time) - expected).abs() < 1e-12, "{time}");
    }
}

/// The transform of the only object, which is named "ball", at a time.
fn transform(keys: &[(f64, Value)], interpolation: Interpolation, time: f64) -> DAffine3 {
    let ball = ObjectDesc { name: Some("ball".to_owned()), ..ObjectDesc::new(sphere(DVec3::ZERO, 1.0)) };
    let mut desc = SceneDesc { objects: vec![ball], ..SceneDesc::default() };
    desc.animations.push(named(animation("object.ball.transform", keys, interpolation)));
    desc.animate(time, None, &mut NoFiles).unwrap();
    desc.objects[0].transform.0
}

fn close(a: &DAffine3, b: &DAffine3) -> bool {
    a.abs_diff_eq(*b, 1e-9)
}

#[test]
fn steps_of_transforms_are_interpolated_by_their_numbers() {
    let turn =
        |degrees, x| table(&[("rotate", vector([0.0, degrees, 0.0])), ("translate", vector([x, 0.0, 0.0]))]);
    let keys = [(0.0, turn(0.0, 0.0)), (2.0, turn(720.0, 4.0))];
    let expected =
        DAffine3::from_translation(v(1.0, 0.0, 0.0)) * DAffine3::from_mat3(rotation(DVec3::Y, 180.0));
    assert!(close(&transform(&keys, Interpolation::Linear, 0.5), &expected));
}

#[test]
fn matrices_turn_along_the_shorter_arc() {
    let matrix = |degrees: f64, x: f64| {
        let own = DAffine3 { matrix3: rotation(DVec3::Z, degrees) * 2.0, translation: v(x, 0.0, 0.0) };
        Value::new(Transform(own).to_data())
    };
    let keys = [(0.0, matrix(10.0, 0.0)), (1.0, matrix(110.0, 3.0))];
    let seen = transform(&keys, Interpolation::Linear, 0.25);
    let expected = DAffine3 { matrix3: rotation(DVec3::Z, 35.0) * 2.0, translation: v(0.75, 0.0, 0.0) };
    assert!(close(&seen, &expected), "{seen:?}");
    // A table of steps and a matrix.
    let keys = [(0.0, table(&[("translate", vector([1.0, 0.0, 0.0]))])), (1.0, matrix(90.0, 3.0))];
    let seen = transform(&keys, Interpolation::Smooth, 0.5);
    let expected = DAffine3 { matrix3: rotation(DVec3::Z, 45.0) * 1.5, translation: v(2.0, 0.0, 0.0) };
    assert!(close(&seen, &expected), "{seen:?}");
}

#[test]
fn motion_blur_is_what_a_frame_moves() {
    let mut desc = SceneDesc::default();
    for name in ["ball", "still", "driven"] {
        let mut own = ObjectDesc { name: Some(name.to_owned()), ..ObjectDesc::new(sphere(DVec3::ZERO, 1.0)) };
        own.motion = (name == "driven").then_some(Transform(DAffine3::from_scale(DVec3::splat(2.0))));
        desc.objects.push(own);
    }
    desc.lights.push(LightDesc::Point(PointDesc::default()).into());
    desc.camera = Some(CameraDesc::Pinhole(PinholeDesc::default()).into());
    let path = [(0.0, vector([0.0, 1.0, 5.0])), (10.0, vector([10.0, 1.0, 5.0]))];
    let shift = |x: f64| table(&[("translate", vector([x, 0.0, 0.0]))]);
    for name in ["ball", "driven"] {
        let keys = [(0.0, shift(0.0)), (10.0, shift(20.0))];
        desc.animations.push(named(animation(
            &format!("object.{name}.transform"),
            &keys,
            Interpolation::Linear,
        )));
    }
    desc.animations.push(named(animation("light.0.position", &path, Interpolation::Linear)));
    desc.animations.push(named(animation("camera.position", &path, Interpolation::Linear)));
    desc.animations.push(named(animation(
        "camera.look_at",
        &path.map(|(t, p)| {
            let Data::Array(items) = p.data else { panic!() };
            (t, Value::new(Data::Array(vec![items[0].clone(), items[1].clone(), number(0.0)])))
        }),
        Interpolation::Linear,
    )));
    let mut still = desc.clone();
    still.animate(2.0, None, &mut NoFiles).unwrap();
    assert!(!still.lights[0].moves() && still.camera.as_ref().unwrap().value.motion().is_none());
    assert_eq!(still.objects[0].motion, None);
    assert_eq!(still.objects[0].transform.0.translation.x, 4.0);
    desc.animate(2.0, Some(0.5), &mut NoFiles).unwrap();
    let by = |own: Option<Transform>| own.map(|own| own.0.translation.x);
    assert_eq!(by(desc.objects[0].motion), Some(5.0));
    assert_eq!(desc.objects[1].motion, None);
    assert_eq!(desc.objects[2].motion.map(|m| m.0.matrix3), Some(DMat3::from_diagonal(DVec3::splat(2.0))));
    assert_eq!(by(desc.lights[0].motion), Some(0.5));
    let camera = by(desc.camera.as_ref().unwrap().value.motion()).unwrap();
    assert!((camera - 0.5).abs() < 1e-12, "{camera}");
    assert!(desc.moves());
}

/// Reads a scene from its value.
fn read(top: &Value) -> Result<SceneDesc, SceneError> {
    read_scene(top, &mut NoFiles)
}

#[test]
fn animations_are_written_and_read() {
    let mut desc = SceneDesc::default();
    desc.objects
        .push(ObjectDesc { name: Some("ball".to_owned()), ..ObjectDesc::new(sphere(DVec3::ZERO, 1.0)) });
    let keys = [(0.0, number(1.0)), (1.5, number(2.0))];
    desc.animations.push(named(animation("object.ball.radius", &keys, Interpolation::Smooth)));
    desc.animations.push(Named {
        name: Some("sway".to_owned()),
        ..named(AnimationDesc { repeat: true, ..animation("camera.fov", &keys, Interpolation::Step) })
    });
    let written = write_scene(&desc, &mut BorrowedAssets::of(&desc)).unwrap();
    let again = read(&written).unwrap();
    desc.same_scene(&again).unwrap();
    // Edits reach single keys.
    desc.edit(&[KeyEdit::new("animation.0.interpolation", Data::String("step".into()))], &mut NoFiles)
        .unwrap();
    assert_eq!(desc.animations[0].value.interpolation, Interpolation::Step);
    assert_eq!(desc.animations[1].name.as_deref(), Some("sway"));
    let shown = desc.value_at("animation.1.repeat").unwrap().unwrap();
    assert_eq!(shown.data, Data::Bool(true));
}

#[test]
fn faults_are_named() {
    let scene = |own: AnimationDesc| {
        let mut desc = SceneDesc::default();
        for name in ["ball", "box"] {
            desc.objects.push(ObjectDesc {
                name: Some(name.to_owned()),
                ..ObjectDesc::new(sphere(DVec3::ZERO, 1.0))
            });
        }
        let mut own = named(own);
        own.value.check()?;
        own.span = None;
        desc.animations.push(own);
        let before = desc.clone();
        let result = desc.animate(0.5, None, &mut NoFiles);
        assert!(result.is_ok() || desc == before);
        result
    };
    let two = |a: Value, b: Value| [(0.0, a), (1.0, b)];
    let kinds = Interpolation::Linear;
    let cases = [
        (animation("object.bal.radius", &two(number(1.0), number(2.0)), kinds), "bal"),
        (animation("object.2.radius", &two(number(1.0), number(2.0)), kinds), "2"),
        (animation("radius", &two(number(1.0), number(2.0)), kinds), "not the path of a key"),
        (animation("object.ball", &two(number(1.0), number(2.0)), kinds), "not the path of a key"),
        (animation("include.x", &two(number(1.0), number(2.0)), kinds), "not the path of a key"),
        (animation("object.ball.radiusx", &two(number(1.0), number(2.0)), kinds), "radiusx"),
        (animation("object.ball.radius", &two(number(-3.0), number(-2.0)), kinds), "radius"),
        (animation("object.ball.radius", &[], kinds), "one value for each time"),
        (animation("object.ball.radius", &[(1.0, number(1.0)), (1.0, number(2.0))], kinds), "must increase"),
        (animation("object.ball.center", &two(number(1.0), vector([1.0; 3])), kinds), "nothing between"),
        (
            animation(
                "film.filter",
                &two(Value::new(Data::String("box".into())), Value::new(Data::String("tent".into()))),
                kinds,
            ),
            "nothing between",
        ),
    ];
    for (own, part) in cases {
        let target = own.target.clone();
        let error = scene(own).err().unwrap_or_else(|| panic!("{target}"));
        let text = format!("{} {}", error.message, error.help.unwrap_or_default());
        assert!(text.contains(part), "{target}: {text}");
    }
    // Words change with steps.
    let words = two(Value::new(Data::String("box".into())), Value::new(Data::String("tent".into())));
    assert!(scene(animation("film.filter", &words, Interpolation::Step)).is_ok());
}

#[test]
fn animations_follow_their_targets() {
    let mut desc = SceneDesc::default();
    for name in ["ball", "box", "cone"] {
        desc.objects
            .push(ObjectDesc { name: Some(name.to_owned()), ..ObjectDesc::new(sphere(DVec3::ZERO, 1.0)) });
    }
    let keys = [(0.0, number(1.0)), (1.0, number(2.0))];
    for target in ["object.ball.radius", "object.2.radius", "object.box.radius", "film.exposure"] {
        desc.animations.push(named(animation(target, &keys, Interpolation::Linear)));
    }
    let targets = |desc: &SceneDesc| -> Vec<String> {
        desc.animations.iter().map(|own| own.value.target.clone()).collect()
    };
    desc.rename("object.0", "a.b").unwrap();
    assert_eq!(targets(&desc)[0], "object.\"a.b\".radius");
    desc.remove(&["object.1"]).unwrap();
    assert_eq!(targets(&desc), ["object.\"a.b\".radius", "object.1.radius", "film.exposure"]);
    let mut grouped = desc.clone();
    grouped.group_objects(&["object.0", "object.1"], "pair").unwrap();
    assert_eq!(targets(&grouped)[..2], ["group.pair.object.\"a.b\".radius", "group.pair.object.1.radius"]);
    grouped.animate(0.5, None, &mut NoFiles).unwrap();
    let error = grouped.ungroup("object.0").unwrap_err();
    assert!(error.message.contains("animated"), "{}", error.message);
    desc.remove(&["object.0", "object.1"]).unwrap();
    assert_eq!(targets(&desc), ["film.exposure"]);
}
