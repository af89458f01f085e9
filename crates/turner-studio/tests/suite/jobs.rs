//! Renders to files by processes of the program.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use turner::SceneDesc;
use turner_live::document::{Document, STARTS};
use turner_studio::jobs::{End, Queue, Report, Sequence, Spec, State};

/// Time for what takes seconds on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

pub(crate) fn queue(home: &Path) -> Queue {
    Queue::with_program(env!("CARGO_BIN_EXE_turner-studio").into(), home, || {})
}

/// A small scene of the gallery.
fn scene(samples: u32) -> Arc<SceneDesc> {
    let start = STARTS.iter().find(|start| start.name == "Cornell box").unwrap();
    let mut desc = SceneDesc::clone(Document::start(start).unwrap().desc());
    (desc.film.width, desc.film.height, desc.film.samples) = (48, 32, samples);
    Arc::new(desc)
}

/// Polls until the job is as wanted.
#[track_caller]
fn until(queue: &mut Queue, id: u64, what: impl Fn(&Report) -> bool) -> Report {
    let start = Instant::now();
    loop {
        queue.poll();
        let report = queue.jobs().iter().find(|job| job.id == id).unwrap().report();
        if what(&report) {
            return report;
        }
        assert!(start.elapsed() < PATIENCE, "{report:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn spec(folder: &Path, name: &str) -> Spec {
    Spec::new(folder.join(name))
}

fn picture(path: &Path) -> turner::image::Image {
    let bytes = std::fs::read(path).unwrap();
    turner_io::image::decode(&bytes, "picture", &Default::default()).unwrap()
}

#[test]
fn jobs_run_one_after_another_and_leave_only_their_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let home = tempfile::tempdir().unwrap();
    let mut queue = queue(home.path());
    let first =
        queue.add(scene(4), "box".into(), Spec { size: Some([24, 16]), ..spec(folder.path(), "a.png") });
    let second = queue.add(scene(4), "box".into(), spec(folder.path(), "b.exr"));
    queue.poll();
    assert!(queue.is_running() && queue.pauses_view());
    assert_eq!(queue.jobs()[1].report().state, State::Waiting);
    let report = until(&mut queue, second, |report| report.state == State::Done);
    assert_eq!(report.fraction(1), 1.0);
    assert!(report.written.unwrap().ends_with("b.exr"));
    assert_eq!(queue.jobs()[0].id, first);
    assert_eq!(queue.jobs()[0].report().state, State::Done, "{:?}", queue.jobs()[0].report());
    let (a, b) = (picture(&folder.path().join("a.png")), picture(&folder.path().join("b.exr")));
    assert_eq!(([a.width, a.height], [b.width, b.height]), ([24, 16], [48, 32]));
    queue.poll();
    assert!(!queue.is_busy() && !queue.pauses_view());
    drop(queue);
    assert_eq!(std::fs::read_dir(home.path()).unwrap().count(), 0, "the queue's files are removed");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_job_renders_the_scene_as_it_was_queued_like_the_offline_renderer() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = queue(folder.path());
    let desc = scene(4);
    let id = queue.add(Arc::clone(&desc), "box".into(), spec(folder.path(), "a.png"));
    until(&mut queue, id, |report| report.state == State::Done);
    let prepared = desc.prepare(&Default::default()).unwrap();
    let mut renderer = turner::Renderer::new(prepared).unwrap();
    let never = std::sync::atomic::AtomicBool::new(false);
    renderer.pass(u32::MAX, &turner::PassOptions { threads: 0, cancel: &never, progress: None }).unwrap();
    let expected = renderer.develop();
    let found = picture(&folder.path().join("a.png"));
    let turner::image::Pixels::U8(bytes) = &found.pixels else { panic!("{:?}", found.channels) };
    let expected: Vec<u8> =
        expected.display.iter().flat_map(|p| p[..found.channels as usize].to_vec()).collect();
    assert!(*bytes == expected, "the picture has the bytes of the library's");
}

#[cfg(unix)]
#[test]
fn a_stopped_job_shows_its_checkpoint_and_goes_on_from_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = queue(folder.path());
    let end = End::Samples(1 << 20);
    let id = queue.add(scene(4), "box".into(), Spec { end, ..spec(folder.path(), "a.png") });
    until(&mut queue, id, |report| report.state == State::Rendering && report.samples >= 2.0);
    queue.stop(id);
    let report = until(&mut queue, id, |report| !report.state.is_running());
    assert_eq!(report.state, State::Stopped, "{report:?}");
    assert!(folder.path().join("a.png").is_file(), "the picture so far");
    assert!(queue.jobs()[0].checkpoint().is_some());
    queue.peek(id);
    let start = Instant::now();
    while queue.jobs()[0].peek().is_some_and(|peek| peek.is_reading()) {
        assert!(start.elapsed() < PATIENCE);
        queue.poll();
        std::thread::sleep(Duration::from_millis(5));
    }
    let peek = queue.jobs()[0].peek().unwrap();
    let (shown, samples) = peek.picture.as_ref().unwrap_or_else(|| panic!("{:?}", peek.error));
    assert_eq!((shown.width, shown.height, shown.missing), (48, 32, 0));
    assert!(*samples >= 2.0, "{samples}");
    let held = *samples;
    queue.resume(id);
    let report = until(&mut queue, id, |report| report.state == State::Rendering && report.samples > 0.0);
    assert!(report.samples >= held.floor(), "continues from {held}: {report:?}");
    queue.stop(id);
    until(&mut queue, id, |report| report.state == State::Stopped);
    queue.remove(id);
    assert!(queue.jobs().is_empty());
}

#[test]
fn a_turntable_has_numbered_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = queue(folder.path());
    let sequence = Sequence::Turntable(3);
    let id = queue.add(scene(1), "box".into(), Spec { sequence, ..spec(folder.path(), "turn_##.png") });
    let report = until(&mut queue, id, |report| !report.state.is_running() && report.state != State::Waiting);
    assert_eq!((report.state, report.picture), (State::Done, 3), "{report:?}");
    assert!((0..3).all(|i| folder.path().join(format!("turn_{i:02}.png")).is_file()));
}

#[test]
fn a_failed_job_says_why_and_the_next_one_runs() {
    let folder = tempfile::tempdir().unwrap();
    let mut queue = queue(folder.path());
    let failed = queue.add(scene(1), "box".into(), spec(folder.path(), "a.xyz"));
    let next = queue.add(scene(1), "box".into(), spec(folder.path(), "b.png"));
    let last = queue.add(scene(1), "box".into(), spec(folder.path(), "c.png"));
    queue.shift(last, -1);
    assert_eq!(queue.jobs().iter().map(|job| job.id).collect::<Vec<_>>(), [failed, last, next]);
    queue.stop(last);
    assert_eq!(queue.jobs()[1].report().state, State::Stopped, "a job that waits is stopped at once");
    let report = until(&mut queue, failed, |report| report.state == State::Failed);
    let error = report.error.unwrap();
    assert!(error.contains("xyz"), "{error}");
    until(&mut queue, next, |report| report.state == State::Done);
    assert!(!folder.path().join("c.png").exists());
}
