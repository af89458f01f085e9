//! `turner-lab scenes`: scenes of Mitsuba in Turner and in another program that answers as Mitsuba does.
#![cfg(unix)]

use serde_json::Value;

use crate::folder::Folder;

/// Light from everywhere: no noise, brighter than in the other program.
const LAMP: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective"><film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="32"/></film></sensor>
    <emitter type="constant"><rgb name="radiance" value="0.875"/></emitter>
</scene>"#;

/// Answers as `benches/peers/render.py` does, with pictures whose values are 0.5 and 0.75 at random: a mean of 0.625 with a
/// variance of 0.0156. Scenes named `refused` fail.
const ANSWERS: &str = r#"case "$3" in *refused*) echo '{"error": "RuntimeError: unexpected <lookAt>", "help": ""}'; exit;; esac
echo '{"width": 64, "height": 32}'
read width height
echo '{"start_seconds": 2.5, "version": "1.2"}'
while read samples seed file; do
    awk -v n=$((width * height * 3)) -v seed=$seed 'BEGIN {
        srand(seed)
        for (i = 0; i < n; i++) printf "%s", (rand() < 0.5) ? "\\0000\\0000\\0000\\0077" : "\\0000\\0000\\0100\\0077"
    }' > "$file.text"
    printf '%b' "$(cat "$file.text")" > "$file"
    echo "{\"samples\": $samples, \"seconds\": 0.5, \"width\": $width, \"height\": $height}"
done"#;

/// Two scenes that render, one that Mitsuba refuses and one that Turner refuses.
fn folder() -> Folder {
    let f = Folder::new();
    for name in ["room", "broken"] {
        std::fs::create_dir_all(f.path().join("all").join(name)).unwrap();
    }
    f.write("all/lamp.xml", LAMP);
    f.write("all/refused.xml", LAMP);
    f.write("all/room/scene.xml", LAMP);
    f.write("all/broken/scene.xml", "<scene version='3.0.0'><shape type='no-such-shape'/></scene>");
    f
}

fn json(text: &str) -> Vec<Value> {
    text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn scenes_are_measured_or_listed_with_the_reason() {
    let f = folder();
    let python = f.script("python", ANSWERS);
    let args = ["scenes", "all", "--size", "288", "--samples", "4", "--seeds", "2", "--reference", "4"];
    let more = ["--references", "kept", "--threads", "1", "--python", &python];
    let all = [&args[..], &more].concat();
    let lines = json(&f.lab(&[&all[..], &["--json"]].concat()).ok().stdout);
    let of = |scene: &str| lines.iter().filter(|l| l["scene"] == scene).collect::<Vec<_>>();
    for scene in ["lamp", "room"] {
        let found = of(scene);
        assert_eq!(found.len(), 2, "{lines:?}");
        assert_eq!(
            (&found[0]["renderer"], &found[1]["renderer"]),
            (&"mitsuba-llvm".into(), &"turner".into())
        );
        // 288 pixels in the proportions of 64 x 32.
        assert_eq!((&found[1]["width"], &found[1]["height"]), (&24.into(), &12.into()));
        assert_eq!((&found[0]["version"], &found[0]["median_seconds"]), (&"1.2".into(), &0.5.into()));
        let [own, ratio] =
            [&found[1]["median_seconds"], &found[1]["over_peer"]["time"]].map(|v| v.as_f64().unwrap());
        assert!(own > 0.0 && (ratio / (own / 0.5) - 1.0).abs() < 1e-9, "{lines:?}");
        // Turner's picture is 0.875: brighter by a factor of 1.4. With halves of 0.5 and 0.75 at random, the expected
        // errors are 0.2005 and 0.0437: (x - a)(x - b) / (r² + 0.01) over the four pairs.
        let brightness = found[1]["mean"].as_f64().unwrap();
        assert!((brightness - 1.4).abs() < 0.03, "{lines:?}");
        let error = found[1]["over_peer"]["error"].as_f64().unwrap();
        assert!((error - 0.2005 / 0.0437).abs() < 0.6, "{lines:?}");
    }
    assert!(of("refused")[0]["left_out"].as_str().unwrap().contains("unexpected <lookAt>"), "{lines:?}");
    assert!(of("broken")[0]["left_out"].as_str().unwrap().contains("no-such-shape"), "{lines:?}");
    let summary = lines.last().unwrap();
    assert_eq!((&summary["over"], &summary["scenes"]), (&"mitsuba-llvm".into(), &2.into()));

    // References are kept: two halves for each scene.
    let kept = || {
        let files = std::fs::read_dir(f.path().join("kept")).unwrap().map(|e| e.unwrap());
        files.map(|e| (e.path(), e.metadata().unwrap().modified().unwrap())).collect::<Vec<_>>()
    };
    let before = kept();
    assert_eq!(before.len(), 4);
    let text = f.lab(&[&all[..], &["--before", env!("CARGO_BIN_EXE_turner-lab")]].concat());
    text.fails(1, &["does not answer --version as Turner does"]);
    let turner = f.script("turner-now", &format!("exec {} turner \"$@\"", env!("CARGO_BIN_EXE_turner-lab")));
    let text = f.lab(&[&all[..], &["--before", &turner]].concat()).ok();
    assert!(text.stdout.contains("turner over before, 2 scenes"), "{}", text.stdout);
    assert!(text.stdout.contains("2 scenes left out: broken, refused\n"), "{}", text.stdout);
    assert_eq!(kept(), before);
    let table = f.lab(&[&all[..], &["--markdown"]].concat()).ok().stdout;
    assert!(table.contains("2 scenes left out:\n") && table.contains("\n  broken: turner: "), "{table}");
    assert!(
        table.starts_with("| scene |") && table.contains("| geometric mean | turner over mitsuba-llvm"),
        "{table}"
    );
}

#[test]
fn programs_that_do_not_run_are_one_error() {
    let f = folder();
    let args =
        |more: &[&'static str]| [&["scenes", "all/lamp.xml", "--references", "kept"][..], more].concat();
    f.lab(&args(&["--python", "no-such-python"]))
        .fails(1, &["no-such-python cannot be run", "--install-peers"]);
    f.lab(&args(&["--turner", "no-such-turner"])).fails(1, &["no-such-turner cannot be run"]);
    f.lab(&["scenes", "all", "--references", "all/lamp.xml"]).fails(1, &["cannot be made", "--references"]);
    f.lab(&["scenes", "none"]).fails(2, &["no such file or folder", "scene.xml"]);
    f.lab(&["scenes"]).fails(2, &["DIR|FILE"]);
    f.lab(&args(&["--peer", "cycles"])).fails(2, &["mitsuba-scalar"]);
    // Without LLVM the scalar variant is measured; without both, the error is that of LLVM.
    let scalar = f.script(
        "scalar",
        &format!("[ $2 = mitsuba-llvm ] && {{ echo '{{\"error\": \"no libLLVM\"}}'; exit; }}\n{ANSWERS}"),
    );
    let run = f
        .lab(&[
            "scenes",
            "all/lamp.xml",
            "--size",
            "288",
            "--samples",
            "1",
            "--seeds",
            "1",
            "--reference",
            "2",
            "--references",
            "kept",
            "--python",
            &scalar,
        ])
        .ok();
    assert!(run.stderr.contains("no libLLVM; mitsuba-scalar is measured instead"), "{}", run.stderr);
    assert!(run.stdout.contains("over mitsuba-scalar, 1 scene"), "{}", run.stdout);
    let none = f.script("none", "echo '{\"error\": \"no module\", \"help\": \"install it\"}'");
    f.lab(&["scenes", "all/lamp.xml", "--python", &none])
        .fails(1, &["mitsuba-llvm: no module", "install it"]);
    // A scene alone that cannot be loaded is a failure.
    let python = f.script("python", ANSWERS);
    f.lab(&["scenes", "all/refused.xml", "--references", "kept", "--python", &python])
        .fails(1, &["left out: mitsuba-llvm: RuntimeError: unexpected <lookAt>"]);
}
