//! Pictures by the native session, for comparison with those of the page.

use std::path::Path;

use turner::schema::Limits;
use turner_web::{Event, Session};

use crate::in_memory::SCENES;

/// Writes `NAME.toml`, `NAME.png` and `NAME.exr`.
pub(super) fn write(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for (name, text) in [("hello", SCENES[0]), ("paths", &SCENES[1].replace(ROOF, BALL))] {
        let mut session = Session::new(0, Limits::default());
        let failed = |error: turner_web::CallError| format!("{name}: {}", error.message);
        let call =
            |session: &mut Session, name: &str, args| session.call(name, &args, Vec::new()).map_err(failed);
        call(&mut session, "set_text", serde_json::json!({ "text": text }))?;
        while !is_settled(&mut session) {
            session.step();
        }
        let write = |extension: &str, bytes: &[u8]| {
            let path = folder.join(format!("{name}.{extension}"));
            std::fs::write(&path, bytes).map_err(|e| format!("{}: {e}", path.display()))
        };
        write("toml", text.as_bytes())?;
        for format in ["png", "exr"] {
            let reply = call(&mut session, "save", serde_json::json!({ "format": format }))?;
            write(format, &reply.bytes)?;
        }
    }
    Ok(())
}

/// The text of the page has no files beside it.
const ROOF: &str = r#"{ type = "model", file = "roof.obj","#;
const BALL: &str = r#"{ type = "box", min = [-1, 0, -1], max = [1, 0.8, 1],"#;

fn is_settled(session: &mut Session) -> bool {
    session.events().iter().any(|event| matches!(event, Event::Status(status) if status["settled"] == true))
}
