//! Questions to the terminal: its size, and whether it shows sixels.

/// Columns and rows of the terminal of standard output.
pub(super) fn size() -> Option<(u32, u32)> {
    #[cfg(unix)]
    if let Ok(size) = rustix::termios::tcgetwinsize(std::io::stdout())
        && size.ws_col > 0
        && size.ws_row > 0
    {
        return Some((size.ws_col.into(), size.ws_row.into()));
    }
    None
}

/// Whether the terminal says that it shows sixels. It is asked only if it can answer: this process is in the foreground
/// and nothing was typed ahead.
pub(super) fn speaks_sixel() -> bool {
    #[cfg(unix)]
    {
        terminal::primary_attributes().is_some_and(|answer| has_sixel(&answer))
    }
    #[cfg(not(unix))]
    {
        false
    }
}

/// Whether the answer to a request for primary device attributes, `ESC [ ? 62 ; 4 ; … c`, has the attribute 4.
#[cfg_attr(not(unix), expect(dead_code, reason = "the question is asked on Unix alone"))]
fn has_sixel(answer: &[u8]) -> bool {
    let text = String::from_utf8_lossy(answer);
    let attributes = text.split_once("\x1b[?").and_then(|(_, rest)| rest.split_once('c'));
    // The first number is the class of the terminal.
    attributes.is_some_and(|(list, _)| list.split(';').skip(1).any(|a| a == "4"))
}

#[cfg(unix)]
mod terminal {
    use std::fs::{File, OpenOptions};
    use std::io::{Read, Write};

    use rustix::io::ioctl_fionread;
    use rustix::process::getpgrp;
    use rustix::termios::{
        LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcgetpgrp, tcsetattr,
    };

    /// Longest answer.
    const MOST: usize = 256;

    /// Tenths of a second that a terminal gets for its answer.
    const PATIENCE: u8 = 2;

    /// A terminal in raw mode: it does not show what is typed, and does not wait for whole lines. Dropping this restores it.
    struct Quiet<'a> {
        tty: &'a File,
        before: Termios,
    }

    impl Drop for Quiet<'_> {
        fn drop(&mut self) {
            // Flush: the rest of a late answer is not for the shell.
            let _ = tcsetattr(self.tty, OptionalActions::Flush, &self.before);
        }
    }

    /// The answer to a request for primary device attributes.
    pub(super) fn primary_attributes() -> Option<Vec<u8>> {
        let tty = OpenOptions::new().read(true).write(true).open("/dev/tty").ok()?;
        if tcgetpgrp(&tty).ok()? != getpgrp() || ioctl_fionread(&tty).ok()? != 0 {
            return None;
        }
        let before = tcgetattr(&tty).ok()?;
        let mut modes = before.clone();
        modes.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO);
        // A read ends when a byte is there, or after a pause.
        modes.special_codes[SpecialCodeIndex::VMIN] = 0;
        modes.special_codes[SpecialCodeIndex::VTIME] = PATIENCE;
        let _quiet = Quiet { tty: &tty, before };
        tcsetattr(&tty, OptionalActions::Now, &modes).ok()?;
        ask(&tty)
    }

    fn ask(mut tty: &File) -> Option<Vec<u8>> {
        tty.write_all(b"\x1b[c").ok()?;
        let mut answer = Vec::new();
        let mut bytes = [0; 32];
        while answer.len() < MOST && !answer.contains(&b'c') {
            match tty.read(&mut bytes) {
                Ok(n) if n > 0 => answer.extend_from_slice(&bytes[..n]),
                _ => break,
            }
        }
        Some(answer)
    }
}

#[cfg(test)]
mod tests {
    use super::has_sixel;

    #[test]
    fn answers_are_understood() {
        assert!(has_sixel(b"\x1b[?62;4;22c"));
        assert!(has_sixel(b"\x1b[?65;1;4c"));
        assert!(!has_sixel(b"\x1b[?64;1;2;6;22c"));
        // A VT132 is of class 4.
        assert!(!has_sixel(b"\x1b[?4;6c"));
        assert!(!has_sixel(b"\x1b[?62;4") && !has_sixel(b"") && !has_sixel(b"4c"));
    }
}
