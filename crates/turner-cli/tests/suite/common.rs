//! Shared by the tests of the program: a folder with a scene, a run.

use std::process::Command;

pub(crate) use crate::folder::{Folder, Run};

pub(crate) const SCENE: &str = r#"
[camera]
position = [0, 1.5, 6]
look_at = [0, 1, 0]

[film]
width = 24
height = 16

[background]
color = [0.2, 0.3, 0.5]

[[object]]
type = "sphere"
center = [0, 1, 0]
material = { color = "tomato", k_reflect = 0.3 }

[[object]]
type = "sphere"
center = [0, -1000, 0]
radius = 1000
material = { color = "grey" }

[[light]]
type = "point"
position = [5, 8, 5]
"#;

/// A folder with the scene.
pub(crate) fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    folder
}

impl Folder {
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub(crate) fn command(&self, args: &[&str]) -> Command {
        self.program(env!("CARGO_BIN_EXE_turner"), args)
    }

    pub(crate) fn turner(&self, args: &[&str]) -> Run {
        Run::of(self.command(args).output().unwrap())
    }
}

/// Size and colours of a picture.
pub(crate) fn pixels(bytes: &[u8]) -> (u32, u32, Vec<[f32; 3]>) {
    let image =
        turner_io::image::decode(bytes, "picture", &turner_io::image::DecodeLimits::default()).unwrap();
    let positions = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    (image.width, image.height, positions.map(|(x, y)| image.rgb(x, y)).collect())
}
