//! `turner verify`: whether what this program renders on this machine is true, by statistics.
//!
//! ```text
//! checks: densities · light_tree · closed_forms · estimators · metamorphic · sameness · references
//!   └ run ── one after the other ──> Finding ── judged against a level shared by all ──> table or JSON, exit code
//! ```

mod check;
mod closed_forms;
mod densities;
mod estimators;
mod light_tree;
mod metamorphic;
mod references;
mod sameness;
mod table;

use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use clap::Args;
use turner::film::NonFinite;
use turner::scene::error::{ErrorCode, SceneError, escape, suggestion};
use turner::testing::{Random, sidak_level};

use crate::events::Events;
use crate::failure::{FAILED, Failure};
use crate::report::Reporter;
use check::{Check, Context, Effort, Finding, Verdict};
use table::Table;

/// How probable it is that a run in which all is right fails a check.
const FALSE_ALARM: f64 = 0.01;

/// Check by statistics that what is rendered is true
#[derive(Debug, Args)]
#[command(
    after_help = "Each run draws other random numbers unless --seed is given. All checks of chance share one level, so that a\n\
                        run in which all is right fails with a probability of 1 % at most: repeat a check that fails with\n\
                        --only and other seeds. Exit code 1 when a check fails."
)]
pub(crate) struct VerifyArgs {
    /// Seed of all random numbers, or `fresh` for one from the clock
    #[arg(long, value_name = "N|fresh", default_value = "fresh", value_parser = parse_seed)]
    seed: Seed,
    /// Sixteen times the samples
    #[arg(long, conflicts_with = "quick")]
    long: bool,
    /// Less of everything: half a minute
    #[arg(long)]
    quick: bool,
    /// One JSON object per line
    #[arg(long)]
    json: bool,
    /// Only checks whose name contains this (repeatable)
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Name the checks and run none
    #[arg(long)]
    list: bool,
    /// A folder with S1.exr to S4.exr, of 512x512 pixels, by another renderer
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    /// Threads; 0 is all there are
    #[arg(long, default_value_t = 0)]
    threads: usize,
}

#[derive(Clone, Copy, Debug)]
enum Seed {
    Fresh,
    Given(u64),
}

fn parse_seed(text: &str) -> Result<Seed, String> {
    match text {
        "fresh" => Ok(Seed::Fresh),
        n => n
            .parse()
            .map(Seed::Given)
            .map_err(|_| "expected a whole number of 0 or more, or `fresh`".to_owned()),
    }
}

/// Runs the command.
pub(crate) fn run(args: &VerifyArgs) -> u8 {
    match verify(args) {
        Ok(code) => code,
        Err(failure) => {
            Reporter { quiet: false, events: args.json.then_some(Events::Stdout) }.failure(&failure);
            failure.exit
        }
    }
}

/// All checks, or those asked for.
fn selected(args: &VerifyArgs) -> Result<Vec<Check>, Failure> {
    let mut all = closed_forms::checks();
    all.extend(estimators::checks());
    all.extend(metamorphic::checks());
    all.extend(sameness::checks());
    all.extend(references::checks(args.references.as_deref()));
    all.extend(densities::checks());
    all.extend(light_tree::checks());
    // It looks at what the others rendered.
    all.push(sameness::all_finite());
    let names: Vec<String> = all.iter().map(|c| c.name.clone()).collect();
    for asked in &args.only {
        if !names.iter().any(|n| n.contains(asked.as_str())) {
            let message = format!("there is no check \"{}\"", escape(asked));
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let help =
                suggestion(asked, &names).unwrap_or_else(|| "`turner verify --list` names them".into());
            return Err(Failure::usage(SceneError::new(ErrorCode::UnknownName, message).help(help)));
        }
    }
    let asked = |c: &Check| args.only.is_empty() || args.only.iter().any(|o| c.name.contains(o.as_str()));
    Ok(all.into_iter().filter(|c| asked(c) && (c.quick || !args.quick)).collect())
}

fn verify(args: &VerifyArgs) -> Result<u8, Failure> {
    let checks = selected(args)?;
    if args.list {
        let names: String = checks.iter().map(|c| format!("{}\n", c.name)).collect();
        crate::text::print(&names);
        return Ok(0);
    }
    let seed = match args.seed {
        Seed::Given(seed) => seed,
        Seed::Fresh => fresh_seed(),
    };
    let effort = match (args.quick, args.long) {
        (true, _) => Effort::Quick,
        (_, true) => Effort::Long,
        _ => Effort::Whole,
    };
    let context = Context {
        seed,
        effort,
        threads: crate::render::threads(args.threads),
        references: args.references.clone(),
        rendered: Mutex::new((NonFinite::default(), 0)),
    };
    let by_chance = checks.iter().filter(|c| c.by_chance).count();
    let level = sidak_level(FALSE_ALARM, by_chance);
    let table = Table::new(args.json, &checks);
    table.start(seed, level, by_chance);
    let (start, mut failed) = (Instant::now(), 0);
    for (i, check) in checks.iter().enumerate() {
        table.running(i, check);
        let (begin, result) = (Instant::now(), (check.run)(&context));
        // A check that cannot be done is one that fails.
        let finding = result.unwrap_or_else(|e| Finding::limit(f64::INFINITY, 0.0, escape(&e.to_string())));
        let passed = match finding.verdict {
            Verdict::Chance(p) => p >= level,
            Verdict::Limit(value, limit) => value <= limit,
        };
        failed += u32::from(!passed);
        table.row(check, &finding, passed, begin.elapsed());
    }
    table.end(checks.len(), failed, seed, start.elapsed());
    Ok(if failed > 0 { FAILED } else { 0 })
}

/// From the clock: another one each run.
fn fresh_seed() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos() as u64);
    // Short enough to be typed again.
    Random::new(now).bits() % 1_000_000_000
}
