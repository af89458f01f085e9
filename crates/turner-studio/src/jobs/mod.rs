//! Renders to files: a queue of jobs, each a process of its own that renders a copy of the scene as it was when the job
//! was queued.
//!
//! ```text
//!  Queue ── poll ──► one Job at a time ── thread ──► scene copied to the job's folder
//!    ▲                     ▲                          process: turner render … --json
//!    │                     └── Report ◄── events ─────┘
//!  panel "Render"
//! ```
//!
//! Nothing here waits: threads read what the processes write.

mod child;
mod picture;
mod report;
mod spec;

pub use picture::Peek;
pub use report::{Report, State};
pub use spec::{End, Sequence, Spec};

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use turner::SceneDesc;

use child::Shared;

/// Time that a render has to write its picture and its checkpoint after it was asked to stop. Then it is killed.
pub const GRACE: Duration = Duration::from_secs(8);

type Wake = Arc<dyn Fn() + Send + Sync>;

/// A render to a file.
pub struct Job {
    /// A number that no other job of this queue has.
    pub id: u64,
    /// The name of the scene.
    pub title: String,
    /// What is rendered.
    pub spec: Spec,
    /// The scene as it was when the job was queued.
    desc: Arc<SceneDesc>,
    folder: PathBuf,
    shared: Arc<Shared>,
    peek: Option<Peek>,
}

impl Job {
    /// How far it is.
    pub fn report(&self) -> Report {
        self.shared.report()
    }

    /// Its checkpoint, while there is one.
    pub fn checkpoint(&self) -> Option<PathBuf> {
        Some(self.folder.join(spec::CHECKPOINT)).filter(|file| self.spec.checkpoint && file.is_file())
    }

    /// The newest picture that was made from its checkpoint.
    pub fn peek(&self) -> Option<&Peek> {
        self.peek.as_ref()
    }
}

/// Jobs, one after another.
pub struct Queue {
    /// The program that has the command line in it, and the arguments before those of the command line.
    program: (PathBuf, Vec<String>),
    root: PathBuf,
    jobs: Vec<Job>,
    next: u64,
    wake: Wake,
    /// Whether the view is rendered while a job runs.
    pub with_view: bool,
    /// Whether no job is started: the user stopped the queue, or the program ends.
    pub held: bool,
}

/// Numbers the queues of this process.
static QUEUES: AtomicU64 = AtomicU64::new(0);

impl Queue {
    /// An empty queue whose files are in a folder below `home`. `wake` is called when something changes.
    pub fn new(home: &Path, wake: impl Fn() + Send + Sync + 'static) -> Queue {
        let program = std::env::current_exe().unwrap_or_else(|_| "turner-studio".into());
        Queue::with_program(program, home, wake)
    }

    /// A queue whose renders are processes of `program`, which is a `turner-studio`.
    pub fn with_program(program: PathBuf, home: &Path, wake: impl Fn() + Send + Sync + 'static) -> Queue {
        let number = QUEUES.fetch_add(1, Ordering::Relaxed);
        let root = home.join("jobs").join(format!("session-{}-{number}", std::process::id()));
        let program = (program, vec!["turner".to_owned()]);
        Queue {
            program,
            root,
            jobs: Vec::new(),
            next: 1,
            wake: Arc::new(wake),
            with_view: false,
            held: false,
        }
    }

    /// Appends a job. It begins when those before it have ended.
    pub fn add(&mut self, desc: Arc<SceneDesc>, title: String, spec: Spec) -> u64 {
        let id = self.next;
        self.next += 1;
        let shared = Arc::new(Shared::new(Arc::clone(&self.wake)));
        let folder = self.root.join(format!("job-{id}"));
        self.jobs.push(Job { id, title, spec, desc, folder, shared, peek: None });
        self.held = false;
        id
    }

    /// All jobs in their order.
    pub fn jobs(&self) -> &[Job] {
        &self.jobs
    }

    /// Starts the next job if none runs, and takes pictures that are ready. Never waits.
    pub fn poll(&mut self) {
        for job in &mut self.jobs {
            if let Some(peek) = &mut job.peek {
                peek.poll();
            }
            if job.report().state == State::Done && job.peek.as_ref().is_none_or(|peek| !peek.is_reading()) {
                let _ = std::fs::remove_dir_all(&job.folder);
            }
        }
        if self.held || self.is_running() {
            return;
        }
        if let Some(job) = self.jobs.iter().find(|job| job.report().state == State::Waiting) {
            child::start(&job.shared, &self.program, &job.folder, &job.desc, &job.spec);
        }
    }

    /// Whether a render runs.
    pub fn is_running(&self) -> bool {
        self.jobs.iter().any(|job| job.report().state.is_running())
    }

    /// Whether renders run or wait.
    pub fn is_busy(&self) -> bool {
        !self.held && self.jobs.iter().any(|job| job.report().state == State::Waiting) || self.is_running()
    }

    /// Whether the view waits for a job.
    pub fn pauses_view(&self) -> bool {
        !self.with_view && self.is_running()
    }

    /// The threads of the view, given those of the settings: half of them while a job runs.
    pub fn view_threads(&self, threads: usize) -> usize {
        if !self.is_running() {
            return threads;
        }
        let all = if threads == 0 { turner_cli::threads(0) } else { threads };
        (all / 2).max(1)
    }

    fn find(&self, id: u64) -> Option<usize> {
        self.jobs.iter().position(|job| job.id == id)
    }

    /// Stops a job. What it has rendered is kept: in its picture, and in its checkpoint if it has one.
    pub fn stop(&self, id: u64) {
        if let Some(i) = self.find(id) {
            self.jobs[i].shared.stop();
        }
    }

    /// Continues a job that was stopped or failed: from its checkpoint if it has one.
    pub fn resume(&mut self, id: u64) {
        if let Some(i) = self.find(id) {
            self.jobs[i].shared.wait_again();
            self.held = false;
        }
    }

    /// Removes a job that does not run.
    pub fn remove(&mut self, id: u64) {
        if let Some(i) = self.find(id).filter(|i| !self.jobs[*i].report().state.is_running()) {
            let job = self.jobs.remove(i);
            let _ = std::fs::remove_dir_all(job.folder);
        }
    }

    /// Moves a job to an earlier (-1) or a later (1) place.
    pub fn shift(&mut self, id: u64, by: isize) {
        let Some(from) = self.find(id) else { return };
        let to = from.saturating_add_signed(by).min(self.jobs.len() - 1);
        let job = self.jobs.remove(from);
        self.jobs.insert(to, job);
    }

    /// Starts making a picture of a job's checkpoint, in a thread.
    pub fn peek(&mut self, id: u64) {
        let Some(i) = self.find(id) else { return };
        let job = &mut self.jobs[i];
        if job.peek.as_ref().is_some_and(Peek::is_reading) {
            return;
        }
        if let Some(file) = job.checkpoint() {
            let last = job.peek.take();
            job.peek = Some(Peek::start(file, &job.desc, last, Arc::clone(&self.wake)));
        }
    }

    /// Stops the job that runs, and starts no other.
    pub fn hold(&mut self) {
        self.held = true;
        for job in &self.jobs {
            if job.report().state.is_running() {
                job.shared.stop();
            }
        }
    }
}

impl Drop for Queue {
    /// Renders that run write their pictures and end; then the files of all jobs are removed.
    fn drop(&mut self) {
        self.hold();
        for job in &self.jobs {
            job.shared.join();
        }
        let _ = std::fs::remove_dir_all(&self.root);
        // Only if no other session has jobs.
        if let Some(jobs) = self.root.parent() {
            let _ = std::fs::remove_dir(jobs);
        }
    }
}
