//! `turner studio` and `turner bench studio`, with a program of that name that writes its arguments.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use crate::common::{Folder, Run, folder};

/// A copy of `turner` in a folder where nothing stands beside it.
fn alone(f: &Folder) -> PathBuf {
    let (from, to) = (env!("CARGO_BIN_EXE_turner"), f.path().join("turner"));
    if std::fs::hard_link(from, &to).is_err() {
        std::fs::copy(from, &to).unwrap();
    }
    to
}

/// A program that writes its arguments and ends with 7.
fn stand_in(folder: &Path) {
    let program = folder.join("turner-studio");
    std::fs::write(&program, "#!/bin/sh\nprintf '%s|' \"$@\"\nexit 7\n").unwrap();
    std::fs::set_permissions(program, std::fs::Permissions::from_mode(0o755)).unwrap();
}

fn run(f: &Folder, program: &Path, path: &str, args: &[&str]) -> Run {
    Run::of(f.program(program.to_str().unwrap(), args).env("PATH", path).output().unwrap())
}

#[test]
fn it_starts_the_program_beside_it_or_on_the_path() {
    let f = folder();
    let turner = alone(&f);
    stand_in(f.path());
    let beside = run(&f, &turner, "/usr/bin:/bin", &["studio", "s.toml"]).fails(7, &[]);
    assert_eq!(beside.stdout, "s.toml|");
    std::fs::remove_file(f.path().join("turner-studio")).unwrap();
    let other = f.path().join("other");
    std::fs::create_dir(&other).unwrap();
    stand_in(&other);
    let path = format!("/usr/bin:{}", other.display());
    let found = run(&f, &turner, &path, &["studio"]).fails(7, &[]);
    assert_eq!(found.stdout, "|", "no argument");
    let bench = ["bench", "studio", "--json", "--references", "kept", "a.toml", "b.toml"];
    let bench = run(&f, &turner, &path, &bench).fails(7, &[]);
    assert_eq!(bench.stdout, "bench|--json|--references|kept|a.toml|b.toml|");
    let dashed = run(&f, &turner, &path, &["studio", "--", "-s.toml"]).fails(7, &[]);
    assert_eq!(dashed.stdout, "./-s.toml|");
}

#[test]
fn without_the_program_it_says_how_to_build_it() {
    let f = folder();
    let turner = alone(&f);
    // A file that cannot be executed is no program.
    f.write("turner-studio", "");
    for args in [&["studio"][..], &["studio", "s.toml"], &["bench", "studio"]] {
        let run = run(&f, &turner, "/nowhere", args);
        run.fails(1, &["neither beside this one nor on the PATH", "cargo run --release -p turner-studio"]);
    }
}
