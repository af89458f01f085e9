//! Style sheets of drawings and pages, for light and dark colour schemes.

/// Name, colour in the light scheme, colour in the dark scheme. The colours of rays differ in lightness as well as in
/// hue, for colour-blind readers.
const PALETTE: [(&str, &str, &str); 15] = [
    ("page", "#fbfaf7", "#16181d"),
    ("card", "#ffffff", "#1d2026"),
    ("ink", "#23262d", "#e8e6e0"),
    ("dim", "#6d7280", "#9aa0ad"),
    ("rule", "#d9d6cd", "#333842"),
    ("body", "#efece4", "#2a2e37"),
    ("edge", "#a8a394", "#5c6370"),
    ("camera", "#3b3f4a", "#d5d8e0"),
    ("reflected", "#1768c4", "#6bb0ff"),
    ("refracted", "#0c8a5b", "#48d597"),
    ("diffuse", "#a6451b", "#ff9b6b"),
    ("glossy", "#8a3fb0", "#d199f5"),
    ("straight", "#5b7f95", "#9cc3d9"),
    ("lit", "#d99a00", "#ffc94d"),
    ("blocked", "#c03a4b", "#ff7b8a"),
];

const VIEWS: &str = include_str!("views.css");
const SVG: &str = include_str!("svg.css");
const PAGE: &str = include_str!("page.css");

/// Rules for rays and the names of their kinds.
fn rays() -> String {
    let kinds = ["camera", "reflected", "refracted", "diffuse", "glossy", "straight"];
    let shadows = [("shadow", "lit"), ("shadow.blocked", "blocked")];
    let all = kinds.into_iter().map(|kind| (kind, kind)).chain(shadows);
    all.map(|(class, color)| {
        let c = format!("var(--{color})");
        format!(
            ".ray.{class} .line,.ray.{class} .camera-mark{{stroke:{c}}}.ray.{class} .head,.ray.{class} .dot,.ray.{class} .number{{fill:{c}}}\
             .kind.{class}{{fill:{c};color:{c}}}.bar.{class}{{fill:{c};background:{c}}}\n"
        )
    })
    .collect()
}

/// For drawings: colours are written out, because some SVG viewers do not support CSS variables.
pub(crate) fn of_drawing() -> String {
    let rules = format!("{VIEWS}{SVG}{}", rays());
    let with = |dark: bool| {
        PALETTE.iter().fold(rules.clone(), |rules, (name, in_light, in_dark)| {
            rules.replace(&format!("var(--{name})"), if dark { in_dark } else { in_light })
        })
    };
    format!("{}@media (prefers-color-scheme:dark){{\n{}}}\n", with(false), with(true))
}

/// For pages.
pub(crate) fn of_page() -> String {
    let variables = |dark: bool| -> String {
        let each = PALETTE.iter();
        each.map(|(name, light, in_dark)| format!("--{name}:{};", if dark { in_dark } else { light }))
            .collect()
    };
    format!(
        ":root{{color-scheme:light dark;{}}}\n@media (prefers-color-scheme:dark){{:root{{{}}}}}\n{VIEWS}{PAGE}{}",
        variables(false),
        variables(true),
        rays()
    )
}
