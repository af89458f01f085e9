use super::*;
use crate::gltf::json;
use turner::math::DVec3;

fn document(members: &str) -> Document {
    json::parse(format!("{{\"asset\":{{\"version\":\"2.0\"}},{members}}}").as_bytes()).unwrap()
}

fn refusal(nodes: &str) -> String {
    Tree::new(&document(&format!("\"nodes\":[{nodes}]"))).unwrap_err().in_file("a.glb").message
}

#[test]
fn only_trees_are_taken() {
    assert!(refusal(r#"{"children":[0]}"#).contains("/nodes/0/children/0: node 0 is its own child"));
    assert!(
        refusal(r#"{"children":[2]},{"children":[2]},{}"#).contains("node 2 has two parents, nodes 0 and 1")
    );
    assert!(refusal(r#"{"children":[1,1]},{}"#).contains("node 1 has two parents"));
    assert!(refusal(r#"{"children":[7]}"#).contains("refers to node 7, but there are 1"));
    let ring = r#"{},{"children":[2]},{"children":[3]},{"children":[1]}"#;
    assert!(refusal(ring).contains("/nodes/1: node 1 is its own ancestor"), "{}", refusal(ring));
    // Each level refers to the next one twice: 2^40 nodes if that were allowed.
    let levels: Vec<String> = (0..40).map(|i| format!(r#"{{"children":[{0},{0}]}}"#, i + 1)).collect();
    assert!(refusal(&format!("{},{{}}", levels.join(","))).contains("two parents"));
}

#[test]
fn a_chain_of_100_000_nodes_is_walked() {
    let count = 100_000;
    let nodes: Vec<String> = (0..count)
        .map(|i| match i + 1 {
            next if next < count => format!(r#"{{"children":[{next}],"translation":[1,0,0]}}"#),
            _ => r#"{"translation":[1,0,0]}"#.to_owned(),
        })
        .collect();
    let document = document(&format!("\"nodes\":[{}]", nodes.join(",")));
    let tree = Tree::new(&document).unwrap();
    let locals: Vec<Local> = document.nodes.iter().map(Local::of).collect();
    let world = tree.world(locals);
    assert_eq!(world.last().unwrap().translation, DVec3::new(count as f64, 0.0, 0.0));
    let shown = tree.shown(&document, None, &[], &mut Report::default()).unwrap();
    assert_eq!(shown.len(), count);
}

#[test]
fn children_move_with_their_parents() {
    // A rotation by 90 degrees about y maps x to −z.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let members = format!(
        r#""nodes":[{{"translation":[1,2,3],"rotation":[0,{h},0,{h}],"scale":[2,2,2],"children":[1]}},
                    {{"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 5,0,0,1]}}]"#
    );
    let document = document(&members);
    let locals: Vec<Local> = document.nodes.iter().map(Local::of).collect();
    let world = Tree::new(&document).unwrap().world(locals);
    let p = world[1].transform_point3(DVec3::ZERO);
    assert!((p - DVec3::new(1.0, 2.0, -7.0)).length() < 1e-12, "{p}");
}

#[test]
fn quaternions_of_any_length_turn_and_stay_finite() {
    let turned = |q: [f64; 4]| from_parts(DVec3::ZERO, q, DVec3::ONE).transform_vector3(DVec3::X);
    for scale in [1.0, 1e-200, 1e200] {
        let q = [0.0, 0.0, scale, scale];
        assert!((turned(q) - DVec3::Y).length() < 1e-12, "{scale}");
    }
    assert_eq!(turned([0.0; 4]), DVec3::X);
}

#[test]
fn scenes_and_nodes_are_chosen_by_name() {
    let members = r#""scene":1,"scenes":[{"name":"a","nodes":[0]},{"name":"b","nodes":[2,2]}],
        "nodes":[{"name":"x","children":[1]},{"name":"y"},{"name":"z","children":[3]},{"name":"w"}]"#;
    let document = document(members);
    let tree = Tree::new(&document).unwrap();
    let shown = |scene: Option<&str>, nodes: &[&str]| {
        let nodes: Vec<String> = nodes.iter().map(|n| (*n).to_owned()).collect();
        tree.shown(&document, scene, &nodes, &mut Report::default()).map_err(|f| f.in_file("m"))
    };
    assert_eq!(shown(None, &[]).unwrap(), [2, 3]);
    assert_eq!(shown(Some("a"), &[]).unwrap(), [0, 1]);
    assert_eq!(shown(Some("0"), &["y"]).unwrap(), [1]);
    assert_eq!(shown(None, &["w", "z"]).unwrap(), [2, 3]);
    let error = shown(None, &["zz"]).unwrap_err();
    assert!(error.message.contains("no node \"zz\"") && error.help.unwrap().contains("did you mean \"z\""));
    assert!(shown(Some("c"), &[]).unwrap_err().message.contains("no scene \"c\""));
}
