//! `turner serve`: the page, traced by this program.

use std::io::IsTerminal;
use std::net::IpAddr;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::Args;
use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;
use turner::schema::{ErrorCode, SceneError};
use turner_serve::{Options, ServeError, Server};

use crate::control::Control;
use crate::failure::{Failure, Labels};
use crate::limits::LimitArgs;
use crate::{report, text};

/// Serve Turner's page for browsers: look around, edit and explain, rendered by this program; Ctrl-C stops
#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// A scene or a model to open
    scene: Option<PathBuf>,
    /// Also print an address for others in the network, who look on and change nothing
    #[arg(long)]
    share: bool,
    /// Address to listen at; 0.0.0.0 is every network [default: this machine alone]
    #[arg(long, value_name = "ADDRESS")]
    bind: Option<IpAddr>,
    /// Port; 0 is any [default: 7373, or any if it is taken]
    #[arg(long)]
    port: Option<u16>,
    /// A name of this machine that browsers may use (repeatable)
    #[arg(long, value_name = "NAME")]
    host: Vec<String>,
    /// Open the page in the browser of this machine
    #[arg(long)]
    open: bool,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Memory limit, e.g. 4G or 500M [default: four fifths of the machine's memory]
    #[arg(long, value_name = "SIZE", value_parser = crate::limits::parse_size)]
    max_memory: Option<u64>,
}

/// Runs the command.
pub(crate) fn run(args: &ServeArgs, control: &Control) -> u8 {
    match serve(args, control) {
        Ok(()) => 0,
        Err(failure) => {
            report::print_error(&failure);
            failure.exit
        }
    }
}

fn serve(args: &ServeArgs, control: &Control) -> Result<(), Failure> {
    let limits = LimitArgs::of_memory(args.max_memory).limits();
    control.watch_memory(&limits.memory);
    let options = Options {
        scene: args.scene.clone(),
        bind: args.bind,
        port: args.port,
        share: args.share,
        names: args.host.clone(),
        threads: args.threads,
        limits,
    };
    let server = Server::new(options).map_err(failure)?;
    let owner = server.owner();
    text::print(&format!("{owner}\n"));
    if let Some(viewers) = server.viewers() {
        text::print(&format!("{viewers}\n"));
        if std::io::stderr().is_terminal() {
            eprint!("{}", code(&viewers));
        }
    }
    eprintln!("{}", hint(args.share));
    if args.open {
        open(&owner);
    }
    // Ctrl-C ends the program: there is nothing to save.
    server.run().map_err(|error| system(&error))
}

/// An address as a code for the cameras of phones, for terminals with a dark background.
fn code(address: &str) -> String {
    let Ok(code) = QrCode::new(address) else { return String::new() };
    let mut renderer = code.render::<Dense1x2>();
    let text = renderer.dark_color(Dense1x2::Light).light_color(Dense1x2::Dark).build();
    format!("{text}\n")
}

fn hint(share: bool) -> &'static str {
    if share {
        "the first address is yours; give the second to those who look on; Ctrl-C stops"
    } else {
        "open the address in a browser; Ctrl-C stops"
    }
}

/// Starts the system's browser. Where there is none, the address is printed anyway.
fn open(address: &str) {
    let mut command = match std::env::consts::OS {
        "macos" => Command::new("open"),
        "windows" => {
            let mut command = Command::new("rundll32");
            command.arg("url.dll,FileProtocolHandler");
            command
        }
        _ => Command::new("xdg-open"),
    };
    let quiet = command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if let Err(error) = quiet.spawn() {
        eprintln!("no browser can be started: {error}");
    }
}

fn failure(error: ServeError) -> Failure {
    match error {
        ServeError::Scene(error) => Failure::load(error, &Labels::new()),
        ServeError::Address(at, error) => {
            let message = format!("cannot listen at {at}: {error}");
            let help = "name an address of this machine with --bind, or a free port with --port";
            Failure::new(SceneError::new(ErrorCode::File, message).help(help))
        }
        ServeError::System(error) => system(&error),
    }
}

fn system(error: &std::io::Error) -> Failure {
    Failure::new(SceneError::new(ErrorCode::File, format!("nothing can be served: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_has_a_square_for_each_module_and_a_quiet_zone() {
        let code = code("http://192.168.100.100:7373/abcdefghijkmnpqrstuvwxyz23/");
        let lines: Vec<&str> = code.lines().collect();
        // 55 bytes at error correction level M make a QR code of version 4 (ISO/IEC 18004): 33 modules a side, and a
        // quiet zone of 4 on each side.
        assert!(lines.iter().all(|line| line.chars().count() == 41));
        assert_eq!(lines.len(), 21);
    }
}
