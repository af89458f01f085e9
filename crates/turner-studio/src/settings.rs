//! What the program remembers of its user: recent files, theme, size.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// Files that are remembered.
const MOST_RECENT: usize = 12;

/// Remembered settings. Unknown ones in the file are left out, missing ones have their default.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(default)]
pub struct Settings {
    /// Files opened last, the newest first.
    pub recent: Vec<PathBuf>,
    /// "dark", "light" or "system".
    pub theme: Theme,
    /// Size of everything, 1 is normal.
    pub zoom: f32,
    /// Threads for rendering; 0 uses all.
    pub threads: usize,
}

/// Light or dark.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Theme {
    /// Dark.
    Dark,
    /// Light.
    Light,
    /// As the system asks.
    System,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { recent: Vec::new(), theme: Theme::Dark, zoom: 1.0, threads: 0 }
    }
}

/// The folder for settings and recovery: `$TURNER_STUDIO_HOME`, or the user's folder for configuration.
pub fn home() -> PathBuf {
    let of = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    if let Some(home) = of("TURNER_STUDIO_HOME") {
        return home;
    }
    let base = if cfg!(windows) {
        of("APPDATA")
    } else if cfg!(target_os = "macos") {
        of("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        of("XDG_CONFIG_HOME").or_else(|| of("HOME").map(|home| home.join(".config")))
    };
    base.unwrap_or_else(std::env::temp_dir).join("turner-studio")
}

impl Settings {
    /// Those of `home`; the defaults if there are none.
    pub fn load(home: &Path) -> Settings {
        let text = std::fs::read_to_string(home.join("settings.json")).unwrap_or_default();
        let mut settings: Settings = serde_json::from_str(&text).unwrap_or_default();
        settings.zoom = if settings.zoom.is_finite() { settings.zoom.clamp(0.5, 4.0) } else { 1.0 };
        settings
    }

    /// Writes them. A failure costs nothing but the memory of recent files.
    pub fn save(&self, home: &Path) {
        let _ = std::fs::create_dir_all(home);
        let file = turner_io::image::OutputFile::create(home.join("settings.json"));
        if let (Ok(file), Ok(text)) = (file, serde_json::to_string_pretty(self)) {
            let _ = file.commit(text.as_bytes());
        }
    }

    /// A file was opened.
    pub fn add_recent(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(MOST_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_survive_and_a_broken_file_is_no_error() {
        let home = tempfile::tempdir().unwrap();
        let mut settings = Settings::default();
        settings.add_recent(Path::new("/a.toml"));
        settings.add_recent(Path::new("/b.toml"));
        settings.add_recent(Path::new("/a.toml"));
        settings.save(home.path());
        let read = Settings::load(home.path());
        assert_eq!(read, settings);
        assert_eq!(read.recent.len(), 2);
        std::fs::write(home.path().join("settings.json"), "{\"zoom\": 1e9").unwrap();
        assert_eq!(Settings::load(home.path()), Settings::default());
    }
}
