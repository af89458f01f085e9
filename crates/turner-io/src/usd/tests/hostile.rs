//! Damaged and hostile files: an error or a scene, never a panic, within bounded time and memory.

use super::*;
use crate::testing::usd_seed::{BINARY, TEXT, package};

fn of_bytes(bytes: Vec<u8>, name: &str) -> Result<SceneDesc, SceneError> {
    import(bytes, name, &MemoryAssets::default(), &ImportOptions::default())
}

fn fails(text: &str) -> SceneError {
    let error = try_read(text, &ImportOptions::default()).unwrap_err();
    assert!(!error.message.is_empty() && error.help.is_some(), "{error:?}");
    error
}

#[test]
fn errors_name_the_line() {
    let error = fails("#usda 1.0\ndef Xform \"A\"\n{\n    float x = 1 2\n}\n");
    assert!(error.message.starts_with("a.usda:4:17: "), "{}", error.message);
    let error = fails("#usda 1.0\ndef Mesh \"A\" { point3f[] points = [(1, 2)] }");
    assert!(error.message.contains("2 numbers are not vectors of 3"), "{}", error.message);
    for text in [
        "def",
        "def \"A\"",
        "def \"A\" {",
        "def \"A\" ( x = ",
        "def \"A\" { float x = \"",
        "def \"A\" { asset x = @",
        "}",
    ] {
        fails(&format!("#usda 1.0\n{text}"));
    }
    assert!(of_bytes(b"usda".to_vec(), "a.usda").unwrap_err().message.contains("#usda"));
    assert!(of_bytes(vec![0xFF; 40], "a.usd").is_err());
    assert!(of_bytes(Vec::new(), "a.usdc").is_err());
}

#[test]
fn nesting_is_bounded() {
    let deep =
        |open: &str, close: &str| format!("#usda 1.0\n{}{}", open.repeat(200_000), close.repeat(200_000));
    assert!(fails(&deep("def \"a\" {", "}")).message.contains("deep"));
    fails(&format!("#usda 1.0\ndef \"a\" (customData = {}) {{}}", "{ dictionary d = ".repeat(100_000)));
    fails(&format!("#usda 1.0\n(x = {})", "[".repeat(100_000)));
    fails(&format!("#usda 1.0\ndef \"a\" {{ float3[] x = {} }}", "(".repeat(100_000)));
    fails(&deep("def \"a\" { variantSet \"v\" = { \"x\" {", "}}}"));
}

#[test]
fn references_to_themselves_end() {
    for text in [
        "def \"A\" (references = </A>) {}",
        "def \"A\" { def \"B\" (references = </A>) {} }",
        "def \"A\" (references = </B>) {}\n def \"B\" (references = </A>) {}",
        "def \"A\" (inherits = </A>) {}",
        "def \"A\" { def \"B\" (inherits = </A>) {} }",
        "def \"A\" (references = </B/C>) {}\n def \"B\" { def \"C\" { def \"D\" (references = </A>) {} } }",
    ] {
        let scene = read(text);
        assert!(scene.warnings.iter().any(|w| w.message.contains("itself")), "{text}: {:?}", scene.warnings);
    }
    let mut assets = MemoryAssets::default();
    let text = b"#usda 1.0\n(defaultPrim = \"A\"\n subLayers = [@a.usda@, @b.usda@])\ndef Sphere \"A\" (references = @a.usda@) {}";
    assets.files.insert("a.usda".into(), text.to_vec());
    let scene = import(text.to_vec(), "a.usda", &assets, &ImportOptions::default()).unwrap();
    assert_eq!(scene.objects.len(), 1);
}

#[test]
fn references_that_double_end() {
    // Each prim refers twice to the next.
    let mut text = String::new();
    for i in 0..46 {
        text += &format!(
            "def \"A{i}\" {{ def \"L\" (references = </A{}>) {{}}\n def \"R\" (references = </A{}>) {{}} }}\n",
            i + 1,
            i + 1
        );
    }
    text += "def \"A46\" { def Sphere \"S\" {} }";
    let error = fails(&text);
    assert!(error.message.contains("multipl"), "{}", error.message);
    let mut text = String::new();
    for i in 0..46 {
        text += &format!(
            "def \"A{i}\" (references = [</A{}>, </B{}>]) {{}}\ndef \"B{i}\" (references = [</A{}>, </B{}>]) {{}}\n",
            i + 1,
            i + 1,
            i + 1,
            i + 1
        );
    }
    // An error or a scene.
    let _ = try_read(&text, &ImportOptions::default());
}

#[test]
fn numbers_of_meshes_are_checked() {
    let mesh = |counts: &str, indices: &str| {
        read(&format!(
            "def Mesh \"M\" {{ int[] faceVertexCounts = {counts}\n int[] faceVertexIndices = {indices}\n\
             point3f[] points = [(0, 0, 0), (1, 0, 0), (nan, 1, 0), (1e300, 1, 0)]\n\
             normal3f[] normals = [(0, 0, inf)] (interpolation = \"faceVarying\")\n int[] primvars:st:indices = [-5, 99]\n\
             texCoord2f[] primvars:st = [(nan, 0)] (interpolation = \"faceVarying\") }}"
        ))
    };
    for (counts, indices) in [
        ("[3]", "[0, 1, 2]"),
        ("[3]", "[0, 1, 9]"),
        ("[3]", "[0, 1, -1]"),
        ("[-3]", "[0, 1, 1]"),
        ("[2147483647, 3]", "[0, 1, 1]"),
        ("[9223372036854775807, 9223372036854775807]", "[0, 1, 1]"),
        ("[1, 2, 0]", "[0, 1, 1]"),
        ("[3]", "[0, 1, 1]"),
    ] {
        let scene = mesh(counts, indices);
        assert!(scene.objects.len() <= 1, "{counts} {indices}");
        scene.meshes.iter().for_each(|m| m.data.check().unwrap());
        let _ = scene.prepare(&Default::default());
    }
    for text in [
        "def PointInstancer \"I\" { int[] protoIndices = [0, 5, -1]\n point3f[] positions = [(0, 0, 0)]\n rel prototypes = [</I>, </None>] }",
        "def PointInstancer \"I\" { int[] protoIndices = [0]\n point3f[] positions = [(0, 0, 0)]\n rel prototypes = </I/P>\n def PointInstancer \"P\" { int[] protoIndices = [0]\n point3f[] positions = [(0, 0, 0)]\n rel prototypes = </I> } }",
        "def Sphere \"S\" { double radius = -1 }",
        "def Cube \"S\" { double size = nan }",
        "def Camera \"C\" { float focalLength = 0\n float verticalAperture = 0 }",
        "def SphereLight \"L\" { float inputs:intensity = inf\n float inputs:radius = -3 }",
        "def BasisCurves \"C\" { int[] curveVertexCounts = [4, -1, 2147483647]\n point3f[] points = [(0, 0, 0)] }",
        "def Xform \"A\" { float3 xformOp:scale = (0, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:scale\", \"!invert!xformOp:scale\"]\n def Sphere \"S\" {} }",
    ] {
        let _ = read(text).prepare(&Default::default());
    }
}

#[test]
fn damaged_text_and_binary_files_do_not_panic() {
    for (seed, name) in [(TEXT.as_bytes(), "a.usda"), (BINARY, "a.usdc")] {
        for length in 0..seed.len() {
            let _ = of_bytes(seed[..length].to_vec(), name);
        }
        for at in 0..seed.len() {
            for byte in [0, 0xFF, 0x7F, seed[at].wrapping_add(1), seed[at] ^ 0x80, b'{', b'('] {
                let mut bytes = seed.to_vec();
                bytes[at] = byte;
                let _ = of_bytes(bytes, name);
            }
        }
    }
}

#[test]
fn counts_of_binary_files_are_compared_with_their_bytes() {
    // Each position as a count of 2^44 elements.
    for at in 0..BINARY.len() - 8 {
        let mut bytes = BINARY.to_vec();
        bytes[at..at + 8].copy_from_slice(&(1_u64 << 44).to_le_bytes());
        let _ = of_bytes(bytes, "a.usdc");
    }
    let mut old = BINARY.to_vec();
    old[9] = 3;
    assert!(of_bytes(old, "a.usdc").unwrap_err().message.contains("version 0.3"));
}

#[test]
fn packages_do_not_leave_themselves() {
    let open = |files: &[(&str, &[u8])]| of_bytes(package(files), "a.usdz");
    assert_eq!(open(&[("a.usda", TEXT.as_bytes())]).unwrap().objects.len(), 4);
    for name in ["/a.usda", "../a.usda", "a/../../b.usda", "C:a.usda", "a\\b.usda", "a//b.usda"] {
        let error = open(&[(name, TEXT.as_bytes())]).unwrap_err();
        assert!(error.message.contains("leaves it"), "{name}: {error:?}");
    }
    let outside = b"#usda 1.0\ndef \"A\" (references = @../secret.usda@) {}";
    let scene = open(&[("in/a.usda", outside)]).unwrap();
    assert!(scene.warnings[0].message.contains("secret.usda"), "{:?}", scene.warnings);
    let mut squeezed = package(&[("a.usda", TEXT.as_bytes())]);
    let list = squeezed.windows(4).rposition(|w| w == b"PK\x01\x02").unwrap();
    squeezed[list + 10] = 8;
    assert!(of_bytes(squeezed, "a.usdz").unwrap_err().message.contains("compressed"));
    let seed = package(&[("a.usdc", BINARY), ("b.png", &[1, 2, 3])]);
    for at in (0..seed.len()).filter(|at| *at < 64 || *at + 160 > seed.len()) {
        for byte in [0, 0xFF, seed[at].wrapping_add(1)] {
            let mut bytes = seed.clone();
            bytes[at] = byte;
            let _ = of_bytes(bytes, "a.usdz");
        }
    }
}
