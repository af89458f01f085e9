//! `turner studio`: starts the window program `turner-studio`, which is another executable so that this one needs no
//! window system.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use turner::schema::{ErrorCode, SceneError};

use crate::failure::Failure;
use crate::report;

/// Open Turner Studio: a window to see a scene, change it and render it
#[derive(Debug, Args)]
pub(crate) struct WindowArgs {
    /// A scene or a model to open
    scene: Option<PathBuf>,
}

/// Runs `turner studio`.
pub(crate) fn run(args: &WindowArgs) -> u8 {
    let words: Vec<OsString> = args.scene.iter().map(|scene| argument(scene)).collect();
    start(&words)
}

/// A path that is no option, whatever it begins with.
pub(crate) fn argument(path: &Path) -> OsString {
    match path.as_os_str().as_encoded_bytes().first() {
        Some(b'-') => Path::new(".").join(path).into_os_string(),
        _ => path.as_os_str().to_owned(),
    }
}

/// Starts `turner-studio` with these arguments, in place of this process where the system can do that. Returns the exit
/// code.
pub(crate) fn start(args: &[OsString]) -> u8 {
    let beside = std::env::current_exe().ok();
    let beside = beside.as_deref().and_then(Path::parent);
    let failure = match find(beside, std::env::var_os("PATH").as_deref()) {
        Some(program) => match replace(Command::new(&program).args(args)) {
            Ok(code) => return code,
            Err(error) => Failure::new(SceneError::new(
                ErrorCode::File,
                format!("{}: cannot be started: {error}", program.display()),
            )),
        },
        None => {
            let message = "the program turner-studio is neither beside this one nor on the PATH";
            let help = "in Turner's sources, `cargo run --release -p turner-studio` builds and starts it";
            Failure::new(SceneError::new(ErrorCode::File, message).help(help))
        }
    };
    report::print_error(&failure);
    failure.exit
}

/// The program in the folder, or else on the search path.
fn find(folder: Option<&Path>, search: Option<&OsStr>) -> Option<PathBuf> {
    let name = format!("turner-studio{}", std::env::consts::EXE_SUFFIX);
    let folders = folder.map(Path::to_owned).into_iter();
    let search = search.map(std::env::split_paths).into_iter().flatten();
    folders.chain(search).map(|folder| folder.join(&name)).find(|path| is_program(path))
}

#[cfg(unix)]
fn is_program(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    path.metadata().is_ok_and(|file| file.is_file() && file.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_program(path: &Path) -> bool {
    path.is_file()
}

/// Becomes the program: signals, the terminal and the exit code are then its own.
#[cfg(unix)]
fn replace(command: &mut Command) -> std::io::Result<u8> {
    use std::os::unix::process::CommandExt;
    Err(command.exec())
}

/// Runs the program and passes its exit code on.
#[cfg(not(unix))]
fn replace(command: &mut Command) -> std::io::Result<u8> {
    let code = command.status()?.code().unwrap_or(i32::from(crate::failure::FAILED));
    Ok(u8::try_from(code).unwrap_or(crate::failure::FAILED))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_never_an_option() {
        assert_eq!(argument(Path::new("-x.toml")), Path::new(".").join("-x.toml").into_os_string());
        assert_eq!(argument(Path::new("a/-x.toml")), OsString::from("a/-x.toml"));
    }
}
