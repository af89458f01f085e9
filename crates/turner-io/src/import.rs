//! How to import a model file.

/// What to take from a model file, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// The time at which animations are sampled, in seconds.
    pub time: f64,
    /// The animation to sample, by name; the first one unless given.
    pub animation: Option<String>,
    /// The material variant to show, by name.
    pub variant: Option<String>,
    /// The scene to show, by name; the file's default one unless given.
    pub scene: Option<String>,
    /// The nodes to take, by name, with all that hangs on them; empty takes all.
    pub nodes: Vec<String>,
    /// Pictures larger than this are halved until they are not.
    pub max_texture_size: Option<u32>,
    /// Threads for decoding pictures; 0 takes all there are. The result is the same for any number.
    pub threads: usize,
}

impl Default for ImportOptions {
    fn default() -> Self {
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
