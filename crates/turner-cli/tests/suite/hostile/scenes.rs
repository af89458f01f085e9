//! TOML and pbrt scenes with deep nesting, repetition, inconsistencies or a missing end.

use super::run::{Case, Expected};

/// A valid scene that contains the lines.
pub(super) fn around(lines: &str) -> String {
    format!("{lines}\n[[object]]\ntype = \"sphere\"\n[[light]]\ntype = \"point\"\nposition = [2, 3, 4]\n")
}

fn toml(name: &str, text: String) -> Case {
    Case::one(name, "s.toml", text)
}

fn pbrt(name: &str, text: String) -> Case {
    Case::one(name, "s.pbrt", text)
}

pub(super) fn cases() -> Vec<Case> {
    use Expected::{Error, Picture};
    let mut all = vec![
        toml("empty", String::new()),
        toml("NUL bytes", "\0".repeat(1000)).must(Error),
        toml("a byte order mark", format!("\u{feff}{}", around(""))).must(Picture),
        toml("carriage returns", around("").replace('\n', "\r\n")).must(Picture),
        Case::one(
            "UTF-16",
            "s.toml",
            around("").encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>(),
        )
        .must(Error),
        Case::one("Latin-1", "s.toml", b"# caf\xe9\n".to_vec()).must(Error),
        toml("a very long line", around(&format!("# {}", "x".repeat(4_000_000)))).must(Picture),
        toml("a very long key", format!("{} = 1", "k".repeat(1_000_000))).must(Error),
        toml("a very long name", around(&format!("[material.{}]", "m".repeat(1_000_000)))),
        toml("a name that drives a terminal", "\"\\u001b[31m\\u202e\" = 1".to_owned()).must(Error),
        toml("a value that drives a terminal", "[film]\nantialias = \"\\u001b]0;x\\u0007\"".to_owned())
            .must(Error),
        toml("the same key again", "a = 1\n".repeat(100_000)).must(Error),
        toml("many unknown keys", (0..100_000).map(|i| format!("k{i} = 1\n")).collect()).must(Error),
        toml("deep brackets", format!("a = {}", "[".repeat(1_000_000))).must(Error),
        toml("deep keys", format!("{}a = 1", "a.".repeat(1_000_000))).must(Error),
        toml("includes itself", "include = \"s.toml\"\n".to_owned()).must(Error),
        toml("a list of nothing", format!("a = [{}]", ",".repeat(1_000_000))).must(Error),
        toml("a million empty objects", "[[object]]\n".repeat(1_000_000)).must(Error),
        toml("a million numbers", around(&format!("[camera]\nposition = [{}]", "1,".repeat(1_000_000))))
            .must(Error),
        toml("groups that double", doubling(40)).must(Error),
        toml("a chain of groups", chain(100_000, false)).must(Picture),
        toml("a circle of groups", chain(1000, true)).must(Error),
        toml("a chain of textures", textures(100_000)).must(Error),
        toml("textures that double", mixes(60)).must(Error),
        pbrt("pbrt: empty", String::new()),
        pbrt("pbrt: includes itself", "WorldBegin\nInclude \"s.pbrt\"\n".to_owned()).must(Error),
        pbrt("pbrt: deep attributes", "WorldBegin\n".to_owned() + &"AttributeBegin\n".repeat(1_000_000)),
        pbrt("pbrt: an open string", "WorldBegin\nShape \"sphere".to_owned()).must(Error),
        pbrt(
            "pbrt: an open list",
            format!("WorldBegin\nShape \"trianglemesh\" \"point3 P\" [{}", "1 ".repeat(500_000)),
        ),
        pbrt("pbrt: a long name", format!("WorldBegin\n{} 1", "A".repeat(2_000_000))).must(Error),
        pbrt("pbrt: a name that drives a terminal", "WorldBegin\n\u{1b}[31m\u{202e} 1".to_owned())
            .must(Error),
        pbrt("pbrt: objects that double", pbrt_doubling(40)),
        pbrt(
            "pbrt: an object in itself",
            pbrt_world("ObjectBegin \"a\"\nObjectInstance \"a\"\nObjectEnd\nObjectInstance \"a\"\n"),
        ),
        pbrt(
            "pbrt: endless subdivision",
            pbrt_world(
                "Shape \"loopsubdiv\" \"integer levels\" [1000000] \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n",
            ),
        ),
        pbrt(
            "pbrt: a negative subdivision",
            pbrt_world(
                "Shape \"loopsubdiv\" \"integer levels\" [-1] \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n",
            ),
        ),
        pbrt(
            "pbrt: indices that lie",
            pbrt_world(
                "Shape \"trianglemesh\" \"integer indices\" [0 1 4294967295 -1 7 9] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n",
            ),
        ),
        pbrt(
            "pbrt: a huge film",
            format!(
                "Film \"rgb\" \"integer xresolution\" [2147483647] \"integer yresolution\" [2147483647]\n{}",
                pbrt_world("")
            ),
        ),
        pbrt(
            "pbrt: a transform that cannot be undone",
            pbrt_world("Transform [0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0]\nShape \"sphere\"\n"),
        ),
        pbrt(
            "pbrt: a curve of no width",
            pbrt_world("Shape \"curve\" \"point3 P\" [0 0 0 0 0 0 0 0 0 0 0 0] \"float width\" [0]\n"),
        ),
        pbrt(
            "pbrt: numbers of any size",
            pbrt_world(
                "Shape \"sphere\" \"float radius\" [1e999]\nShape \"disk\" \"float radius\" [-1e308]\nShape \"cylinder\" \"float radius\" [1e-320]\nTranslate 1e308 1e308 1e308\nShape \"sphere\"\n",
            ),
        ),
    ];
    let names = (0..80).map(|i| format!("i{i}.toml"));
    let files =
        names.enumerate().map(|(i, name)| (name, format!("include = \"i{}.toml\"\n", i + 1).into_bytes()));
    all.push(Case::new("a long chain of includes", "i0.toml", files.collect()).must(Error));
    let wide: String = (0..5000).map(|i| format!("\"w{}.toml\",", i % 60)).collect();
    let files = (0..60).map(|i| (format!("w{i}.toml"), format!("include = [{wide}]\n").into_bytes()));
    all.push(Case::new("includes in all directions", "w0.toml", files.collect()).must(Error));
    all
}

/// Groups that each have two instances of the next.
fn doubling(levels: usize) -> String {
    let mut text = around("");
    for i in 0..levels {
        for _ in 0..2 {
            text += &format!("[[group.g{i}.object]]\ntype = \"instance\"\ngroup = \"g{}\"\n", i + 1);
        }
    }
    text += &format!(
        "[[group.g{levels}.object]]\ntype = \"sphere\"\n[[object]]\ntype = \"instance\"\ngroup = \"g0\"\n"
    );
    text
}

/// Groups that each have an instance of the next.
fn chain(levels: usize, closed: bool) -> String {
    let mut text = around("");
    for i in 0..levels {
        text += &format!("[[group.g{i}.object]]\ntype = \"instance\"\ngroup = \"g{}\"\n", i + 1);
    }
    let last = if closed { "type = \"instance\"\ngroup = \"g0\"" } else { "type = \"sphere\"" };
    text += &format!("[[group.g{levels}.object]]\n{last}\n[[object]]\ntype = \"instance\"\ngroup = \"g0\"\n");
    text
}

fn textures(levels: usize) -> String {
    let mut text = String::new();
    for i in 0..levels {
        text += &format!("[texture.t{i}]\ntype = \"checkerboard\"\neven = \"t{}\"\n", i + 1);
    }
    around(&format!("{text}[texture.t{levels}]\ntype = \"checkerboard\"\n"))
}

fn mixes(levels: usize) -> String {
    let mut text = String::new();
    for i in 0..levels {
        text += &format!(
            "[texture.t{i}]\ntype = \"mix\"\na = \"t{0}\"\nb = \"t{1}\"\n",
            i + 1,
            (i + 2).min(levels)
        );
    }
    around(&format!("{text}[texture.t{levels}]\ntype = \"checkerboard\"\n"))
}

fn pbrt_world(lines: &str) -> String {
    format!(
        "LookAt 0 0 5 0 0 0 0 1 0\nCamera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n{lines}Shape \"sphere\"\n"
    )
}

fn pbrt_doubling(levels: usize) -> String {
    let mut text = String::from("ObjectBegin \"o0\"\nShape \"sphere\"\nObjectEnd\n");
    for i in 1..=levels {
        text += &format!(
            "ObjectBegin \"o{i}\"\nObjectInstance \"o{0}\"\nObjectInstance \"o{0}\"\nObjectEnd\n",
            i - 1
        );
    }
    pbrt_world(&format!("{text}ObjectInstance \"o{levels}\"\n"))
}
