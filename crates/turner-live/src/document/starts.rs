//! The gallery: scenes to start from, which the program carries with it.

/// A scene of the gallery.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The heading that it stands under.
    pub group: &'static str,
    /// Its name.
    pub name: &'static str,
    /// What it shows, in a line.
    pub about: &'static str,
    /// The name of its file, without extension.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
    /// The files that it reads: name and bytes. In WebAssembly the bytes are empty; the page fetches the files.
    pub files: &'static [(&'static str, &'static [u8])],
    /// The folder below `scenes` that they are in.
    pub folder: &'static str,
}

/// The bytes of a file of a scene.
#[cfg(not(target_arch = "wasm32"))]
macro_rules! bytes {
    ($folder:literal, $asset:literal) => {
        include_bytes!(concat!("../../../../scenes/", $folder, "/", $asset))
    };
}

#[cfg(target_arch = "wasm32")]
macro_rules! bytes {
    ($folder:literal, $asset:literal) => {
        &[]
    };
}

/// A row of the table: heading, name, description, folder, file, files that it reads.
macro_rules! starts {
    ($($group:literal { $($name:literal, $about:literal, $folder:literal $file:literal [$($asset:literal),*];)* })*) => {
        /// All scenes of the gallery, in order.
        pub const STARTS: &[Start] = &[$($(Start {
            group: $group,
            name: $name,
            about: $about,
            file: $file,
            text: include_str!(concat!("../../../../scenes/", $folder, "/", $file, ".toml")),
            files: &[$(($asset, bytes!($folder, $asset))),*],
            folder: $folder,
        },)*)*];
    };
}

starts! {
    "The five classic systems" {
        "Program sketch", "Diffuse, mirror and glass in one sum, a directional light",
            "classic" "000-program-sketch" [];
        "Whitted in eight steps", "Reflection, refraction, total internal reflection",
            "classic" "001-eight-steps" [];
        "The paper's example", "Box, sphere and plane with textures, shadow and reflection",
            "classic" "002-box-sphere-plane" ["textures/marble.png", "textures/wood.png"];
        "Simplistic pseudocode", "Contributions add up; a screen of given size",
            "classic" "003-simplistic" [];
        "Computer Graphics from Scratch", "Three spheres on a fourth, left-handed camera",
            "classic" "004-from-scratch" [];
    }
    "The paper's table" {
        "1. No light", "Only the ambient colour",
            "classic" "002-01-no-light" [];
        "2. One light", "At (10, 5, -1)",
            "classic" "002-02-one-light" [];
        "3. Two lights", "Gloss 2",
            "classic" "002-03-two-lights" [];
        "4. Wood", "A sphere with a wood texture",
            "classic" "002-04-wood" ["textures/wood.png"];
        "5. Two spheres", "One of wood, one of a solid colour",
            "classic" "002-05-two-spheres" ["textures/wood.png"];
        "6. Shadow", "Two solid spheres",
            "classic" "002-06-shadow" [];
        "7. Two shadows", "Three solid spheres",
            "classic" "002-07-two-shadows" [];
        "8. Reflection", "0.3, with shadow",
            "classic" "002-08-reflection" [];
        "9. Reflection and texture", "0.3, wood",
            "classic" "002-09-reflection-texture" ["textures/wood.png"];
        "10. Refraction", "1.0, with shadow",
            "classic" "002-10-refraction" [];
        "11. Plane", "Textured, with shadows",
            "classic" "002-11-plane" [];
        "12. Cube", "Textured with density 0.5, beside a sphere",
            "classic" "002-12-cube" ["textures/wood.png"];
        "13. Thirty spheres", "Random, reflection 0.2, gloss 2",
            "classic" "002-13-thirty-spheres" [];
    }
    "Showcase" {
        "Cornell box", "The measured geometry and colours",
            "showcase" "cornell-box" [];
        "Glass still life", "Wine, glasses, a bottle, fruit",
            "showcase" "glass-still-life" ["meshes/bottle.ply", "meshes/bowl.ply", "meshes/lime.ply", "meshes/wine.ply", "meshes/wine_glass.ply"];
        "Material balls", "Twelve materials under the same lights",
            "showcase" "material-balls" [];
        "Interior", "Sun and sky through one large window",
            "showcase" "interior" ["meshes/bowl.ply", "meshes/vase.ply"];
        "Product shot", "A bottle of perfume between softboxes",
            "showcase" "product" ["meshes/cap.ply", "meshes/flask.ply", "meshes/perfume.ply"];
        "Evening", "A low sun, and a background out of focus",
            "showcase" "evening" [];
        "Pool", "Caustics of waves in sunlight",
            "showcase" "pool" ["meshes/waves.ply"];
        "Caustics", "Of glass and metal",
            "showcase" "caustics" [];
        "Candle", "Subsurface scattering in wax",
            "showcase" "candle" ["meshes/candle.ply", "meshes/flame.ply"];
        "Foggy beam", "A spot light in haze",
            "showcase" "foggy-beam" [];
        "Smoke", "A heterogeneous medium",
            "showcase" "smoke" [];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Document;

    #[test]
    fn every_start_opens_as_a_new_document() {
        for start in STARTS {
            let document = Document::start(start).unwrap_or_else(|e| panic!("{}: {}", start.name, e.message));
            assert!(document.path().is_none() && !document.is_changed());
            assert_eq!(document.name(), start.name);
            assert!(!document.desc().objects.is_empty(), "{}", start.name);
        }
    }

    #[test]
    fn the_gallery_has_the_classic_systems_and_the_rows_of_the_table() {
        let count = |group: &str| STARTS.iter().filter(|start| start.group == group).count();
        assert_eq!(count("The five classic systems"), 5);
        assert_eq!(count("The paper's table"), 13);
        assert!(count("Showcase") >= 8);
    }
}
