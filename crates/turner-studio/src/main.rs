//! The program `turner-studio`. The library documents it.

use std::path::PathBuf;
use std::process::ExitCode;

use turner_studio::app::App;
use turner_studio::{bench, settings};

const HELP: &str = "\
Turner Studio: see a scene, change it, understand it, at interactive rates

Usage: turner-studio [SCENE]
       turner-studio bench [OPTIONS] [SCENE…]

Arguments:
  [SCENE]  A scene or a model to open: .toml, .glb, .gltf, .usdz, .usd, .obj, .ply, .stl, .pbrt, Mitsuba's .xml

Options:
  -h, --help     Print help
  -V, --version  Print the version
";

const NO_WINDOW: &str = "  help: start it in a desktop session; `turner` renders without a display";

fn main() -> ExitCode {
    // The command line of Turner is in this program, so that the window renders files with processes of its own.
    if std::env::args_os().nth(1).is_some_and(|word| word == "turner") {
        return turner_cli::start_from(std::env::args_os().skip(1).collect());
    }
    if std::env::args_os().nth(1).is_some_and(|word| word == "bench") {
        return measure();
    }
    let args: Vec<String> = std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
    match args.first().map(String::as_str) {
        Some("-h" | "--help") => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        Some("-V" | "--version") => {
            println!("turner-studio {}", env!("CARGO_PKG_VERSION"));
            return ExitCode::SUCCESS;
        }
        Some(option) if option.starts_with('-') && option.len() > 1 => {
            eprintln!("error: unknown option {option}\n  help: turner-studio --help lists them");
            return ExitCode::from(2);
        }
        _ => {}
    }
    if args.len() > 1 {
        eprintln!("error: expected one scene, found {} arguments\n  help: turner-studio --help", args.len());
        return ExitCode::from(2);
    }
    let has = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if cfg!(all(unix, not(target_os = "macos")))
        && !has("DISPLAY")
        && !has("WAYLAND_DISPLAY")
        && !has("WAYLAND_SOCKET")
    {
        eprintln!("error: there is no display (DISPLAY and WAYLAND_DISPLAY are not set)");
        eprintln!("{NO_WINDOW}");
        return ExitCode::FAILURE;
    }
    let scene = std::env::args_os().nth(1).map(PathBuf::from);
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Turner Studio")
            .with_app_id("turner-studio")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([320.0, 240.0]),
        ..Default::default()
    };
    let start = Box::new(move |cc: &eframe::CreationContext<'_>| {
        let mut app = App::new(&cc.egui_ctx, settings::home());
        if let Some(scene) = scene {
            app.studio.open(&scene);
        }
        Ok(Box::new(app) as Box<dyn eframe::App>)
    });
    match eframe::run_native("turner-studio", options, start) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: no window can be opened: {error}");
            eprintln!("{NO_WINDOW}");
            ExitCode::FAILURE
        }
    }
}

/// Runs `turner-studio bench`.
fn measure() -> ExitCode {
    let args = || std::env::args_os().skip(2);
    if args().any(|arg| arg == "-h" || arg == "--help") {
        print!("{}", bench::HELP);
        return ExitCode::SUCCESS;
    }
    let options = match bench::Options::parse(args()) {
        Ok(options) => options,
        Err(error) => {
            eprintln!("error: {error}\n  help: turner-studio bench --help lists the options");
            return ExitCode::from(2);
        }
    };
    match bench::run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
