//! The picture does not depend on the instruction set.

use crate::common::folder;

/// Highlights, mirrors, glass, tinted and soft shadows, several shapes, textures.
const SCENE: &str = r#"
[film]
width = 61
height = 47

[camera]
position = [0, 1.5, 6]
look_at = [0, 1, 0]

[background]
color = [0.2, 0.3, 0.5]
zenith = "white"

[[light]]
type = "ambient"
intensity = 0.2

[[light]]
type = "point"
position = [5, 8, 5]
intensity = 0.5

[[light]]
type = "directional"
from = [-1, 1, 1]
intensity = 0.3

[[light]]
type = "spot"
position = [0, 6, 3]
attenuation = [1, 0.1, 0]

[[light]]
type = "sphere"
center = [-3, 4, 2]
radius = 1
samples = 4
intensity = 0.4

[[object]]
type = "plane"
material = { color = { type = "checkerboard" }, k_reflect = 0.2 }

[[object]]
type = "sphere"
center = [-1, 1, 0]
material = { color = "tomato", ks = 0.7, shininess = 37, k_reflect = 0.3 }

[[object]]
type = "sphere"
center = [1.2, 1, 0.5]
material = { color = [0.9, 1, 0.9], kd = 0.1, ks = 1, shininess = 120.5, k_reflect = 1, k_refract = 1, fresnel = "exact", shadow = "tinted" }

[[object]]
type = "sphere"
transform = [{ scale = [0.4, 0.8, 0.4] }, { translate = [0.2, 0.8, -2] }]
material = { color = { type = "wood" }, ks = 1, gloss = 1.3 }

[[object]]
type = "box"
transform = [{ translate = [2.5, 0.5, -2] }]
material = { color = "steelblue", ks = 1, shininess = 0 }
"#;

#[test]
fn pictures_are_the_same_with_every_instruction_set() {
    let f = folder();
    f.write("k.toml", SCENE);
    for (extra, name) in [
        (&[][..], "a"),
        (&["-D", "integrator.epsilon=0.001", "--antialias", "adaptive"], "b"),
        (&["--integrator", "cost"], "c"),
        (&["--integrator", "wireframe"], "d"),
        (&["--integrator", "ambient-occlusion"], "e"),
    ] {
        let picture = |set: &str, threads: &str| {
            let out = format!("{name}-{set}.exr");
            let mut command = f.command(&["k.toml", "-o", &out, "--threads", threads, "--quiet"]);
            let status = command.args(extra).env("TURNER_INSTRUCTION_SET", set).status().unwrap();
            assert!(status.success());
            f.read(&out)
        };
        let scalar = picture("scalar", "1");
        assert!(scalar == picture("avx2", "2"), "avx2, where there is one");
        assert!(scalar == picture("avx512", "3"), "avx512, where there is one");
    }
}
