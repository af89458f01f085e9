//! The page of each error code: a paragraph, a faulty example, the remedy. `turner help E0102` and
//! docs/reference/errors.md show them.

use turner::schema::ErrorCode;

/// The page of one code.
#[derive(Clone, Copy, Debug)]
pub struct ErrorPage {
    /// The code.
    pub code: ErrorCode,
    /// What it means.
    pub text: &'static str,
    /// An example with this error: a scene, or a command if it begins with `turner`. Empty if there is no example.
    pub faulty: &'static str,
    /// How to correct it.
    pub remedy: &'static str,
}

/// All pages, in the order of [`ErrorCode::ALL`].
pub const PAGES: &[ErrorPage] = &[
    ErrorPage {
        code: ErrorCode::Syntax,
        text: "The file does not follow the TOML grammar: a missing quote, bracket or equals sign, or a key given twice. Reading stops here, so this error comes alone.",
        faulty: "[film]\nwidth = 640 height = 480",
        remedy: "Correct the marked position. Write one `key = value` per line, text in quotes, lists in brackets.",
    },
    ErrorPage {
        code: ErrorCode::UnknownKey,
        text: "A section or table has a key that its kind does not know. It is misspelt, belongs to another section, or is the word of another program.",
        faulty: "[[object]]\ntype = \"sphere\"\nradus = 2",
        remedy: "Use the key that the message suggests. `turner help KEY` shows where a key may stand, `turner help KIND` lists the keys of a kind.",
    },
    ErrorPage {
        code: ErrorCode::UnknownName,
        text: "A name refers to something that does not exist: a `type`, a word of a fixed set, a colour, or a material, texture, medium or group that the scene does not define.",
        faulty: "[[object]]\ntype = \"sphere\"\nmaterial = \"gold\"",
        remedy: "Correct the name, or define it: `[material.gold]`. `turner list` shows kinds, words and colours.",
    },
    ErrorPage {
        code: ErrorCode::WrongType,
        text: "The value has another type than the key takes, for instance text in place of a number, or a list with too few numbers.",
        faulty: "[camera]\nposition = [0, 1]",
        remedy: "Write a value of the type in the message. `turner help KEY` shows the type and an example.",
    },
    ErrorPage {
        code: ErrorCode::OutOfRange,
        text: "A number lies outside the range of its key, or is infinite or NaN.",
        faulty: "[camera]\nfov = 200",
        remedy: "Write a number within the range in the message. `turner help KEY` shows the range.",
    },
    ErrorPage {
        code: ErrorCode::MissingKey,
        text: "A required key is missing: the `type` of an object, the `group` of an instance, the `file` of a model.",
        faulty: "[[object]]\nmaterial = { color = \"red\" }",
        remedy: "Add the key that the message names.",
    },
    ErrorPage {
        code: ErrorCode::Conflict,
        text: "Two keys contradict each other, or a name is already in use, as where a texture has the name of a colour. With `turner resume` and `turner merge`: checkpoints and scene do not belong together, or parts overlap.",
        faulty: "[texture.red]\ntype = \"constant\"\ncolor = 0.5",
        remedy: "Keep one of the two keys, or choose another name. Render the parts of a picture from the same files with the same options.",
    },
    ErrorPage {
        code: ErrorCode::Cycle,
        text: "Groups, textures, materials or included files contain themselves, directly or through others, or are nested too deeply.",
        faulty: "[[group.a.object]]\ntype = \"instance\"\ngroup = \"a\"\n\n[[object]]\ntype = \"instance\"\ngroup = \"a\"",
        remedy: "Break the cycle: let one of them refer to something else.",
    },
    ErrorPage {
        code: ErrorCode::TooLarge,
        text: "The scene needs more memory, triangles or texture resolution than the limits allow. The limits protect the machine from untrusted and damaged files.",
        faulty: "turner scene.toml --width 60000 --height 60000 --max-memory 1G",
        remedy: "If you trust the file, raise the limit with the option that the message names: `--max-memory`, `--max-triangles` or `--max-texture-size`.",
    },
    ErrorPage {
        code: ErrorCode::File,
        text: "A file does not exist, cannot be read, or lies outside the folder of the scene, which scenes may not read unless you allow it.",
        faulty: "[[object]]\ntype = \"mesh\"\nfile = \"missing.obj\"",
        remedy: "Correct the path; it is relative to the file that names it. For a file outside the scene's folder add `--allow-path DIR`.",
    },
    ErrorPage {
        code: ErrorCode::Image,
        text: "An image cannot be decoded: it is damaged, or its format is not supported.",
        faulty: "turner scene.toml --environment damaged.hdr",
        remedy: "Save the image again, in a format of `turner list formats`.",
    },
    ErrorPage {
        code: ErrorCode::Mesh,
        text: "A mesh file is damaged, or mesh data is inconsistent: a triangle refers to a vertex that does not exist, or the number of normals differs from the number of positions.",
        faulty: "[[object]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\ntriangles = [[0, 1, 3]]",
        remedy: "Correct the data, or export the mesh again. Indices count from 0.",
    },
    ErrorPage {
        code: ErrorCode::Model,
        text: "A model file (glTF, OBJ, pbrt, Mitsuba, …) is invalid, or requires a feature that Turner does not support.",
        faulty: "turner damaged.glb",
        remedy: "Export the model again, without the extension that the message names.",
    },
    ErrorPage {
        code: ErrorCode::Profile,
        text: "An IES file, the measured emission of a light, is invalid or requires an unsupported feature.",
        faulty: "turner scene.toml -D light.0.ies=damaged.ies",
        remedy: "Obtain the file again from the manufacturer, or remove the key `ies`.",
    },
    ErrorPage {
        code: ErrorCode::Volume,
        text: "The density grid of a medium is invalid.",
        faulty: "turner scene.toml -D medium.smoke.file=damaged.grid",
        remedy: "Write the grid again; `turner help grid` describes the format.",
    },
    ErrorPage {
        code: ErrorCode::Film,
        text: "A checkpoint, or a film that was saved by a program that uses the library, is damaged or of another version of Turner.",
        faulty: "",
        remedy: "Copy the file again, continue it with the version of Turner that wrote it, or render again.",
    },
    ErrorPage {
        code: ErrorCode::Font,
        text: "A font file is invalid, or cannot be read. TrueType and OpenType can: .ttf, .otf, .ttc.",
        faulty: "turner scene.toml -D object.0.font=damaged.ttf",
        remedy: "Obtain the font again, or choose another one.",
    },
    ErrorPage {
        code: ErrorCode::Measured,
        text: "The file of a measured BRDF is invalid, or its tables contradict each other.",
        faulty: "turner scene.toml -D material.paint.file=damaged.bsdf",
        remedy: "Download the file again, for example from the RGL material database.",
    },
    ErrorPage {
        code: ErrorCode::Transform,
        text: "A transform cannot be inverted: a scale of 0, a matrix whose axes are not independent, or a rotation axis of length 0.",
        faulty: "[[object]]\ntype = \"sphere\"\ntransform = { scale = [1, 0, 1] }",
        remedy: "Give every axis a scale other than 0. For a flat object use a `disk` or a `rectangle`.",
    },
    ErrorPage {
        code: ErrorCode::Camera,
        text: "The camera has no valid direction: `position` equals `look_at`, `up` is zero or parallel to the view direction, or the name of a camera does not exist.",
        faulty: "[camera]\nposition = [0, 1, 5]\nlook_at = [0, 1, 5]",
        remedy: "Move `look_at` away from `position`. A camera that looks straight down needs another `up`, e.g. `up = [0, 0, -1]`.",
    },
    ErrorPage {
        code: ErrorCode::Output,
        text: "The picture cannot be written: the folder does not exist, the disk is full, the format is unknown, or the name is that of a file that the scene reads.",
        faulty: "turner scene.toml -o picture.xyz",
        remedy: "Name another file with `-o FILE`. `turner list formats` lists the formats.",
    },
    ErrorPage {
        code: ErrorCode::Strict,
        text: "Something in the file would be ignored. Without `--strict` this is a warning.",
        faulty: "turner scene.toml --strict",
        remedy: "Remove what is ignored, or omit `--strict`.",
    },
    ErrorPage {
        code: ErrorCode::Usage,
        text: "An option or argument is unknown, lacks its value, or contradicts another one. The exit code is 2.",
        faulty: "turner scene.toml --spp 64",
        remedy: "Use the option that the message suggests. `turner COMMAND --help-all` lists all options of a command.",
    },
    ErrorPage {
        code: ErrorCode::Internal,
        text: "Turner has a bug. What was rendered before is saved where possible.",
        faulty: "",
        remedy: "Please report it with the scene and the message.",
    },
];

/// The page of a code, e.g. `E0102`, in either case.
pub(crate) fn page(code: &str) -> Option<&'static ErrorPage> {
    PAGES.iter().find(|p| p.code.as_str().eq_ignore_ascii_case(code))
}

/// The page as text for a terminal.
pub(crate) fn text(page: &ErrorPage) -> String {
    let mut out = format!("Error {}\n\n", page.code.as_str());
    for paragraph in [page.code.meaning(), page.text] {
        crate::text::wrap(&mut out, &paragraph.replace('`', ""), 2);
    }
    if !page.faulty.is_empty() {
        out += "\n  Example of the error:\n\n";
        for line in page.faulty.lines() {
            out += format!("    {line}").trim_end();
            out.push('\n');
        }
    }
    out += "\n  Remedy:\n\n";
    crate::text::wrap(&mut out, &page.remedy.replace('`', ""), 2);
    out
}

/// All pages as Markdown: docs/reference/errors.md.
pub fn markdown() -> String {
    let mut out = String::from(
        "# Errors\n\nEvery error has a stable code. `turner help E0102` prints its page, `turner list errors` lists all codes. Turner\n\
         reports all errors of a scene in one run, at most 20 of them in full. The exit code is 1 for a bad scene or\n\
         output and 2 for bad usage. With `--json` each error is an event: `turner help json`.\n\n\
         This page is generated: `TURNER_UPDATE=1 cargo test -p turner-cli docs` rewrites it.\n",
    );
    for page in PAGES {
        out += &format!("\n## {}\n\n{}\n\n{}\n", page.code.as_str(), page.code.meaning(), page.text);
        if !page.faulty.is_empty() {
            out += &format!("\n```text\n{}\n```\n", page.faulty);
        }
        out += &format!("\n{}\n", page.remedy);
    }
    out
}
