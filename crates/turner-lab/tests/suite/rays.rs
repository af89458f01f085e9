//! `turner-lab rays`: a row for each kind of rays.

use crate::folder::Folder;

#[test]
fn generated_scenes_are_measured() {
    let f = Folder::new();
    let small =
        ["rays", "--scene", "cornell,sticks", "--scale", "0.01", "--resolution", "32", "--repeat", "1"];
    let json = f.lab(&[&small[..], &["--json"]].concat()).ok().stdout;
    let rows: Vec<serde_json::Value> = json.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let count = |kind: &str| rows.iter().filter(|r| r["row"] == kind).count();
    assert_eq!((count("build"), count("rays"), count("mean")), (2, 12, 6));
    assert!(
        rows.iter()
            .all(|r| r["row"] != "rays" || r["mrays_per_second"]["turner-balanced"].as_f64() > Some(0.0))
    );
    let text = f.lab(&[&small[..], &["--kind", "primary"]].concat()).ok().stdout;
    assert!(text.contains("sticks, 1 thread: building") && text.contains("mean"), "{text}");
    f.lab(&["rays", "--scene", "bunny"]).fails(2, &["cornell"]);
    f.lab(&["rays", "--embree", "no-such-library.so"]).fails(2, &["no-such-library.so", "--embree"]);
    assert!(f.lab(&["rays", "--help"]).ok().stdout.contains("--resolution"));
    assert!(f.lab(&["--help"]).ok().stdout.contains("rays"));
}
