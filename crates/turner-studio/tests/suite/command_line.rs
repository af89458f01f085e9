//! The command line of Turner inside the program.

use std::process::Command;

fn run(args: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_turner-studio")).args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_word_turner_starts_the_command_line() {
    let (code, stdout, _) = run(&["turner", "--version"]);
    assert_eq!(code, Some(0));
    assert!(stdout.starts_with("turner ") && !stdout.contains("studio"), "{stdout}");
    let (code, stdout, _) = run(&["--version"]);
    assert_eq!((code, stdout.starts_with("turner-studio ")), (Some(0), true));
    let (code, _, stderr) = run(&["turner", "render", "--colour", "x.toml"]);
    assert_eq!(code, Some(2), "{stderr}");
    let (code, _, stderr) = run(&["turner", "render", "missing.toml"]);
    assert!(code == Some(1) && stderr.contains("missing.toml"), "{stderr}");
}
