//! `turner verify`: all checks pass, and errors are reported.

use crate::common::folder;

/// A fixed seed, so that the result is deterministic.
#[test]
fn the_suite_holds() {
    let run = folder().turner(&["verify", "--seed", "1", "--threads", "2"]).ok();
    assert!(run.stdout.contains("checks passed in") && !run.stdout.contains("FAILED"), "{}", run.stdout);
    for name in [
        "closed/glass-slab",
        "estimators/",
        "same/a-million-away",
        "bytes/instruction-sets",
        "density/lens",
        "finite/",
    ] {
        assert!(run.stdout.contains(name), "{name}: {}", run.stdout);
    }
}

#[test]
fn checks_are_chosen_by_name_and_a_seed_repeats_them() {
    let f = folder();
    let table = |seed: &str| {
        let run = f.turner(&["verify", "--seed", seed, "--only", "closed/glass-slab", "--json"]).ok();
        let found = run.stdout.lines().find(|l| l.contains("\"check\"")).unwrap_or_default().to_owned();
        found.split("\"name\"").next().unwrap_or_default().to_owned()
    };
    assert_eq!(table("5"), table("5"));
    assert_ne!(table("5"), table("6"));
    f.turner(&["verify", "--only", "closd/glass-slab"]).fails(2, &["there is no check", "closed/glass-slab"]);
    f.turner(&["verify", "--seed", "often"]).fails(2, &["fresh"]);
    let list = f.turner(&["verify", "--list"]).ok().stdout;
    assert!(list.lines().count() > 60 && !list.contains("surface/velvet"), "{list}");
}

/// Every scene of the repository, at a small size: no sample is infinite or NaN.
#[test]
fn all_samples_of_all_scenes_are_finite() {
    let f = folder();
    let root = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let mut folders = vec![root.to_owned()];
    let mut rendered = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            // An example generates its files.
            if path.extension().is_none_or(|e| e != "toml") || path.ends_with("peers/s4.toml") {
                continue;
            }
            let scene = path.to_string_lossy();
            let size = ["--width", "48", "--height", "32", "--samples", "4", "--json", "-o", "x.exr"];
            let run = f.turner(&[&[&*scene][..], &size].concat()).ok();
            assert!(run.stdout.contains("\"non_finite\":{\"count\":0"), "{scene}: {}", run.stdout);
            rendered += 1;
        }
    }
    assert!(rendered > 20, "{rendered}");
}
