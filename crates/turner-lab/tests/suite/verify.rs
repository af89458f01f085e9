//! `turner-lab verify`: the checks that `turner verify` does not have.

use crate::folder::Folder;

/// A fixed seed makes the statistical test deterministic.
#[test]
fn a_peer_and_a_material_pass() {
    let args = ["verify", "--seed", "1", "--threads", "2", "--only", "peers/s1", "--only", "velvet"];
    let run = Folder::new().lab(&args).ok();
    assert!(run.stdout.contains("checks passed in") && !run.stdout.contains("FAILED"), "{}", run.stdout);
    for name in ["peers/s1", "density/velvet", "surface/velvet"] {
        assert!(run.stdout.contains(name), "{name}: {}", run.stdout);
    }
}

#[test]
fn the_complete_suite_includes_that_of_turner() {
    let list = Folder::new().lab(&["verify", "--list", "--references", "."]).ok().stdout;
    let names: Vec<&str> = list.lines().collect();
    assert!(names.len() > 100, "{list}");
    for name in ["closed/glass-slab", "surface/velvet", "peers/s4", "peers/s2-full"] {
        assert!(names.contains(&name), "{name}: {list}");
    }
    // The check of all samples runs last.
    assert_eq!(names.last(), Some(&"finite/all-samples"));
}

/// An image of the wrong size is rejected.
#[test]
fn a_wrong_reference_fails() {
    let f = Folder::new();
    let picture = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/peers/s1.exr");
    std::fs::copy(picture, f.path().join("S1.exr")).unwrap();
    let run = f.lab(&["verify", "--references", ".", "--only", "peers/s1-full"]);
    run.fails(1, &["peers/s1-full", "FAILED", "64x64 pixels, expected 512x512"]);
}
