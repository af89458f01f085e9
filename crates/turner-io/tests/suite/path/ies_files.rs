//! IES profiles that scenes refer to.

use turner_io::assets::MemoryAssets;
use turner_io::scene::{LoadOptions, load_text};

use crate::classic::common::describe;

/// A light with a narrow beam downwards.
const PROFILE: &str = "IESNA:LM-63-2002\n[TEST] made by hand\n[MANUFAC] nobody\nTILT=NONE\n\
    1 -1 2 3 3 1 2 0 0 0\n1 1 10\n0 30 90\n0 90 180\n100 80 0\n100 50 0\n100 20 0\n";

#[test]
fn an_ies_profile_that_is_missing_or_broken_is_an_error_at_its_name() {
    let scene = "light = [{ type = \"point\", position = [0, 1, 0], ies = \"a.ies\" }]\n";
    let load = |assets: &MemoryAssets| load_text(scene.into(), "test.toml", assets, &LoadOptions::default());
    let error = load(&MemoryAssets::default()).unwrap_err();
    assert_eq!((error.code(), error.line()), ("E0201", Some(1)));
    let mut assets = MemoryAssets::default();
    assets.files.insert("a.ies".into(), PROFILE.replace("TILT=NONE", "TILT").into());
    let error = load(&assets).unwrap_err();
    assert_eq!((error.code(), error.line()), ("E0205", Some(1)));
    assert!(error.to_string().contains("a.ies: damaged IES file: line "), "{error}");
    // A tilt that is not applied gives a warning.
    assets.files.insert("a.ies".into(), PROFILE.replace("TILT=NONE", "TILT=tilt.tlt").into());
    let warnings = load(&assets).unwrap().desc.warnings;
    assert!(warnings.iter().any(|w| w.message.contains("TILT")), "{warnings:?}");
    assert!(describe("").lights.is_empty());
}
