//! The engine's thread: takes the newest order, prepares it, draws previews, renders the film.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use turner_host::time::Instant;

use turner::integrator::Prepared;
use turner::prepare::{PrepareStep, Preparer, UpdateOptions};
use turner::schema::SceneError;

use super::board::Board;
use super::develop::{self, Shown};
use super::pace::Pace;
use super::settle::{Settle, Step};
use super::{Frame, Order, Stand};
use crate::engine::develop::Draft;

/// A user who moves something sends the next order within this time. Until then, no film is begun.
const STILL: Duration = Duration::from_millis(120);

/// A still picture has preview frames for this long, and at most this many. Then the film has the threads to itself.
const PREVIEW: Duration = Duration::from_millis(600);
const PREVIEWS: u32 = 3;

/// Time of a slice of the film.
const SLICE: Duration = Duration::from_millis(250);

/// What stays from order to order.
#[derive(Default)]
pub(super) struct Worker {
    /// How long the worker may wait for orders and work on one in a single turn.
    turns: Turns,
    preparer: Preparer,
    pace: Pace,
    draft: Draft,
    /// The last order that was prepared.
    last: Option<(Order, Arc<Stand>)>,
    film: Option<Settle>,
    /// Number of preview frames since the last order.
    frames: u32,
    /// Whether the last order still lacks a frame that shows it, such as one that a newer order of the same picture
    /// stopped. A pause does not wait with it.
    owes_frame: bool,
    /// The same for a picture of the film.
    owes_film: bool,
    since: Option<Instant>,
    /// When the last order was taken.
    arrived: Option<Instant>,
    /// The number of the order.
    number: u64,
}

/// How a worker's turns are paced.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Turns {
    /// In a thread of its own: it waits for orders.
    #[default]
    Waiting,
    /// In a caller's thread: a turn never waits. The time is that of a slice of the film.
    Short(Duration),
}

/// Serves orders until the board is closed. A panic costs the order, not the thread.
pub(super) fn run(board: &Arc<Board>) {
    let mut worker = Worker::default();
    while !board.is_closed() {
        worker.turn(board);
    }
}

/// What stops the work on an order. While something moves, orders arrive faster than pictures: each frame that was begun
/// is finished, and the newest order is the next.
fn stop<'a>(order: &Order, board: &'a Board) -> &'a AtomicBool {
    if order.moving { &board.closed } else { &board.stop }
}

/// Frees the memory of a film on another thread: for a large film it takes longer than a frame.
fn discard(film: Settle) {
    // Without a thread, it is freed here.
    let _ = turner_host::thread::Builder::new().name("free".into()).spawn(move || drop(film));
}

impl Worker {
    /// A worker whose turns never wait.
    pub(super) fn in_short_turns(slice: Duration) -> Worker {
        Worker { turns: Turns::Short(slice), ..Worker::default() }
    }

    /// One turn. A panic costs the order, not the worker.
    pub(super) fn turn(&mut self, board: &Arc<Board>) {
        let Err(panic) = catch_unwind(AssertUnwindSafe(|| self.serve(board))) else { return };
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        *self = Worker { turns: self.turns, ..Worker::default() };
        let help = "the last picture stays; save the scene, change it and try again".to_owned();
        board.fail(format!("the renderer stopped with a fault: {text}"), Some(help), true);
    }

    /// Whether there is nothing to do and nothing to hear until the next order.
    pub(super) fn rests(&self, board: &Board) -> bool {
        !board.has_mail() && self.is_idle() && !self.film.as_ref().is_some_and(Settle::is_being_denoised)
    }

    /// One turn: a new order, or the next piece of work on the last one.
    fn serve(&mut self, board: &Arc<Board>) {
        let waits = matches!(self.turns, Turns::Waiting);
        let patience = if self.is_idle() && waits { None } else { Some(Duration::ZERO) };
        if let Some((number, order)) = board.take(patience) {
            (self.number, self.arrived) = (number, Some(Instant::now()));
            self.begin(order, board);
            return;
        }
        if board.is_closed() {
            return;
        }
        let Some((order, stand)) = self.last.clone() else { return };
        if self.is_idle() {
            return;
        }
        if order.moving {
            // The film waits until nothing has moved for a while.
            if waits && let Some((number, next)) = board.take(Some(STILL)) {
                self.number = number;
                self.begin(next, board);
                return;
            }
            if !waits && self.arrived.is_some_and(|arrived| arrived.elapsed() < STILL) {
                return;
            }
            if let Some((order, _)) = &mut self.last {
                order.moving = false;
            }
            return;
        }
        self.work(&order, &stand, board);
    }

    fn is_idle(&self) -> bool {
        let Some((order, _)) = &self.last else { return true };
        let paused = order.paused && !order.moving && !self.owes_frame;
        (paused || self.film.as_ref().is_some_and(Settle::is_complete)) && !self.owes_film
    }

    /// Prepares an order and draws its first frame.
    fn begin(&mut self, order: Order, board: &Arc<Board>) {
        if let Some((last, stand)) = &mut self.last
            && order.has_film_of(last)
            && board.status().error.is_none()
        {
            // Another size, pause or mix: the film continues.
            let shown = order.look != last.look;
            // Only previews have the window's size.
            let is_preview = self.film.as_ref().is_none_or(|film| !film.is_covered());
            self.owes_frame |= is_preview && (shown || order.size != last.size);
            *last = order;
            let (order, stand) = (last.clone(), Arc::clone(stand));
            match &self.film {
                Some(film) if shown && film.is_covered() => {
                    // A finished picture that is being denoised would replace this one.
                    board.begin_film();
                    self.develop(board, &order, &stand, &board.closed);
                }
                _ => board.answer(self.number, &stand),
            }
            self.report(board);
            return;
        }
        let started = Instant::now();
        self.since = Some(started);
        board.say(|status| {
            (status.doing, status.seconds, status.left, status.settled) = ("preparing", 0.0, None, false);
        });
        let prepared = match self.prepare(&order, board) {
            Ok(Some(prepared)) => prepared,
            Ok(None) => {
                // Another thread may end a step without a newer order.
                if matches!(self.turns, Turns::Short(_)) && board.is_newest(self.number) {
                    board.put_back(self.number, order);
                }
                return;
            }
            Err(error) => {
                self.film = None;
                self.last = None;
                board.fail(error.message.clone(), error.help.clone(), false);
                return;
            }
        };
        let stand = Arc::new(Stand { prepared, desc: Arc::clone(&order.desc) });
        board.begin_film();
        let kept = self.film.take().and_then(|film| {
            film.continued(&stand.prepared, order.desc.film.denoise).map_err(|old| old.map(discard)).ok()
        });
        board.say(|status| (status.doing, status.error) = ("rendering", None));
        (self.frames, self.owes_frame, self.owes_film) = (0, true, false);
        let has_picture = kept.as_ref().is_some_and(Settle::is_covered);
        self.film = kept;
        self.last = Some((order.clone(), Arc::clone(&stand)));
        if has_picture {
            self.develop(board, &order, &stand, &board.closed);
        } else {
            self.preview(&order, &stand, board);
        }
        self.report(board);
    }

    /// Tells how far the film is.
    fn report(&self, board: &Board) {
        let film = self.film.as_ref();
        let settled = film.is_some_and(Settle::is_complete);
        let waits = settled || self.is_idle();
        board.say(|status| {
            if let (Some(film), Some((order, _))) = (film, &self.last) {
                (status.samples, status.left, status.seconds) = (film.samples(), film.left(), film.seconds());
                status.layers = film.layers(&order.look);
            }
            status.settled = settled && status.error.is_none() && board.is_newest(self.number);
            status.doing = if waits { "" } else { "rendering" };
        });
    }

    /// `None` if a newer order has stopped it.
    fn prepare(&mut self, order: &Order, board: &Board) -> Result<Option<Prepared>, SceneError> {
        let step = |step: PrepareStep| {
            let doing = match step {
                PrepareStep::Surfaces => "preparing textures and materials",
                PrepareStep::Lights => "preparing lights",
                PrepareStep::Objects => "placing objects",
                PrepareStep::Trees => "building BVHs",
                PrepareStep::LightTree => "building the light tree",
                PrepareStep::View => "preparing the view",
            };
            board.say(|status| status.doing = doing);
        };
        if !board.go_on(self.number) && !order.moving {
            return Ok(None);
        }
        let wanted =
            UpdateOptions { integrator: None, cancel: Some(stop(order, board)), progress: Some(&step) };
        let update = self.preparer.update_with(&order.prepared_desc(), &wanted)?;
        Ok(update.map(|update| update.prepared))
    }

    /// Draws one preview frame. Returns whether it was finished.
    fn preview(&mut self, order: &Order, stand: &Arc<Stand>, board: &Board) -> bool {
        if !board.go_on(self.number) && !order.moving {
            return false;
        }
        let film = &stand.prepared.view.film;
        let moving = order.moving || self.frames == 0;
        let size = self.pace.size([film.width, film.height], order.size, moving);
        let started = Instant::now();
        let ask = develop::Ask { size, moving, threads: order.threads, stop: stop(order, board) };
        let drawn = match self.draft.draw(&stand.prepared, &ask, order.look.display) {
            Ok(drawn) => drawn,
            Err(error) => {
                self.owes_frame = false;
                board.fail(error.message.clone(), error.help.clone(), false);
                return false;
            }
        };
        let Some(picture) = drawn else { return false };
        if moving {
            self.pace.learn(started.elapsed());
        }
        self.frames += 1;
        self.show(board, picture, Arc::clone(stand));
        true
    }

    fn elapsed(&self) -> Duration {
        self.since.map_or(Duration::ZERO, |since| since.elapsed())
    }

    /// The next piece of work on an order whose first frame is drawn.
    fn work(&mut self, order: &Order, stand: &Arc<Stand>, board: &Arc<Board>) {
        if self.owes_frame {
            self.preview(order, stand, board);
            self.report(board);
            return;
        }
        if self.owes_film {
            if board.go_on(self.number) {
                self.develop(board, order, stand, &board.stop);
                self.report(board);
            }
            return;
        }
        let previews = self.elapsed() < PREVIEW && self.frames < PREVIEWS;
        if self.film.is_none() && previews && self.draft.refines(&stand.prepared) {
            self.preview(order, stand, board);
            return;
        }
        if self.film.is_none() {
            match Settle::new(&stand.prepared, order.desc.film.denoise) {
                Ok(film) => self.film = Some(film),
                Err(error) => {
                    board.fail(error.message.clone(), error.help.clone(), false);
                    self.last = None;
                    return;
                }
            }
        }
        if !board.go_on(self.number) {
            return;
        }
        let slice = match self.turns {
            Turns::Waiting => SLICE,
            Turns::Short(slice) => slice,
        };
        let Some(film) = &mut self.film else { return };
        match film.step(&board.stop, order.threads, slice) {
            Ok(step) => {
                let settled = film.is_complete();
                self.report(board);
                // The end of a slice has set `stop`, too.
                match step {
                    Step::Show if board.go_on(self.number) => {
                        self.develop(board, order, stand, &board.stop);
                    }
                    Step::Show => self.owes_film = settled,
                    Step::More => {}
                }
            }
            Err(error) => {
                board.fail(error.message.clone(), error.help.clone(), false);
                self.last = None;
            }
        }
    }

    /// Shows the film, unless `cancel` is set meanwhile.
    fn develop(&mut self, board: &Arc<Board>, order: &Order, stand: &Arc<Stand>, cancel: &AtomicBool) {
        let Some(film) = &mut self.film else { return };
        let picture = film.picture(&order.look, order.threads, cancel);
        self.owes_film = picture.is_none();
        let Some(picture) = picture else { return };
        let (finish, held) = (film.finish(&order.look), film.held());
        self.show(board, picture, Arc::clone(stand));
        let Some(finish) = finish else { return };
        // With half of the threads: what the user does next is answered meanwhile.
        let all = turner_host::thread::available();
        let threads = (if order.threads == 0 { all } else { order.threads } / 2).max(1);
        let (board, stand, film) = (Arc::clone(board), Arc::clone(stand), board.film());
        let (since, order) = (self.since, self.number);
        let develop = move || {
            let Some(shown) = finish(threads, &film) else { return };
            let Shown { picture, transform, stage, noise, scale } = shown;
            let picture = Arc::new(picture);
            let after_ms = since.map_or(0.0, |since: Instant| since.elapsed().as_secs_f64() * 1e3);
            let frame = Frame { order, stage, picture, transform, stand, noise, scale, after_ms };
            board.show_of_film(&film, frame);
            drop(held);
        };
        if turner_host::thread::available() == 1 && matches!(self.turns, Turns::Short(_)) {
            develop();
            return;
        }
        // Without a thread, the picture of the fast denoiser stays.
        let _ = turner_host::thread::Builder::new().name("denoise".into()).spawn(develop);
    }

    fn show(&mut self, board: &Board, shown: Shown, stand: Arc<Stand>) {
        self.owes_frame = false;
        let Shown { picture, transform, stage, noise, scale } = shown;
        board.show(Frame {
            order: self.number,
            stage,
            picture: Arc::new(picture),
            transform,
            stand,
            noise,
            scale,
            after_ms: self.elapsed().as_secs_f64() * 1e3,
        });
    }
}
