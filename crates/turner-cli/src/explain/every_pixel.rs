//! `turner explain --page`: a page in which every pixel can be explained.

use std::path::{Path, PathBuf};

use turner::schema::{ErrorCode, SceneError};
use turner::{PassOptions, Renderer};
use turner_io::convert::{ConvertOptions, to_toml};
use turner_io::image::{ImageFormat, OutputFile, Transfer};
use turner_io::{SaveOptions, to_bytes};
use turner_web::{ExplainPage, explain_page};

use super::ExplainArgs;
use crate::control::Control;
use crate::failure::Failure;
use crate::report::Reporter;

/// The module: the named file, or that beside the program.
fn module(named: Option<&Path>) -> Result<Vec<u8>, Failure> {
    let beside = std::env::current_exe().ok().and_then(|program| Some(program.parent()?.join("turner.wasm")));
    let file = named.map(PathBuf::from).or_else(|| beside.filter(|path| path.is_file()));
    let failed =
        |message: String, help: &str| Failure::new(SceneError::new(ErrorCode::File, message).help(help));
    let help =
        "name the file `turner.wasm` by `--module`; `cargo xtask web` builds it as target/web/turner.wasm";
    let Some(path) = file else {
        return Err(failed("the page needs Turner's WebAssembly module".to_owned(), help));
    };
    let bytes = std::fs::read(&path).map_err(|e| failed(format!("{}: {e}", path.display()), help))?;
    if !bytes.starts_with(b"\0asm") {
        return Err(failed(format!("{}: is no WebAssembly module", path.display()), help));
    }
    Ok(bytes)
}

/// Writes the page.
pub(super) fn run(args: &ExplainArgs, reporter: &Reporter, control: &Control) -> Result<u8, Failure> {
    let Some(path) = args.output.as_deref().filter(|path| path.as_os_str() != "-") else {
        let error = SceneError::new(ErrorCode::Output, "`--page` needs a file to write");
        return Err(Failure::usage(error.help("add `-o page.html`")));
    };
    let output = |e: turner_io::image::OutputError| {
        Failure::new(crate::failure::two_lines(ErrorCode::Output, &e.to_string()))
    };
    let file = OutputFile::create(path).map_err(output)?;
    let module = module(args.module.as_deref())?;
    let ready = args.scene.ready(&args.film, args.scene.studio.models(), 0, control)?;
    let bad = |e| Failure::in_scene(e, &ready.sources, &ready.labels);
    let mut renderer = Renderer::new(ready.prepared.clone()).map_err(bad)?;
    let options = PassOptions { threads: 0, cancel: &control.pause, progress: None };
    control.begin_rendering();
    while !renderer.is_complete() {
        let done = renderer.pass(u32::MAX, &options).map_err(bad)?;
        if control.is_interrupted() {
            return Ok(control.exit_code());
        }
        if !done {
            let error = SceneError::new(ErrorCode::Internal, "the picture was not finished");
            return Err(Failure::new(error.help("run the command again")));
        }
    }
    let picture = renderer.develop();
    let options = SaveOptions { transfer: Transfer::Srgb, ..SaveOptions::default() };
    let png = to_bytes(&picture, ImageFormat::Png, &options)
        .map_err(|e| Failure::new(SceneError::new(ErrorCode::Output, e.to_string())))?;
    // The scene with everything that it reads, in one folder.
    let folder = tempfile::tempdir().map_err(|e| {
        let message = format!("the scene cannot be written for the page: {e}");
        Failure::new(
            SceneError::new(ErrorCode::Output, message)
                .help("free some space in the folder for temporary files"),
        )
    })?;
    let main = folder.path().join("scene.toml");
    let name = args.scene.scene.to_string_lossy().into_owned();
    let converted = ConvertOptions { source: name.clone(), overwrite: true, ..ConvertOptions::default() };
    let converted = to_toml(&ready.desc, &main, &converted).map_err(bad)?;
    let mut files = Vec::new();
    for written in &converted.files {
        let own = written.path.strip_prefix(folder.path()).unwrap_or(&written.path);
        let bytes = std::fs::read(&written.path).map_err(|e| {
            Failure::new(SceneError::new(ErrorCode::File, format!("{}: {e}", written.path.display())))
        })?;
        files.push((own.to_string_lossy().replace('\\', "/"), bytes));
    }
    let title = Path::new(&name).file_name().map_or(name.clone(), |file| file.to_string_lossy().into_owned());
    let page = explain_page(&ExplainPage {
        title: &title,
        module: &module,
        files: &files,
        main: "scene.toml",
        size: [picture.width, picture.height],
        png: &png,
        pixel: args.pixel,
    });
    file.commit(page.as_bytes()).map_err(output)?;
    reporter.warnings(&ready.prepared.warnings, &ready.sources, &ready.labels);
    Ok(0)
}
