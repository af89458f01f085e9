//! `turner new`: a scene to start from.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use turner::schema::error::escape;
use turner::schema::{ErrorCode, SceneError};
use turner_io::image::OutputFile;

use crate::failure::{Failure, two_lines};
use crate::{report, text};

/// Write a commented scene file to start from
#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// Name of the new file; `.toml` is appended
    name: PathBuf,
    /// Which scene to start from
    #[arg(long, value_name = "NAME", default_value = "physical")]
    template: Template,
}

/// Scenes to start from.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Template {
    /// Glass, metal and paint in a studio, rendered by path tracing
    Physical,
    /// Mirrors and glass, rendered by Whitted's recursive ray tracing (1980)
    Classic,
}

impl Template {
    fn text(self) -> &'static str {
        match self {
            Template::Physical => include_str!("../templates/physical.toml"),
            Template::Classic => include_str!("../templates/classic.toml"),
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &NewArgs) -> u8 {
    match write(args) {
        Ok(path) => {
            let name = path.display();
            text::print(&format!(
                "{name} created\n\n  turner {name}          renders it\n  turner watch {name}    renders it again after each change\n"
            ));
            0
        }
        Err(failure) => {
            report::print_error(&failure);
            failure.exit
        }
    }
}

fn write(args: &NewArgs) -> Result<PathBuf, Failure> {
    let refuse = |message: String, help: &str| {
        Err(Failure::new(SceneError::new(ErrorCode::Output, message).help(help)))
    };
    let shown = args.name.to_string_lossy();
    if args.name.file_name().is_none() || shown.ends_with(std::path::is_separator) || shown.ends_with("/.") {
        return refuse(
            format!("\"{}\": is not a file name", escape(&shown)),
            "give a name, e.g. `turner new scene`",
        );
    }
    // The name appears in the first lines of the scene and in commands to copy.
    if shown.chars().any(char::is_control) {
        return refuse(
            format!("\"{}\": contains a control character", escape(&shown)),
            "choose another name",
        );
    }
    let path = with_extension(&args.name);
    if path.symlink_metadata().is_ok() {
        return refuse(
            format!("{}: the file already exists", path.display()),
            "choose another name, or remove the file",
        );
    }
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let scene = args.template.text().replace("NAME.toml", &name);
    OutputFile::create(&path)
        .and_then(|file| file.commit(scene.as_bytes()))
        .map_err(|e| Failure::new(two_lines(ErrorCode::Output, &e.to_string())))?;
    Ok(path)
}

fn with_extension(name: &Path) -> PathBuf {
    if name.extension().is_some_and(|e| e == "toml") {
        return name.to_owned();
    }
    let mut name = name.as_os_str().to_owned();
    name.push(".toml");
    name.into()
}
