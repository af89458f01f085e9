//! Every `turner-lab` command in the documents is valid. The tests do not run them, because the benchmarks take too
//! long.

use crate::folder::Folder;
use crate::sh_blocks::{documents, lines};

/// The arguments of a command; `None` for other programs.
fn arguments(line: &str) -> Option<Vec<String>> {
    let line = line.split(" #").next().unwrap_or(line).trim();
    let rest = line.strip_prefix("cargo run --release -p turner-lab -- ")?;
    Some(rest.split_whitespace().map(|word| word.trim_matches('"').to_owned()).collect())
}

#[test]
fn every_command_of_the_documents_is_known() {
    let f = Folder::new();
    let (mut wrong, mut count) = (Vec::new(), 0);
    for file in documents() {
        for (number, line) in lines(&std::fs::read_to_string(&file).unwrap()) {
            let Some(mut args) = arguments(&line) else { continue };
            count += 1;
            // Arguments before `--help` are still parsed.
            args.push("--help".to_owned());
            let run = f.lab(&args.iter().map(String::as_str).collect::<Vec<_>>());
            if run.code != Some(0) {
                wrong.push(format!("{}:{number}: {line}\n{:?} {}", file.display(), run.code, run.stderr));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 5, "{count} commands");
}
