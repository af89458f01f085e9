//! Selects the channels of an EXR file that make up the image.

use super::FORMAT;
use super::subsampled::is_subsampled;
use crate::assets::printable;
use crate::image::ImageError;
use exr::meta::header::Header;

/// Channels of a part, each with the image channel that it becomes.
pub(super) struct Choice {
    pub(super) part: usize,
    /// By index in the header's channel list; `None` if unused.
    pub(super) to: Vec<Option<u8>>,
    /// 1, 2, 3 or 4.
    pub(super) channels: u8,
    /// Whether the first three are RY, Y and BY.
    pub(super) is_chroma: bool,
}

/// The supported channel sets, in order of preference; the names are in the order of the image's channels.
const SETS: &[&[&str]] = &[
    &["R", "G", "B", "A"],
    &["R", "G", "B"],
    &["RY", "Y", "BY", "A"],
    &["RY", "Y", "BY"],
    &["Y", "A"],
    &["Y"],
];

/// Selects the channels; the error names the channels that exist and those that are missing.
pub(super) fn choose(headers: &[Header], name: &str) -> Result<Choice, ImageError> {
    // Deep parts are flattened if there are no others.
    let is_deep = headers.iter().all(|h| h.deep);
    let flat = || headers.iter().enumerate().filter(|(_, h)| h.deep == is_deep);
    let names: Vec<(usize, Vec<String>)> =
        flat().map(|(i, h)| (i, h.channels.list.iter().map(|c| c.name.to_string()).collect())).collect();
    let choice = names
        .iter()
        .find_map(|(layer, names)| in_layer(*layer, names, ""))
        .or_else(|| names.iter().find_map(|(layer, names)| in_any_named_layer(*layer, names)))
        .or_else(|| {
            names.iter().find(|(_, n)| n.len() == 1).map(|&(layer, _)| Choice {
                part: layer,
                to: vec![Some(0)],
                channels: 1,
                is_chroma: false,
            })
        });
    let Some(choice) = choice else {
        let all: Vec<&str> = names.iter().flat_map(|(_, n)| n).take(16).map(String::as_str).collect();
        let missing: Vec<&str> = ["R", "G", "B"].into_iter().filter(|c| !all.contains(c)).collect();
        let found = format!("channels {} and without {}", all.join(", "), missing.join(", "));
        return Err(ImageError::unsupported(name, FORMAT, found, "R, G, B (and A), Y, or a single channel"));
    };
    let list = &headers[choice.part].channels.list;
    let chroma = list.iter().zip(&choice.to).filter(|(c, to)| matches!(to, Some(0 | 2)) && is_subsampled(c));
    if let (true, Some((c, _))) =
        (choice.is_chroma, { chroma }.find(|(c, _)| (c.sampling.0, c.sampling.1) != (2, 2)))
    {
        let found = format!("chroma at every {} × {} pixels", c.sampling.0, c.sampling.1);
        return Err(ImageError::unsupported(name, FORMAT, found, "chroma at every 1 × 1 or 2 × 2 pixels"));
    }
    Ok(choice)
}

fn in_layer(layer: usize, names: &[String], prefix: &str) -> Option<Choice> {
    SETS.iter().find_map(|set| {
        let mut to = vec![None; names.len()];
        for (i, suffix) in set.iter().enumerate() {
            let at = names.iter().position(|n| n.strip_prefix(prefix) == Some(suffix))?;
            to[at] = Some(i as u8);
        }
        Some(Choice { part: layer, to, channels: set.len() as u8, is_chroma: set.first() == Some(&"RY") })
    })
}

/// Channel lists are sorted by name, so the first named layer is the alphabetically first.
fn in_any_named_layer(layer: usize, names: &[String]) -> Option<Choice> {
    let mut last = "";
    names.iter().filter_map(|n| n.rfind('.').map(|dot| &n[..=dot])).find_map(|prefix| {
        if prefix == last {
            return None;
        }
        last = prefix;
        in_layer(layer, names, prefix)
    })
}

/// The names of the channels of each part. In files of several parts the channels of a part with a name get it as a
/// prefix, unless they have it already.
pub(super) fn full_names(headers: &[Header]) -> Vec<Vec<String>> {
    let many = headers.len() > 1;
    let part = |header: &Header| {
        let prefix = header.own_attributes.layer_name.as_ref().filter(|_| many).map(|n| format!("{n}."));
        let prefix = prefix.filter(|p| p.len() > 1).unwrap_or_default();
        let full = |name: String| if name.starts_with(&prefix) { name } else { format!("{prefix}{name}") };
        header.channels.list.iter().map(|c| full(c.name.to_string())).collect()
    };
    headers.iter().map(part).collect()
}

/// The components of a layer that make up an image, in order of preference and in lower case.
const COMPONENTS: &[&[&str]] = &[
    &["r", "g", "b", "a"],
    &["r", "g", "b"],
    &["x", "y", "z"],
    &["y", "a"],
    &["x", "y"],
    &["u", "v"],
    &["y"],
];

/// Selects the channels of a layer by its name, such as `albedo`, `N` or `Z`; in upper or lower case if only that
/// finds it.
pub(super) fn in_layer_named(headers: &[Header], name: &str, layer: &str) -> Result<Choice, ImageError> {
    let names = full_names(headers);
    let flat: Vec<usize> = (0..headers.len()).filter(|part| !headers[*part].deep).collect();
    let prefix = format!("{layer}.");
    let exact =
        |name: &str| (name == layer).then_some("").or_else(|| name.strip_prefix(&prefix)).map(str::to_owned);
    let lower = prefix.to_lowercase();
    let any_case = |name: &str| {
        let name = format!("{}.", name.to_lowercase());
        name.strip_prefix(&lower).map(|rest| rest.trim_end_matches('.').to_owned())
    };
    let by = |component: &dyn Fn(&str) -> Option<String>| {
        flat.iter().find_map(|&part| components(part, names.get(part)?, component))
    };
    let Some(choice) = by(&exact).or_else(|| by(&any_case)) else {
        return Err(unknown_layer(headers, name, layer));
    };
    Ok(choice)
}

/// The choice among channels whose component (the empty one is the layer itself) is given by `component`.
fn components(part: usize, names: &[String], component: &dyn Fn(&str) -> Option<String>) -> Option<Choice> {
    let found: Vec<Option<String>> = names.iter().map(|n| component(n).map(|c| c.to_lowercase())).collect();
    let position = |wanted: &str| found.iter().position(|c| c.as_deref() == Some(wanted));
    if let Some(at) = position("") {
        let mut to = vec![None; names.len()];
        to[at] = Some(0);
        return Some(Choice { part, to, channels: 1, is_chroma: false });
    }
    let set = COMPONENTS.iter().find(|set| set.iter().all(|c| position(c).is_some()));
    let Some(set) = set else {
        // A layer with one channel of any other name.
        let mut only = (0..found.len()).filter(|i| found[*i].is_some());
        let (at, None) = (only.next()?, only.next()) else { return None };
        let mut to = vec![None; names.len()];
        to[at] = Some(0);
        return Some(Choice { part, to, channels: 1, is_chroma: false });
    };
    let mut to = vec![None; names.len()];
    for (i, component) in set.iter().enumerate() {
        to[position(component)?] = Some(i as u8);
    }
    // Two components that are not a value and its alpha are shown as red and green.
    let channels = if matches!(set, [_, second] if *second != "a") { 3 } else { set.len() as u8 };
    Some(Choice { part, to, channels, is_chroma: false })
}

/// Most layers that an error lists.
const MOST_LISTED: usize = 32;

/// The error for a layer that the file does not have, with those that it has.
pub(super) fn unknown_layer(headers: &[Header], name: &str, layer: &str) -> ImageError {
    let mut layers: Vec<String> = Vec::new();
    for full in full_names(headers).into_iter().flatten() {
        // A hostile file has millions.
        if layers.len() > MOST_LISTED {
            break;
        }
        let layer = full.rsplit_once('.').map_or(full.as_str(), |(layer, _)| layer).to_owned();
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    }
    let more = if layers.len() > MOST_LISTED { ", …" } else { "" };
    layers.truncate(MOST_LISTED);
    let found = format!("no layer \"{layer}\"");
    ImageError::NoLayer {
        name: printable(name),
        layer: printable(&found),
        layers: printable(&format!("{}{more}", layers.join(", "))),
    }
}
