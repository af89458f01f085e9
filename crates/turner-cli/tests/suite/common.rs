//! What the tests of the program share: a folder, a scene, a run.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

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

/// A folder with the scene in it.
pub(crate) struct Folder(tempfile::TempDir);

pub(crate) fn folder() -> Folder {
    let folder = Folder(tempfile::tempdir().unwrap());
    folder.write("s.toml", SCENE);
    folder
}

impl Folder {
    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub(crate) fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_turner"));
        command.current_dir(self.path()).args(args).env_remove("NO_COLOR").stdin(Stdio::null());
        command
    }

    pub(crate) fn turner(&self, args: &[&str]) -> Run {
        Run::of(self.command(args).output().unwrap())
    }
}

/// What a run gave.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) bytes: Vec<u8>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    pub(crate) fn of(output: Output) -> Run {
        Run {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
            bytes: output.stdout,
        }
    }

    #[track_caller]
    pub(crate) fn ok(self) -> Run {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }

    /// Failed with this exit code, and said all these words.
    #[track_caller]
    pub(crate) fn fails(self, code: i32, words: &[&str]) -> Run {
        assert_eq!(self.code, Some(code), "{self:?}");
        for word in words {
            assert!(self.stderr.contains(word) || self.stdout.contains(word), "{word}: {self:?}");
        }
        self
    }
}

/// Size and colours of a picture.
pub(crate) fn pixels(bytes: &[u8]) -> (u32, u32, Vec<[f32; 3]>) {
    let image =
        turner_io::image::decode(bytes, "picture", &turner_io::image::DecodeLimits::default()).unwrap();
    let places = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    (image.width, image.height, places.map(|(x, y)| image.rgb(x, y)).collect())
}
