//! What all importers of foreign formats have in common.

/// How to import a file of another program.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// Seconds into the animation.
    pub time: f64,
    /// Which animation: its name or number; the first unless given.
    pub animation: Option<String>,
    /// Which of the file's variants of materials: its name or number.
    pub variant: Option<String>,
    /// Which of the file's scenes: its name or number; the file's own choice unless given.
    pub scene: Option<String>,
    /// Names of nodes (or groups) that are wanted, with all that hangs on them; all if empty.
    pub nodes: Vec<String>,
    /// Pictures with a longer side are halved until they fit.
    pub max_texture_size: Option<u32>,
    /// Threads for decoding; 0 takes all there are. The result is the same for any number.
    pub threads: usize,
}

impl Default for ImportOptions {
    fn default() -> ImportOptions {
        ImportOptions {
            time: 0.0,
            animation: None,
            variant: None,
            scene: None,
            nodes: Vec::new(),
            max_texture_size: None,
            threads: 0,
        }
    }
}
