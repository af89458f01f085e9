//! Saving the picture and the scene.

use serde_json::{Value as Json, json};
use turner_io::image::{ImageFormat, Transfer};
use turner_io::{SaveOptions, to_bytes};
use turner_live::engine::Stage;

use super::calls::Args;
use super::{CallError, Reply, Session};

pub(super) fn save(session: &Session, args: &Json) -> Result<Reply, CallError> {
    let wanted = Args(args).text("format")?;
    let name = session.document.name();
    let stem = name.rsplit_once('.').map_or(name.as_str(), |(stem, _)| stem).to_owned();
    if wanted == "toml" {
        let text = session.document.text()?;
        return Ok(Reply { json: json!({ "name": format!("{stem}.toml") }), bytes: text.into_bytes() });
    }
    let format = ImageFormat::of_path(std::path::Path::new(&format!("picture.{wanted}")))
        .map_err(|e| CallError::new(e.to_string()))?;
    let frame = session.frame()?;
    if frame.stage == Stage::Preview {
        let help = Some("wait until the first samples are rendered".to_owned());
        return Err(CallError { help, ..CallError::new("the picture is a preview, which is not saved") });
    }
    // As Turner Studio saves it.
    let samples = session.stepper.status().samples.0;
    let software = format!("Turner {}", env!("CARGO_PKG_VERSION"));
    let header = [("Software", software), ("turner:samples", samples.to_string())];
    let metadata = header.map(|(key, value)| (key.to_owned(), value.as_str().into())).into_iter().collect();
    let transfer = match frame.transform.transfer {
        turner::color::Transfer::None => Transfer::Unstated,
        _ => Transfer::Srgb,
    };
    let options = SaveOptions { threads: session.threads, metadata, transfer, ..SaveOptions::default() };
    let bytes = to_bytes(&*frame.picture, format, &options).map_err(|e| CallError::new(e.to_string()))?;
    let is_final = frame.stage == Stage::Settled;
    Ok(Reply { json: json!({ "name": format!("{stem}.{wanted}"), "settled": is_final }), bytes })
}
