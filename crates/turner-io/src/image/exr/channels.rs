//! Selects the channels of an EXR file that make up the image.

use super::FORMAT;
use crate::image::ImageError;
use exr::meta::header::Header;

/// A layer, and for each of its channels the image channel that it becomes.
pub(super) struct Choice {
    pub(super) layer: usize,
    /// By index in the header's channel list; `None` if unused.
    pub(super) to: Vec<Option<u8>>,
    /// 1, 2, 3 or 4.
    pub(super) channels: u8,
}

/// The supported channel sets, in order of preference; the names are in the order of the image's channels.
const SETS: &[&[&str]] = &[&["R", "G", "B", "A"], &["R", "G", "B"], &["Y", "A"], &["Y"]];

/// Selects the channels; the error names the channels that exist and those that are missing.
pub(super) fn choose(headers: &[Header], name: &str) -> Result<Choice, ImageError> {
    let flat = || headers.iter().enumerate().filter(|(_, h)| !h.deep);
    if flat().next().is_none() {
        return Err(ImageError::unsupported(name, FORMAT, "deep data", "flat pixels"));
    }
    let names: Vec<(usize, Vec<String>)> =
        flat().map(|(i, h)| (i, h.channels.list.iter().map(|c| c.name.to_string()).collect())).collect();
    let choice = names
        .iter()
        .find_map(|(layer, names)| in_layer(*layer, names, ""))
        .or_else(|| names.iter().find_map(|(layer, names)| in_any_named_layer(*layer, names)))
        .or_else(|| {
            names.iter().find(|(_, n)| n.len() == 1).map(|&(layer, _)| Choice {
                layer,
                to: vec![Some(0)],
                channels: 1,
            })
        });
    let Some(choice) = choice else {
        let all: Vec<&str> = names.iter().flat_map(|(_, n)| n).take(16).map(String::as_str).collect();
        let missing: Vec<&str> = ["R", "G", "B"].into_iter().filter(|c| !all.contains(c)).collect();
        let found = format!("channels {} and without {}", all.join(", "), missing.join(", "));
        return Err(ImageError::unsupported(name, FORMAT, found, "R, G, B (and A), Y, or a single channel"));
    };
    let list = &headers[choice.layer].channels.list;
    // Luminance/chroma files: Y alone would drop the colours.
    let chroma = list.iter().any(|c| matches!(c.name.as_slice(), b"RY" | b"BY"));
    if (chroma && choice.channels < 3) || list.iter().any(|c| c.sampling.0 != 1 || c.sampling.1 != 1) {
        let found = "luminance and chroma or subsampled channels";
        return Err(ImageError::unsupported(name, FORMAT, found, "R, G, B at full resolution"));
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
        Some(Choice { layer, to, channels: set.len() as u8 })
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
