//! Remedies of the library as options of the command line: a key of the scene becomes the option that sets it.

use turner::schema::value::{Data, Value};
use turner::schema::{ErrorCode, KeyEdit, Quality, Remedy, SceneError, Warning};

/// The key that `--shared-paths` sets.
pub(crate) const SHARED_PATHS: &str = "integrator.shared_paths";

/// The option that sets it.
pub(crate) const SHARED_PATHS_OPTION: &str = "--shared-paths";

/// Keys of a scene that have options of their own.
const OPTIONS: &[(&str, &str)] = &[
    ("film.antialias", "--antialias"),
    ("film.aovs", "--aov"),
    ("film.denoise", "--denoise"),
    ("film.denoise_aovs", "--denoise-aovs"),
    ("film.auto_exposure", "--auto-exposure"),
    ("film.crop", "--crop"),
    ("film.exposure", "--exposure"),
    ("film.filter", "--filter"),
    ("film.height", "--height"),
    ("film.samples", "--samples"),
    ("film.seed", "--seed"),
    ("film.tonemap", "--tonemap"),
    ("film.width", "--width"),
    ("integrator.caustics", "--caustics"),
    ("integrator.clamp_indirect", "--clamp-indirect"),
    ("integrator.max_depth", "--max-depth"),
    (SHARED_PATHS, SHARED_PATHS_OPTION),
    ("integrator.type", "--integrator"),
    ("studio.backdrop", "--background"),
    ("studio.camera", "--camera"),
    ("studio.f_stop", "--fstop"),
    ("studio.focus", "--focus"),
    ("studio.fov", "--fov"),
    ("studio.ground", "--ground"),
    ("studio.look_at", "--look-at"),
    ("studio.zoom", "--zoom"),
];

/// The option that sets a key, if one does.
pub(crate) fn option(key: &str) -> Option<&'static str> {
    OPTIONS.iter().find(|(k, _)| *k == key).map(|(_, option)| *option)
}

/// The key that an option sets, if it sets one.
pub(crate) fn key(option: &str) -> Option<&'static str> {
    OPTIONS.iter().find(|(_, o)| *o == option).map(|(key, _)| *key)
}

/// The options that apply a remedy.
pub(crate) fn of(remedy: &Remedy) -> String {
    match remedy {
        Remedy::Set(edits) => edits.iter().map(set).collect::<Vec<_>>().join(" "),
        Remedy::MoreMemory => "--max-memory SIZE".to_owned(),
        Remedy::MoreTriangles => "--max-triangles N".to_owned(),
        Remedy::LargerPictures => "--max-texture-size PIXELS".to_owned(),
        Remedy::OpenFolder => "--allow-path DIR".to_owned(),
        Remedy::Replace => "--force".to_owned(),
        Remedy::Define(name) => format!("--define {name}=VALUE"),
        Remedy::Environment => "--environment FILE".to_owned(),
        Remedy::TreeQuality(Quality::Fast) => "--bvh-quality fast".to_owned(),
        Remedy::TreeQuality(Quality::Balanced) => "--bvh-quality balanced".to_owned(),
        Remedy::TreeQuality(Quality::High) => "--bvh-quality high".to_owned(),
        Remedy::Seconds(seconds) => format!("--seconds {}", number(*seconds)),
        // A remedy without an option.
        _ => String::new(),
    }
}

/// The help of an error, with the options that apply its remedy.
pub(crate) fn help(error: &SceneError) -> Option<String> {
    let help = error.help.clone();
    if error.code == ErrorCode::Strict {
        let plain = "without --strict this is a warning".to_owned();
        return Some(help.map_or(plain.clone(), |help| format!("{plain}; {help}")));
    }
    match (error.remedy.as_deref().map(of).filter(|o| !o.is_empty()), help) {
        (Some(options), Some(help)) => Some(format!("{help} ({options})")),
        (options, help) => options.or(help),
    }
}

/// The message of a warning, with the options that apply its remedy.
pub(crate) fn message(warning: &Warning) -> String {
    match warning.remedy.as_ref().map(of).filter(|o| !o.is_empty()) {
        Some(options) => format!("{}: {options}", warning.message),
        None => warning.message.clone(),
    }
}

/// The option that sets the value: its own, or `--set`.
fn set(edit: &KeyEdit) -> String {
    let key: Vec<&str> = edit.path.iter().map(|part| part.key.as_str()).collect();
    let key = key.join(".");
    match (option(&key), &edit.value.data) {
        (Some(option), Data::Bool(true)) => option.to_owned(),
        (Some(option), Data::Bool(false)) => option.replacen("--", "--no-", 1),
        (Some(option), Data::String(word)) => format!("{option} {word}"),
        (Some(option), Data::Array(list)) => format!("{option} {}", items(list)),
        (Some(option), data) => format!("{option} {}", toml(data)),
        // Quoted for the shell.
        (None, data @ Data::String(_)) => format!("--set '{key}={}'", toml(data)),
        (None, data) => format!("--set {key}={}", toml(data)),
    }
}

/// A value in TOML.
fn toml(data: &Data) -> String {
    match data {
        Data::Bool(b) => b.to_string(),
        Data::Integer(i) => i.to_string(),
        Data::Number(v) => number(*v),
        Data::String(text) => format!("\"{text}\""),
        Data::Array(list) => format!("[{}]", items(list)),
        Data::Table(table) => {
            let entries: Vec<String> =
                table.entries.iter().map(|e| format!("{} = {}", e.key, toml(&e.value.data))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
    }
}

fn items(list: &[Value]) -> String {
    list.iter().map(|v| toml(&v.data)).collect::<Vec<_>>().join(",")
}

/// The shortest form of a number; small and large ones with an exponent.
fn number(v: f64) -> String {
    if v == 0.0 || (1e-3..1e5).contains(&v.abs()) {
        return format!("{v}");
    }
    let short = format!("{v:.2e}");
    if short.parse() == Ok(v) { short } else { format!("{v:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remedies_become_options() {
        let cases = [
            (
                Remedy::set("integrator.type", "path").and("integrator.caustics", "full"),
                "--integrator path --caustics full",
            ),
            (Remedy::set("film.crop", [0, 0, 640, 480u32]), "--crop 0,0,640,480"),
            (Remedy::set("film.exposure", 0.0), "--exposure 0"),
            (Remedy::set("film.exposure", -1.25), "--exposure -1.25"),
            (Remedy::set("film.auto_exposure", true), "--auto-exposure"),
            (Remedy::set("studio.ground", false), "--no-ground"),
            (Remedy::set("film.transfer", "srgb"), "--set 'film.transfer=\"srgb\"'"),
            (Remedy::set("camera.look_at", [1.0, -0.5, 2e6]), "--set camera.look_at=[1,-0.5,2.00e6]"),
            (Remedy::set("light.0.intensity", 1.0 / 3e4), "--set light.0.intensity=3.3333333333333335e-5"),
            (Remedy::MoreMemory, "--max-memory SIZE"),
            (Remedy::Define("spp".to_owned()), "--define spp=VALUE"),
            (Remedy::TreeQuality(Quality::High), "--bvh-quality high"),
            (Remedy::Seconds(60.0), "--seconds 60"),
        ];
        for (remedy, options) in cases {
            assert_eq!(of(&remedy), options);
        }
    }

    #[test]
    fn help_ends_with_the_option() {
        let error = SceneError::new(ErrorCode::TooLarge, "too large").remedy(Remedy::MoreMemory);
        assert_eq!(help(&error).as_deref(), Some("--max-memory SIZE"));
        assert_eq!(
            help(&error.help("raise the limit")).as_deref(),
            Some("raise the limit (--max-memory SIZE)")
        );
        let strict = SceneError::new(ErrorCode::Strict, "no effect");
        assert_eq!(help(&strict).as_deref(), Some("without --strict this is a warning"));
    }
}
