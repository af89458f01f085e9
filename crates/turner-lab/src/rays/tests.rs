//! Arguments, and a small run.

use clap::Parser;

use super::*;

#[derive(Debug, Parser)]
struct Words {
    #[command(flatten)]
    args: RaysArgs,
}

fn parse(words: &[&str]) -> Result<RaysArgs, clap::Error> {
    Words::try_parse_from(std::iter::once("rays").chain(words.iter().copied())).map(|w| w.args)
}

#[test]
fn lists_are_parsed() {
    let args = parse(&["--scene", "scan,sticks", "--quality", "fast,high", "--threads", "1,2"]).unwrap();
    assert_eq!(args.scene, [SceneKind::Scan, SceneKind::Sticks]);
    assert_eq!(args.quality, [Quality::Fast, Quality::High]);
    assert_eq!(args.threads, [1, 2]);
    assert_eq!(args.embree_quality, [Rival::Medium, Rival::High, Rival::Robust]);
    let args = parse(&["--kind", "diffuse,shadow-coherent", "--embree", "lib.so"]).unwrap();
    assert_eq!(args.kind, [Kind::Diffuse, Kind::ShadowCoherent]);
    assert_eq!(args.embree, Some("lib.so".into()));
    assert_eq!((args.repeat, args.resolution, args.scale), (5, 1024, 1.0));
}

#[test]
fn invalid_arguments_are_rejected() {
    for words in [
        ["--scene", "bunny"],
        ["--threads", "4096"],
        ["--threads", "-1"],
        ["--scale", "0"],
        ["--scale", "nan"],
        ["--quality", "best"],
        ["--repeat", "0"],
        ["--resolution", "0"],
    ] {
        assert!(parse(&words).is_err(), "{words:?}");
    }
}

#[test]
fn a_small_run_has_a_rate_in_each_row() {
    let args = parse(&["--scene", "cornell", "--resolution", "32", "--repeat", "1"]).unwrap();
    let scene = SceneKind::Cornell.generate(36);
    let (trees, builds) = Trees::build(&args, None, &scene, 1).unwrap();
    assert!(builds[0].bytes > 0 && builds[0].items == 36);
    let picture = Picture::new(&scene, 32, Contender { tracer: trees.best(), query: Query::Batch });
    for kind in Kind::ALL {
        let row = measure_row(&args, &trees, &picture, kind, 2);
        assert!(row.rays > 0 && row.rates[0].1 > 0.0, "{}", kind.name());
        assert_eq!(row.compared, None);
    }
}
