//! The process of a job, and the thread that reads what it writes.

use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use turner::SceneDesc;

use super::spec::SCENE;
use super::{GRACE, Report, Spec, State, Wake};

/// The most text of standard error that is kept.
const MOST_TEXT: u64 = 16 << 10;

/// What a job's thread and the window share.
pub(super) struct Shared {
    inner: Mutex<Inner>,
    ended: Condvar,
    wake: Wake,
}

#[derive(Default)]
struct Inner {
    report: Report,
    /// The process until it is waited for: its number is not that of another one.
    child: Option<Child>,
    stop: bool,
}

impl Shared {
    pub(super) fn new(wake: Wake) -> Shared {
        Shared { inner: Mutex::default(), ended: Condvar::new(), wake }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn report(&self) -> Report {
        self.lock().report.clone()
    }

    fn change(&self, change: impl FnOnce(&mut Report)) {
        change(&mut self.lock().report);
        (self.wake)();
    }

    /// Lets a job that has ended wait for its turn again.
    pub(super) fn wait_again(&self) {
        let mut inner = self.lock();
        if !inner.report.state.is_running() {
            *inner = Inner::default();
        }
    }

    /// Asks the process to end, and ends it if it does not. A job that waits is stopped at once.
    pub(super) fn stop(self: &Arc<Shared>) {
        let mut inner = self.lock();
        match inner.report.state {
            State::Waiting => inner.report.state = State::Stopped,
            State::Preparing | State::Rendering => {
                inner.report.state = State::Stopping;
                inner.stop = true;
                if let Some(child) = &mut inner.child {
                    ask_to_end(child);
                }
                let shared = Arc::clone(self);
                let kill = move || shared.kill_after(GRACE);
                let _ = std::thread::Builder::new().name("job's end".into()).spawn(kill);
            }
            _ => {}
        }
        drop(inner);
        (self.wake)();
    }

    fn kill_after(&self, grace: Duration) {
        let mut inner = self.wait_for_end(grace);
        if inner.stop
            && let Some(child) = &mut inner.child
        {
            let _ = child.kill();
        }
    }

    /// Waits until nothing runs, at most for some time.
    fn wait_for_end(&self, most: Duration) -> MutexGuard<'_, Inner> {
        let end = Instant::now() + most;
        let mut inner = self.lock();
        while inner.report.state.is_running() {
            let Some(left) = end.checked_duration_since(Instant::now()) else { break };
            inner = self.ended.wait_timeout(inner, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        inner
    }

    /// Waits for the end of a job that was stopped.
    pub(super) fn join(&self) {
        drop(self.wait_for_end(GRACE + Duration::from_secs(2)));
    }
}

/// Starts the job in a thread.
pub(super) fn start(
    shared: &Arc<Shared>,
    program: &(PathBuf, Vec<String>),
    folder: &Path,
    desc: &Arc<SceneDesc>,
    spec: &Spec,
) {
    shared.lock().report = Report { state: State::Preparing, ..Report::default() };
    let (of_thread, program, folder) = (Arc::clone(shared), program.clone(), folder.to_owned());
    let (desc, spec) = (Arc::clone(desc), spec.clone());
    let work = move || {
        let result = run(&of_thread, &program, &folder, &desc, &spec);
        let mut inner = of_thread.lock();
        inner.child = None;
        let stopped = inner.stop;
        let report = &mut inner.report;
        report.state = match result {
            Ok(()) => State::Done,
            Err(_) if stopped => State::Stopped,
            Err(text) => {
                report.error.get_or_insert(text);
                State::Failed
            }
        };
        drop(inner);
        of_thread.ended.notify_all();
        (of_thread.wake)();
    };
    if let Err(error) = std::thread::Builder::new().name("job".into()).spawn(work) {
        shared.change(|report| {
            (report.state, report.error) =
                (State::Failed, Some(format!("no thread can be started: {error}")));
        });
    }
}

/// Writes the scene, runs the process and reads its events. The error is for the user.
fn run(
    shared: &Shared,
    (program, before): &(PathBuf, Vec<String>),
    folder: &Path,
    desc: &SceneDesc,
    spec: &Spec,
) -> Result<(), String> {
    let scene = folder.join(SCENE);
    // A job that continues has its scene already.
    if !scene.is_file() {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let options = turner_io::convert::ConvertOptions { overwrite: true, ..Default::default() };
        turner_io::convert::to_toml(desc, &scene, &options).map_err(|e| e.message)?;
    }
    let args: Vec<OsString> = before.iter().map(OsString::from).chain(spec.args(folder)).collect();
    let mut child =
        spawn(program, &args, folder, spec.nice).map_err(|e| format!("{}: {e}", program.display()))?;
    let (out, err) = (child.stdout.take(), child.stderr.take());
    {
        let mut inner = shared.lock();
        if inner.stop {
            let _ = child.kill();
        }
        inner.child = Some(child);
    }
    let said = std::thread::spawn(move || {
        let mut text = Vec::new();
        if let Some(mut err) = err {
            let _ = err.by_ref().take(MOST_TEXT).read_to_end(&mut text);
            // The rest, so that the process is not held up.
            let _ = std::io::copy(&mut err, &mut std::io::sink());
        }
        String::from_utf8_lossy(&text).trim().to_owned()
    });
    for line in out.into_iter().flat_map(|out| BufReader::new(out).lines().map_while(Result::ok)) {
        shared.change(|report| report.hear(&line));
    }
    let said = said.join().unwrap_or_default();
    let status = loop {
        let status = match &mut shared.lock().child {
            Some(child) => child.try_wait().map_err(|e| e.to_string())?,
            None => None,
        };
        if let Some(status) = status {
            break status;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    if status.success() {
        return Ok(());
    }
    Err(if said.is_empty() { format!("the render ended with {status}") } else { said })
}

fn spawn(program: &Path, args: &[OsString], folder: &Path, nice: bool) -> std::io::Result<Child> {
    let start = |mut command: Command| {
        command.args(args).current_dir(folder).stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()
    };
    if cfg!(unix) && nice {
        // `nice` becomes the program, so the process has the same number.
        let mut command = Command::new("nice");
        command.args(["-n", "10"]).arg(program);
        if let Ok(child) = start(command) {
            return Ok(child);
        }
    }
    start(Command::new(program))
}

/// A request to terminate: the process writes its picture and its checkpoint first.
#[cfg(unix)]
fn ask_to_end(child: &mut Child) {
    use rustix::process::{Pid, Signal, kill_process};
    let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    if pid.is_none_or(|pid| kill_process(pid, Signal::TERM).is_err()) {
        let _ = child.kill();
    }
}

/// There is no such request here: the last checkpoint stays.
#[cfg(not(unix))]
fn ask_to_end(child: &mut Child) {
    let _ = child.kill();
}
