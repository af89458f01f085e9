//! Paths stay in the scene's folder, reads stay within their limits, and messages help.

use std::fs;

use turner_io::assets::{AssetError, AssetSource, FolderAssets, MemoryAssets};

/// `outside.txt`, `scene/wood.png`, `scene/with space.png`, `scene/sub/tile.png`.
fn folder() -> tempfile::TempDir {
    let top = tempfile::tempdir().unwrap();
    fs::create_dir_all(top.path().join("scene/sub")).unwrap();
    for (name, text) in [
        ("outside.txt", "secret"),
        ("scene/wood.png", "wood"),
        ("scene/with space.png", "space"),
        ("scene/100%.png", "percent"),
        ("scene/sub/tile.png", "tile"),
    ] {
        fs::write(top.path().join(name), text).unwrap();
    }
    top
}

fn assets(top: &tempfile::TempDir) -> FolderAssets {
    FolderAssets::new(top.path().join("scene")).unwrap()
}

#[test]
fn reads_what_is_inside() {
    let top = folder();
    let assets = assets(&top);
    for (uri, text) in [
        ("wood.png", "wood"),
        ("./wood.png", "wood"),
        ("sub/../wood.png", "wood"),
        ("sub/tile.png", "tile"),
        (r"sub\tile.png", "tile"),
        ("with space.png", "space"),
        ("with%20space.png", "space"),
        ("sub%2Ftile.png", "tile"),
        ("100%.png", "percent"),
    ] {
        assert_eq!(assets.read(uri, 100).unwrap(), text.as_bytes(), "{uri}");
    }
}

#[test]
fn nothing_outside_is_read() {
    let top = folder();
    let assets = assets(&top);
    let absolute = top.path().join("outside.txt");
    let absolute = absolute.to_str().unwrap();
    for uri in [
        "../outside.txt",
        "sub/../../outside.txt",
        "%2e%2e/outside.txt",
        "%2E%2E%2Foutside.txt",
        "..%2foutside.txt",
        "sub/%2e%2e/%2e%2e/outside.txt",
        r"..\outside.txt",
        "..%5coutside.txt",
        absolute,
        &format!("file://{absolute}"),
        &format!("FILE:{absolute}"),
        &absolute.replace('/', "%2f"),
        r"\\server\share\x.png",
        "//server/share/x.png",
        r"C:\windows\win.ini",
        "c:/windows/win.ini",
        "https://example.com/x.png",
        "data:image/png;base64,AAAA",
        "%252e%252e/outside.txt",
        "%ff.png",
        "a\0b",
        "",
    ] {
        let error = assets.read(uri, 100).expect_err(uri);
        assert!(!error.to_string().contains("secret"), "{error}");
        assert!(error.to_string().lines().count() <= 3, "{error}");
    }
    assert!(matches!(assets.read("../outside.txt", 9), Err(AssetError::Outside { .. })));
    assert!(matches!(assets.read("%2e%2e/outside.txt", 9), Err(AssetError::Outside { .. })));
}

#[test]
fn outside_is_read_when_allowed() {
    let top = folder();
    let assets = assets(&top).allow_outside(true);
    let absolute = top.path().join("outside.txt");
    let absolute = absolute.to_str().unwrap();
    for uri in ["../outside.txt", "%2e%2e/outside.txt", absolute, &format!("file://{absolute}")] {
        assert_eq!(assets.read(uri, 100).unwrap(), b"secret", "{uri}");
    }
    assert_eq!(
        assets.read(&assets.resolve("sub/x.toml", "../../outside.txt").unwrap(), 100).unwrap(),
        b"secret"
    );
    assert!(assets.read("https://example.com/x.png", 100).is_err());
}

#[cfg(unix)]
#[test]
fn links_are_followed_inside_only() {
    use std::os::unix::fs::symlink;
    let top = folder();
    let scene = top.path().join("scene");
    symlink("wood.png", scene.join("inside.png")).unwrap();
    symlink("../outside.txt", scene.join("file.png")).unwrap();
    symlink("..", scene.join("up")).unwrap();
    symlink("loop", scene.join("loop")).unwrap();
    let assets = assets(&top);
    assert_eq!(assets.read("inside.png", 100).unwrap(), b"wood");
    for uri in ["file.png", "up/outside.txt"] {
        let message = assets.read(uri, 100).unwrap_err().to_string();
        assert!(message.contains("a link leaves the folder"), "{message}");
    }
    assert!(assets.read("loop", 100).is_err());
    // A name behind the link must not be revealed either.
    let message = assets.read("up/outside.tx", 100).unwrap_err().to_string();
    assert!(!message.contains("outside.txt"), "{message}");
    assert_eq!(assets.allow_outside(true).read("up/outside.txt", 100).unwrap(), b"secret");
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_folders_are_refused_at_once() {
    let top = folder();
    let pipe = top.path().join("scene/pipe.png");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let assets = assets(&top);
    assert!(matches!(assets.read("pipe.png", 100), Err(AssetError::NotAFile { .. })));
    let message = assets.read("sub", 100).unwrap_err().to_string();
    assert!(message.contains("is a folder"), "{message}");
    let outside = assets.allow_outside(true);
    assert!(matches!(outside.read("/dev/zero", 100), Err(AssetError::NotAFile { .. })));
}

#[test]
fn limits_and_budget_hold() {
    let top = folder();
    assert!(matches!(assets(&top).read("wood.png", 3), Err(AssetError::TooLarge { size: 4, limit: 3, .. })));
    let assets = assets(&top).with_budget(9);
    let shared = assets.clone();
    assert!(assets.read("wood.png", 100).is_ok());
    assert!(shared.read("sub/tile.png", 100).is_ok());
    assert!(matches!(assets.read("wood.png", 100), Err(AssetError::Budget { size: 4, budget: 9, .. })));
    // A sparse file larger than memory is rejected by its size.
    let sparse = fs::File::create(top.path().join("scene/sparse.png")).unwrap();
    sparse.set_len(1 << 40).unwrap();
    assert!(matches!(assets.read("sparse.png", u64::MAX), Err(AssetError::Budget { .. })));
}

#[test]
fn a_missing_file_names_its_neighbour() {
    let top = folder();
    let assets = assets(&top);
    for (uri, nearest) in [
        ("wod.png", "wood.png"),
        ("Wod.PNG", "wood.png"),
        ("wodo.png", "wood.png"),
        ("sub/tiles.png", "tile.png"),
    ] {
        let message = assets.read(uri, 100).unwrap_err().to_string();
        assert!(message.contains(&format!("nearest is \"{nearest}\"")), "{message}");
    }
    let message = assets.read("entirely-different.exr", 100).unwrap_err().to_string();
    assert!(message.contains("no such file") && !message.contains("nearest"), "{message}");
    // Upper-case letters do not make another name, except inside the scene's folder.
    assert_eq!(assets.read("Wood.PNG", u64::MAX).unwrap(), assets.read("wood.png", u64::MAX).unwrap());
    assert_eq!(
        assets.read("SUB/Tile.png", u64::MAX).unwrap(),
        assets.read("sub/tile.png", u64::MAX).unwrap()
    );
    assert!(assets.read("wood.png/inside.png", 100).is_err());
    assert!(assets.read(&"x".repeat(5000), 100).is_err());
}

#[test]
fn includes_resolve_against_their_own_file() {
    let assets = MemoryAssets { files: [("parts/b.png".to_owned(), vec![1, 2])].into() };
    for (from, uri, expected) in [
        ("scene.toml", "a.png", "a.png"),
        ("parts/a.toml", "b.png", "parts/b.png"),
        ("parts/deep/a.toml", "../b.png", "parts/b.png"),
        (r"parts\a.toml", r"deep\..\b.png", "parts/b.png"),
    ] {
        assert_eq!(assets.resolve(from, uri).unwrap(), expected);
    }
    for (from, uri) in [("parts/a.toml", "../../x"), ("scene.toml", "../x"), ("parts/a.toml", "/etc/passwd")]
    {
        assert!(matches!(assets.resolve(from, uri), Err(AssetError::Outside { .. })), "{from} {uri}");
    }
    assert_eq!(assets.read("parts/b.png", 2).unwrap(), [1, 2]);
    assert_eq!(assets.read("parts%2Fb.png", 2).unwrap(), [1, 2]);
    assert!(matches!(assets.read("parts/b.png", 1), Err(AssetError::TooLarge { .. })));
    let message = assets.read("parts/c.png", 2).unwrap_err().to_string();
    assert!(message.contains("nearest is \"parts/b.png\""), "{message}");
}

#[test]
fn a_missing_scene_folder_is_an_error() {
    assert!(FolderAssets::new("/no/such/folder").is_err());
    let top = folder();
    assert!(FolderAssets::new(top.path().join("outside.txt")).is_err());
}
