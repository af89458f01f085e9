//! Words of other programs lead to keys, types and options that exist.

use std::collections::BTreeSet;

use crate::common::folder;

/// Sections, words of other programs, and a part of the remedy.
const KEYS: &[(&str, &[&str], &str)] = &[
    ("[[object]]\ntype = \"sphere\"", &["color", "colour", "pigment"], "material = { color"),
    ("[[object]]\ntype = \"sphere\"", &["reflection"], "k_reflect"),
    ("[[object]]\ntype = \"sphere\"", &["specular", "phong", "finish"], "shininess"),
    ("[[object]]\ntype = \"sphere\"", &["size"], "radius"),
    ("[[object]]\ntype = \"sphere\"", &["metallic", "roughness"], "base_metalness"),
    ("[[object]]\ntype = \"sphere\"", &["emission"], "emissive"),
    ("[[object]]\ntype = \"sphere\"", &["position", "location"], "center"),
    ("[[object]]\ntype = \"sphere\"", &["rotation"], "rotate"),
    ("[[object]]\ntype = \"sphere\"", &["bsdf", "texture"], "material"),
    ("[material.m]", &["reflection"], "k_reflect"),
    ("[material.m]", &["specular", "phong"], "ks"),
    ("[material.m]", &["roughness"], "gloss"),
    ("[material.m]", &["metallic", "metalness"], "metal"),
    ("[material.m]", &["ambient"], "ka"),
    ("[material.m]", &["reflectance", "base color"], "color"),
    ("[material.m]", &["emission"], "emissive"),
    ("[material.m]\ntype = \"principled\"", &["metalness", "metallic"], "base_metalness"),
    ("[material.m]\ntype = \"principled\"", &["roughness"], "specular_roughness"),
    ("[material.m]\ntype = \"principled\"", &["base color", "color"], "base_color"),
    ("[material.m]\ntype = \"principled\"", &["subsurface"], "subsurface_weight"),
    ("[material.m]\ntype = \"principled\"", &["clearcoat"], "coat_weight"),
    ("[camera]", &["eye", "location", "origin"], "position"),
    ("[camera]", &["lookat", "target"], "look_at"),
    ("[camera]", &["width", "resolution"], "[film]"),
    ("[camera]", &["aperture"], "lens_radius"),
    ("[[light]]\ntype = \"point\"\nposition = [0, 1, 0]", &["Le", "radiance"], "intensity"),
    ("[[light]]\ntype = \"point\"\nposition = [0, 1, 0]", &["power", "energy"], "intensity"),
    ("[[light]]\ntype = \"spot\"\nposition = [0, 1, 0]\nlook_at = [0, 0, 0]", &["target"], "look_at"),
    ("[film]", &["spp", "pixelsamples"], "samples"),
    ("[film]", &["size", "resolution"], "width"),
    ("[integrator]", &["depth", "maxdepth"], "max_depth"),
    ("[integrator]", &["spp"], "samples"),
    ("[background]", &["image", "envmap"], "environment"),
    ("", &["width", "spp"], "[film]"),
    ("", &["light_source", "ambient"], "[[light]]"),
    ("", &["sphere", "cube"], "[[object]]"),
    ("", &["PerspectiveCamera"], "[camera]"),
];

const KINDS: &[(&str, &[&str], &str)] = &[
    ("[[object]]", &["cube", "BoxGeometry"], "box"),
    ("[[object]]", &["trianglemesh"], "mesh"),
    ("[[object]]", &["quad"], "rectangle"),
    ("[material.m]", &["MeshStandardMaterial", "bsdf"], "principled"),
    ("[material.m]", &["conductor", "roughconductor"], "metal"),
    ("[material.m]", &["diffuse", "lambertian"], "matte"),
    ("[material.m]", &["glass"], "dielectric"),
    ("[[light]]", &["sun", "distant"], "directional"),
    ("[[light]]", &["area", "RectAreaLight"], "rectangle"),
    ("[[light]]", &["infinite", "envmap"], "environment"),
    ("[[light]]", &["constant"], "[background]"),
    ("[[light]]", &["PointLight"], "point"),
    ("[camera]", &["PerspectiveCamera", "perspective"], "pinhole"),
    ("[integrator]", &["pathtracer"], "path"),
    ("[integrator]", &["whitted"], "classic"),
    ("[texture.t]", &["bitmap"], "image"),
    ("[texture.t]", &["checker"], "checkerboard"),
    ("[medium.m]", &["heterogeneous"], "grid"),
];

const OPTIONS: &[&str] = &[
    "--spp",
    "--size",
    "--resolution",
    "--out",
    "--aovs",
    "--dof",
    "--res",
    "--denoiser",
    "--oidn",
    "--gpu",
    "--engine",
];

#[test]
fn words_of_other_programs_have_answers() {
    let f = folder();
    let mut count = 0;
    let mut check = |text: &str, word: &str, part: &str| {
        f.write("w.toml", text);
        let stderr = f.turner(&["info", "w.toml"]).fails(1, &[]).stderr;
        let help = stderr.lines().find(|l| l.contains("= help:")).unwrap_or_default();
        assert!(help.contains(part) && !help.contains("valid:"), "{word}: {stderr}");
        count += 1;
    };
    for (table, words, part) in KEYS {
        for word in *words {
            check(&format!("{table}\n\"{word}\" = 1\n"), word, part);
        }
    }
    for (table, words, part) in KINDS {
        for word in *words {
            check(&format!("{table}\ntype = \"{word}\"\n"), word, part);
        }
    }
    assert!(count >= 60, "{count}");
    for option in OPTIONS {
        let stderr = f.turner(&["s.toml", option]).fails(2, &["E0601"]).stderr;
        assert!(!stderr.contains("did you mean") && !stderr.contains("lists the options"), "{stderr}");
    }
}

/// Every word of the code in a remedy exists: `turner help` knows it.
#[test]
fn answers_name_what_exists() {
    let words = turner_cli::words();
    let commands: BTreeSet<&str> =
        ["turner", "watch", "list", "info", "help", "tonemaps", "integrators"].into();
    // Placeholders and values.
    let other = [
        "NAME", "FILE", "SCENE", "KEY", "PATH", "VALUE", "X", "Y", "W", "H", "x", "y", "z", "numbers", "row",
        "by", "or",
    ];
    let mut count = 0;
    for remedy in turner_cli::remedies() {
        for code in remedy.split('`').skip(1).step_by(2) {
            let parts = code.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '-'));
            for part in parts.filter(|p| p.chars().any(char::is_alphabetic)) {
                let is_number = part.starts_with(|c: char| c.is_ascii_digit());
                let known = words.contains(part)
                    || words.contains(&format!("--{}", part.trim_start_matches('-')))
                    || commands.contains(part)
                    || other.contains(&part)
                    || turner::color::NAMES.iter().any(|(name, _)| *name == part)
                    || ["true", "false", "D", "-D", "o", "-o", "type", "orbit", "draft", "object"]
                        .contains(&part)
                    || is_number;
                assert!(known, "{part}: {remedy}");
                count += 1;
            }
        }
    }
    assert!(count > 200, "{count}");
}

/// `turner help WORD` for every word of the scene format, every option and every error code.
#[test]
fn help_knows_every_word() {
    for word in turner_cli::words() {
        assert!(turner_cli::explained(&word).is_some(), "{word}");
    }
}
