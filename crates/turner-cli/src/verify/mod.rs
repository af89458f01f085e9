//! `turner verify`: statistical tests that this program renders correctly on this machine.
//!
//! ```text
//! checks: densities · light_tree · closed_forms · estimators · intervals · metamorphic · sameness      `turner-lab` adds more
//!   └ run_checks ── one after another ──> Finding ── compared with the significance level ──> table or JSON, exit code
//! ```

pub mod check;
mod closed_forms;
pub mod densities;
mod estimators;
mod intervals;
mod light_tree;
mod metamorphic;
mod sameness;
mod table;

use std::sync::Mutex;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use check::{Check, Context, Effort, Finding, Verdict};
use clap::Args;
use table::Table;
use turner::film::NonFinite;
use turner::schema::error::{escape, suggestion};
use turner::schema::{ErrorCode, SceneError};
use turner::testing::{Random, sidak_level};

use crate::events::Events;
use crate::failure::{FAILED, Failure};
use crate::report::Reporter;

/// Significance level of a run: the probability that a check fails although nothing is wrong.
const FALSE_ALARM: f64 = 0.01;

/// Test with statistics that Turner renders correct pictures (half a minute)
#[derive(Debug, Args)]
#[command(after_help = VERIFY_HELP)]
pub(crate) struct VerifyArgs {
    #[command(flatten)]
    run: RunArgs,
}

/// How to read the results of the statistical tests.
pub const VERIFY_HELP: &str = "\
Each run uses a new random seed unless --seed is given. The statistical tests together have a
significance level of 1 %: if nothing is wrong, at most one run in a hundred fails. Repeat a
failed check with --only and other seeds. Exit code 1 if a check fails.";

/// Which checks to run, and how.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Seed of the random numbers, or `fresh` for a seed from the clock
    #[arg(long, value_name = "N|fresh", default_value = "fresh", value_parser = parse_seed)]
    seed: Seed,
    /// Print one JSON object per line
    #[arg(long)]
    json: bool,
    /// Run only checks whose name contains NAME (repeatable)
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// List the checks without running them
    #[arg(long)]
    list: bool,
    /// Number of threads; 0 means all cores
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
        n => n.parse().map(Seed::Given).map_err(|_| "expected an integer, 0 or more, or `fresh`".to_owned()),
    }
}

/// Runs the command.
pub(crate) fn run(args: &VerifyArgs) -> u8 {
    run_checks(checks(), &args.run, Effort::Short)
}

/// The checks of `turner verify`: each takes a second or two.
pub fn checks() -> Vec<Check> {
    let mut all = closed_forms::checks();
    all.extend(estimators::checks());
    all.extend(intervals::checks());
    all.extend(metamorphic::checks());
    all.extend(sameness::checks());
    all.extend(densities::checks());
    all.extend(light_tree::checks());
    all
}

/// Runs the selected checks, and one on the samples of all of them; prints the findings. Returns the exit code.
pub fn run_checks(mut checks: Vec<Check>, args: &RunArgs, effort: Effort) -> u8 {
    checks.push(sameness::all_finite());
    match selected(checks, args).and_then(|checks| verify(&checks, args, effort)) {
        Ok(code) => code,
        Err(failure) => {
            Reporter { quiet: false, events: args.json.then_some(Events::Stdout) }.failure(&failure);
            failure.exit
        }
    }
}

/// The selected checks, or all.
fn selected(all: Vec<Check>, args: &RunArgs) -> Result<Vec<Check>, Failure> {
    for wanted in &args.only {
        if !all.iter().any(|c| c.name.contains(wanted.as_str())) {
            let message = format!("there is no check \"{}\"", escape(wanted));
            let names: Vec<&str> = all.iter().map(|c| c.name.as_str()).collect();
            let help = suggestion(wanted, &names)
                .unwrap_or_else(|| "`turner verify --list` lists the checks".into());
            return Err(Failure::usage(SceneError::new(ErrorCode::UnknownName, message).help(help)));
        }
    }
    let is_selected =
        |c: &Check| args.only.is_empty() || args.only.iter().any(|o| c.name.contains(o.as_str()));
    Ok(all.into_iter().filter(is_selected).collect())
}

fn verify(checks: &[Check], args: &RunArgs, effort: Effort) -> Result<u8, Failure> {
    if args.list {
        let names: String = checks.iter().map(|c| format!("{}\n", c.name)).collect();
        crate::text::print(&names);
        return Ok(0);
    }
    let seed = match args.seed {
        Seed::Given(seed) => seed,
        Seed::Fresh => fresh_seed(),
    };
    let context = Context {
        seed,
        effort,
        threads: crate::render::threads(args.threads),
        rendered: Mutex::new((NonFinite::default(), 0)),
    };
    let statistical = checks.iter().filter(|c| c.by_chance).count();
    let level = sidak_level(FALSE_ALARM, statistical);
    let table = Table::new(args.json, checks);
    table.start(seed, level, statistical);
    let (start, mut failed) = (Instant::now(), 0);
    for (i, check) in checks.iter().enumerate() {
        table.running(i, check);
        let (begin, result) = (Instant::now(), (check.run)(&context));
        // A check that cannot be run fails.
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

/// A seed from the clock.
fn fresh_seed() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_nanos() as u64);
    // Short enough to type.
    Random::new(now).bits() % 1_000_000_000
}
