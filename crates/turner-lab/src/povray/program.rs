//! Runs POV-Ray and reads the time it reports.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use turner::schema::{ErrorCode, SceneError};
use turner_cli::failure::Failure;

/// POV-Ray and the scene that it renders.
pub(super) struct PovRay {
    program: PathBuf,
    scene: PathBuf,
}

impl PovRay {
    /// For the .pov file next to `scene`, if there is one.
    pub(super) fn for_scene(program: &Path, scene: &Path) -> Option<PovRay> {
        // POV-Ray runs in another folder, so the path must be absolute.
        let scene = std::fs::canonicalize(scene.with_extension("pov")).ok()?;
        Some(PovRay { program: program.to_owned(), scene })
    }

    /// The tracing time that POV-Ray reports, in seconds, without anti-aliasing.
    pub(super) fn trace(&self, width: u32, height: u32, threads: usize) -> Result<f64, Failure> {
        self.render(width, height, threads, &["-A"]).map(|(seconds, _)| seconds)
    }

    /// The tracing time that POV-Ray reports, in seconds, with these arguments for anti-aliasing; and its image as PNG.
    /// The temporary folder is removed.
    pub(super) fn render(
        &self,
        width: u32,
        height: u32,
        threads: usize,
        antialias: &[&str],
    ) -> Result<(f64, Vec<u8>), Failure> {
        let failed = |message: String, help: &str| {
            Failure::new(SceneError::new(ErrorCode::File, message).help(help.to_owned()))
        };
        let program = self.program.display();
        let folder = tempfile::tempdir().map_err(|e| {
            failed(format!("cannot create a temporary folder: {e}"), "set TMPDIR to a writable folder")
        })?;
        // POV-Ray finds files next to the scene through the library path.
        let library = self.scene.parent().unwrap_or(Path::new("."));
        let output = Command::new(&self.program)
            .current_dir(folder.path())
            .arg(format!("+I{}", self.scene.display()))
            .arg(format!("+O{}", folder.path().join("picture.png").display()))
            .arg(format!("+L{}", library.display()))
            .args([format!("+W{width}"), format!("+H{height}"), format!("+WT{threads}")])
            .args(antialias)
            .args(["-D", "File_Gamma=1.0"])
            .stdin(Stdio::null())
            .output()
            .map_err(|e| {
                failed(format!("{program} cannot be run: {e}"), "name the program: --program PATH")
            })?;
        // POV-Ray writes its report to standard error.
        let report =
            String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
        if !output.status.success() {
            let last =
                report.lines().rfind(|l| l.contains("rror")).unwrap_or("no error message").trim().to_owned();
            let scene = self.scene.display();
            return Err(failed(
                format!("{program} failed on {scene}: {last}"),
                "run POV-Ray manually to see more",
            ));
        }
        let works = "this works with POV-Ray 3.7";
        let seconds =
            trace_time(&report).ok_or_else(|| failed(format!("{program} printed no `Trace Time`"), works))?;
        let picture = std::fs::read(folder.path().join("picture.png"))
            .map_err(|e| failed(format!("{program} wrote no image: {e}"), works))?;
        Ok((seconds, picture))
    }
}

/// The seconds in `Trace Time:  0 hours  1 minutes  2 seconds (62.345 seconds)`.
fn trace_time(report: &str) -> Option<f64> {
    let line = report.lines().rfind(|l| l.trim_start().starts_with("Trace Time:"))?;
    let (_, exact) = line.split_once('(')?;
    exact.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_trace_time_is_found() {
        let report = "Render Time:\n  Photon Time:      No photons\n  \
                      Trace Time:       0 hours  0 minutes  0 seconds (0.043 seconds)\n     using 1 thread(s)";
        assert_eq!(trace_time(report), Some(0.043));
        assert_eq!(trace_time("Trace Time:  a moment"), None);
    }
}
