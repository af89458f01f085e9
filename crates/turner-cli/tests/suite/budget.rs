//! Renders that end by noise or time, and what they say about it.

use std::time::Instant;

use crate::common::{Folder, Run, folder};

const PATH: [&str; 7] = ["s.toml", "--integrator", "path", "--width", "40", "--height", "28"];

fn run(f: &Folder, more: &[&str]) -> Run {
    f.turner(&[&PATH[..], more].concat())
}

/// The event at the end.
fn done(f: &Folder, more: &[&str]) -> serde_json::Value {
    let run = run(f, &[more, &["--json"]].concat()).ok();
    let mut lines = run.stdout.lines().map(|l| serde_json::from_str::<serde_json::Value>(l).unwrap());
    lines.rfind(|e| e["event"] == "done").unwrap()
}

#[test]
fn noise_ends_a_render_at_the_same_sample_everywhere() {
    let f = folder();
    let loose = done(&f, &["--noise", "20%", "-o", "a.png"]);
    let tight = done(&f, &["--noise", "0.05", "--threads", "1", "-o", "b.png"]);
    assert_eq!((&loose["ended_by"], &tight["ended_by"]), (&"noise".into(), &"noise".into()));
    assert_eq!((&loose["complete"], &loose["finished"]), (&true.into(), &1.0.into()));
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    assert!(number(&tight["samples"]) > 2.0 * number(&loose["samples"]), "{loose} {tight}");
    for (event, limit) in [(&loose, 0.2), (&tight, 0.05)] {
        let (value, interval) = (number(&event["noise"]["value"]), &event["noise"]["interval"]);
        assert!(value <= limit && number(&interval[0]) <= value && value <= number(&interval[1]), "{event}");
    }
    run(&f, &["--noise", "0.05", "--threads", "2", "-o", "c.png"]).ok();
    assert!(f.read("b.png") == f.read("c.png"), "another number of threads");
    // The samples are those of a render of as many.
    let pixels = 40.0 * 28.0;
    let samples = (number(&tight["samples"]) / pixels).to_string();
    run(&f, &["--samples", &samples, "-o", "d.png"]).ok();
    f.turner(&["compare", "b.png", "d.png", "--metric", "max", "--tolerance", "0"]).ok();
    // The first limit ends it.
    let both = done(&f, &["--noise", "0.05", "--samples", "8", "-o", "e.png"]);
    assert_eq!((&both["ended_by"], number(&both["samples"])), (&serde_json::Value::Null, 8.0 * pixels));
}

#[test]
fn adaptive_sampling_is_the_same_when_it_is_continued() {
    let f = folder();
    let event = done(&f, &["--adaptive", "--samples", "32", "-o", "a.png"]);
    let mean = event["samples"].as_f64().unwrap() / (40.0 * 28.0);
    assert!((16.0..=32.0).contains(&mean), "{event}");
    let keep = ["--checkpoint", "part.turner-checkpoint"];
    run(&f, &[&["--adaptive", "--samples", "16", "-o", "b.png"][..], &keep].concat()).ok();
    f.turner(&["resume", "part.turner-checkpoint", "--samples", "32", "-o", "b.png"]).ok();
    f.turner(&["compare", "a.png", "b.png", "--metric", "max", "--tolerance", "0"]).ok();
    let noise = done(&f, &["--adaptive", "--noise", "10%", "-o", "c.png"]);
    assert_eq!((&noise["ended_by"], &noise["complete"]), (&"noise".into(), &true.into()));
    run(&f, &["--adaptive", "--sample-range", "0..8", "-o", "e.turner-checkpoint"])
        .fails(2, &["--sample-range", "--adaptive"]);
    let ignored = run(&f, &["--adaptive", "--filter", "gaussian", "--samples", "2", "-o", "d.png"]).ok();
    assert!(ignored.stderr.contains("`adaptive_sampling` is ignored"), "{}", ignored.stderr);
}

#[test]
fn a_budget_is_an_upper_limit() {
    let f = folder();
    let begun = Instant::now();
    let event = done(&f, &["--budget", "0.8s", "-o", "a.png"]);
    // Far above any load of the machine that still lets the test pass elsewhere.
    assert!(begun.elapsed().as_secs_f64() < 20.0);
    assert_eq!((&event["ended_by"], &event["complete"]), (&"budget".into(), &true.into()));
    assert!(event["samples"].as_u64().unwrap() > 40 * 28, "{event}");
    assert_eq!(f.names(), ["a.png", "s.toml"], "no checkpoint stays");
    // Less time than loading takes: a coarse picture.
    let event = done(&f, &["--budget", "1ms", "-o", "b.png"]);
    assert_eq!(event["output"], "b.png", "{event}");
    // Samples end it earlier.
    let event = done(&f, &["--budget", "1h", "--samples", "4", "-o", "c.png"]);
    assert_eq!(
        (&event["ended_by"], event["samples"].as_u64()),
        (&serde_json::Value::Null, Some(4 * 40 * 28))
    );
}

#[test]
fn the_closing_line_says_what_half_the_noise_takes() {
    let f = folder();
    let line = run(&f, &["--samples", "16", "-o", "a.png"]).ok().stderr;
    assert!(line.contains("16 samples per pixel, ") && line.contains(", noise "), "{line}");
    assert!(line.contains("; 64 samples, ") && line.contains(" more, would halve it"), "{line}");
    let bytes = f.read("a.png");
    assert!(bytes.windows(12).any(|w| w == b"turner:noise"), "the header has it");
    for (args, error) in [
        (&["--budget", "soon"][..], "expected a time such as 30s"),
        (&["--noise", "0"], "expected a fraction such as 0.02"),
    ] {
        let refused = run(&f, args);
        assert!(refused.code == Some(2) && refused.stderr.contains(error), "{}", refused.stderr);
    }
    // One sample per pixel has no noise that could be known.
    let line = f.turner(&["s.toml", "-o", "b.png"]).ok().stderr;
    assert!(!line.contains("noise"), "{line}");
}

#[test]
fn a_preview_shows_in_the_terminal() {
    let f = folder();
    let shown = run(&f, &["--samples", "4", "--preview=blocks", "-o", "a.png"]).ok().stderr;
    assert!(shown.contains('\u{2580}') || shown.contains('\u{2584}'), "{shown}");
    let refused = run(&f, &["--tev", "127.0.0.1:9", "-o", "b.png"]);
    assert!(refused.code == Some(1) && refused.stderr.contains("start tev first"), "{}", refused.stderr);
}
