use super::*;
use crate::gltf::testing::{floats, open};

/// Samples one property of node 0 with keys at `times`.
fn sampled(path: &str, kind: &str, interpolation: &str, times: &[f32], values: &[f32], at: f64) -> Pose {
    let width = if kind == "VEC4" { 4 } else { 3 };
    let (n, m) = (4 * times.len(), 4 * values.len());
    let members = format!(
        r#""nodes":[{{}}],"buffers":[{{"byteLength":{}}}],
        "bufferViews":[{{"buffer":0,"byteLength":{n}}},{{"buffer":0,"byteOffset":{n},"byteLength":{m}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"SCALAR"}},
                     {{"bufferView":1,"componentType":5126,"count":{},"type":"{kind}"}}],
        "animations":[{{"name":"go","channels":[{{"sampler":0,"target":{{"node":0,"path":"{path}"}}}}],
                       "samplers":[{{"input":0,"output":1,"interpolation":"{interpolation}"}}]}}]"#,
        n + m,
        times.len(),
        values.len() / width
    );
    let opened = open(&members, &floats(&[times, values].concat())).unwrap();
    let mut pose = Pose::rest(&opened.document);
    pose.apply(
        &opened.document,
        (&opened.buffers, &Budget::of_file(0)),
        Index(0),
        at,
        &mut Report::default(),
    )
    .unwrap();
    pose
}

fn translation(interpolation: &str, values: &[f32], at: f64) -> [f64; 3] {
    let pose = sampled("translation", "VEC3", interpolation, &[1.0, 2.0, 4.0], values, at);
    match pose.locals[0] {
        Local::Parts { translation, .. } => translation.to_array(),
        Local::Matrix(_) => panic!("a matrix"),
    }
}

#[test]
fn steps_and_lines_are_clamped_outside() {
    let values = [0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 20.0, 40.0, 0.0];
    for (at, x) in [(-5.0, 0.0), (1.0, 0.0), (1.25, 2.5), (2.0, 10.0), (3.0, 15.0), (4.0, 20.0), (99.0, 20.0)]
    {
        assert_eq!(translation("LINEAR", &values, at)[0], x, "{at}");
    }
    for (at, x) in [(0.0, 0.0), (1.9, 0.0), (2.0, 10.0), (3.9, 10.0), (4.0, 20.0), (9.0, 20.0)] {
        assert_eq!(translation("STEP", &values, at)[0], x, "{at}");
    }
}

#[test]
fn cubic_splines_take_their_tangents_by_second() {
    // In-tangent, value and out-tangent of x = t², whose slope is 2t, at the keys 1, 2 and 4.
    let values: Vec<f32> = [1.0f32, 2.0, 4.0]
        .iter()
        .flat_map(|t| [[2.0 * t, 0.0, 0.0], [t * t, 0.0, 0.0], [2.0 * t, 0.0, 0.0]].concat())
        .collect();
    for at in [1.0, 1.3, 2.0, 2.5, 3.7, 4.0] {
        let x = translation("CUBICSPLINE", &values, at)[0];
        assert!((x - at * at).abs() < 1e-6, "{at}: {x}");
    }
    assert_eq!(translation("CUBICSPLINE", &values, 0.0)[0], 1.0);
    assert_eq!(translation("CUBICSPLINE", &values, 7.0)[0], 16.0);
}

#[test]
fn rotations_go_the_short_way_at_even_speed() {
    let h = std::f32::consts::FRAC_1_SQRT_2;
    // From the identity to a rotation by 90 degrees about z, also written as the opposite quaternion.
    for sign in [1.0, -1.0] {
        let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, sign * h, sign * h];
        let pose = sampled("rotation", "VEC4", "LINEAR", &[0.0, 3.0], &values, 1.0);
        let x = pose.locals[0].matrix().transform_vector3(DVec3::X);
        // At one third of the time: 30 degrees.
        assert!((x - DVec3::new(0.75f64.sqrt(), 0.5, 0.0)).length() < 1e-6, "{x}");
    }
}

#[test]
fn counts_that_do_not_fit_are_refused() {
    let members = r#""nodes":[{}],"buffers":[{"byteLength":24}],"bufferViews":[{"buffer":0,"byteLength":24}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR"},
                     {"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"}],
        "animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"scale"}}],
                       "samplers":[{"input":0,"output":1}]}]"#;
    let opened = open(members, &[0; 24]).unwrap();
    let mut pose = Pose::rest(&opened.document);
    let fault = pose
        .apply(
            &opened.document,
            (&opened.buffers, &Budget::of_file(0)),
            Index(0),
            0.0,
            &mut Report::default(),
        )
        .unwrap_err();
    let message = fault.in_file("a.glb").message;
    assert!(message.contains("/accessors/1: has 2 elements; expected 3"), "{message}");
    let missing = chosen(&opened.document, Some("walk"), &mut Report::default());
    assert!(missing.unwrap_err().in_file("a").message.contains("no animation \"walk\""));
}

#[test]
fn none_is_no_animation_unless_one_has_that_name() {
    let of = |names: &[&str], wanted: Option<&str>| {
        let list: Vec<String> = names.iter().map(|n| format!(r#"{{"name":"{n}"}}"#)).collect();
        let opened = open(&format!(r#""animations":[{}]"#, list.join(",")), &[]).unwrap();
        chosen(&opened.document, wanted, &mut Report::default()).unwrap()
    };
    assert_eq!(of(&["walk", "run"], None), Some(Index(0)));
    assert_eq!(of(&["walk", "run"], Some("run")), Some(Index(1)));
    assert_eq!(of(&["walk"], Some("none")), None);
    assert_eq!(of(&["walk", "none"], Some("none")), Some(Index(1)));
    assert_eq!((of(&[], None), of(&[], Some("none"))), (None, None));
}
