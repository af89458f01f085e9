//! Meaningless numbers are errors at their position in the text. `tests/bad_input.rs` of the renderer covers their
//! effect on path tracing.

use turner_io::assets::MemoryAssets;
use turner_io::scene::{LoadOptions, load_text};

const SMALL: &str = "film = { width = 8, height = 8, antialias = \"monte-carlo\", samples = 16 }\n\
    integrator = { type = \"path\", rr_start = 1000 }\ncamera = { position = [0, 0, 4], look_at = [0, 0, 0], fov = 10 }\n";

fn sphere(material: &str) -> String {
    format!("{SMALL}object = [{{ type = \"sphere\", material = {{ {material} }} }}]\n")
}

/// The error when reading a scene.
fn refused(text: &str) -> String {
    let read = load_text(text.to_owned(), "s.toml", &MemoryAssets::default(), &LoadOptions::default());
    let Err(error) = read else { panic!("{text}") };
    error.to_string()
}

#[test]
fn numbers_out_of_range_are_errors_at_their_place() {
    for (material, words) in [
        ("type = \"emissive\", strength = -1", "0 or more, found -1"),
        ("type = \"emissive\", strength = nan", "finite number"),
        ("type = \"emissive\", strength = inf", "finite number"),
        ("type = \"emissive\", color = [1, -2, 0]", "0 or more, found -2"),
        ("type = \"emissive\", color = [nan, 1, 0]", "finite"),
        ("type = \"principled\", emission_luminance = -0.5", "0 or more, found -0.5"),
        ("type = \"matte\", color = [-0.1, 0, 0]", "0 or more"),
        ("type = \"matte\", color = nan", "finite"),
        ("type = \"dielectric\", ior = -1.5", "`ior` must be"),
        ("type = \"dielectric\", ior = nan", "finite"),
        ("type = \"principled\", coat_ior = 0", "`coat_ior` must be"),
        ("type = \"plastic\", ior = 1e6", "`ior` must be"),
        ("type = \"principled\", specular_ior = -1", "`specular_ior` must be"),
        ("type = \"principled\", specular_roughness = 1e9", "0 to 1, found 1000000000"),
        ("type = \"principled\", specular_roughness = -1", "0 to 1, found -1"),
        ("type = \"metal\", roughness = 55", "0 to 1, found 55"),
        ("type = \"mix\", materials = [{}, {}], weights = [-1]", "0 or more, found -1"),
    ] {
        let error = refused(&sphere(material));
        assert!(error.contains(words) && error.contains("s.toml:4:"), "{material}: {error}");
    }
}

#[test]
fn lights_without_area() {
    for light in [
        "type = \"disk\", center = [0, 2, 0], radius = 0",
        "type = \"sphere\", center = [0, 2, 0], radius = 0",
    ] {
        let error = refused(&format!("{}light = [{{ {light} }}]", sphere("type = \"matte\"")));
        assert!(error.contains("greater than 0"), "{light}: {error}");
    }
    for (shape, words) in [
        ("type = \"disk\", radius = 0", "greater than 0"),
        ("type = \"sphere\", transform = { scale = [1, 0, 1] }", "scale"),
    ] {
        let emissive = "material = { type = \"emissive\" }";
        let error = refused(&format!("{SMALL}object = [{{ {shape}, {emissive} }}]"));
        assert!(error.contains(words), "{shape}: {error}");
    }
}
