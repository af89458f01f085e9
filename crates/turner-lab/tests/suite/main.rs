//! Tests of the program `turner-lab`.

mod commands;
#[path = "../../../turner-cli/tests/suite/folder.rs"]
mod folder;
mod povray;
mod rays;
mod render;
mod scenes;
#[path = "../../../turner-cli/tests/suite/sh_blocks.rs"]
mod sh_blocks;
mod verify;

use folder::{Folder, Run};

impl Folder {
    fn lab(&self, args: &[&str]) -> Run {
        Run::of(self.program(env!("CARGO_BIN_EXE_turner-lab"), args).output().unwrap())
    }

    /// Writes a shell script into the folder and returns its path.
    #[cfg(unix)]
    fn script(&self, name: &str, body: &str) -> String {
        use std::os::unix::fs::PermissionsExt;
        let path = self.write(name, &format!("#!/bin/sh\n{body}\n"));
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path.display().to_string()
    }
}
