//! What the engine's thread and its caller share: the newest order, the newest frame, the status. Locks are held only
//! while a pointer is exchanged.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::{EngineError, Frame, Order, Stand, Status};

/// See the module.
pub(super) struct Board {
    mail: Mutex<Mail>,
    arrived: Condvar,
    /// The number of the newest order.
    newest: AtomicU64,
    /// Stops the pass that runs.
    pub(super) stop: Arc<AtomicBool>,
    /// Stops everything: the front end is gone.
    pub(super) closed: AtomicBool,
    /// Set once the film that is being rendered is replaced.
    film: Mutex<Arc<AtomicBool>>,
    frame: Mutex<Option<Arc<Frame>>>,
    status: Mutex<Status>,
    wake: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct Mail {
    order: Option<(u64, Order)>,
}

/// What a thread that panicked left is complete: only whole values are exchanged.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Board {
    pub(super) fn new(wake: Box<dyn Fn() + Send + Sync>) -> Board {
        Board {
            mail: Mutex::default(),
            arrived: Condvar::new(),
            newest: AtomicU64::new(0),
            stop: Arc::default(),
            closed: AtomicBool::new(false),
            film: Mutex::default(),
            frame: Mutex::default(),
            status: Mutex::default(),
            wake,
        }
    }

    pub(super) fn post(&self, order: Order) -> u64 {
        let mut mail = lock(&self.mail);
        let number = self.newest.load(Ordering::SeqCst) + 1;
        mail.order = Some((number, order));
        // In this order: a worker that has just cleared `stop` then sees the new number.
        self.newest.store(number, Ordering::SeqCst);
        self.stop.store(true, Ordering::SeqCst);
        // After the number: a worker that still reports on an older order does not set it again.
        lock(&self.status).settled = false;
        self.arrived.notify_all();
        number
    }

    pub(super) fn is_newest(&self, number: u64) -> bool {
        self.newest.load(Ordering::SeqCst) == number
    }

    pub(super) fn close(&self) {
        self.closed.store(true, Ordering::SeqCst);
        self.stop.store(true, Ordering::SeqCst);
        lock(&self.film).store(true, Ordering::SeqCst);
        // With the lock, so that a worker that is about to wait does not miss it.
        let _mail = lock(&self.mail);
        self.arrived.notify_all();
    }

    pub(super) fn is_closed(&self) -> bool {
        self.closed.load(Ordering::SeqCst)
    }

    /// Takes the newest order; waits for one at most `patience`, without end for `None`.
    pub(super) fn take(&self, patience: Option<Duration>) -> Option<(u64, Order)> {
        let mut mail = lock(&self.mail);
        loop {
            if self.is_closed() {
                return None;
            }
            if let Some(order) = mail.order.take() {
                return Some(order);
            }
            match patience {
                None => mail = self.arrived.wait(mail).unwrap_or_else(PoisonError::into_inner),
                Some(time) if time.is_zero() => return None,
                Some(time) => {
                    let waited = self.arrived.wait_timeout(mail, time);
                    let (held, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
                    mail = held;
                    if timeout.timed_out() {
                        return mail.order.take();
                    }
                }
            }
        }
    }

    /// Lets an order wait again, unless a newer one does.
    pub(super) fn put_back(&self, number: u64, order: Order) {
        lock(&self.mail).order.get_or_insert((number, order));
    }

    /// Whether an order waits.
    pub(super) fn has_mail(&self) -> bool {
        lock(&self.mail).order.is_some()
    }

    /// Clears the stop of the last pass. Returns whether work on order `number` should continue.
    pub(super) fn go_on(&self, number: u64) -> bool {
        self.stop.store(false, Ordering::SeqCst);
        !self.is_closed() && self.is_newest(number)
    }

    pub(super) fn show(&self, frame: Frame) {
        *lock(&self.frame) = Some(Arc::new(frame));
        (self.wake)();
    }

    /// Marks the film as replaced, by another film or another picture of it: threads that denoise it stop.
    pub(super) fn begin_film(&self) {
        let _frame = lock(&self.frame);
        std::mem::take(&mut *lock(&self.film)).store(true, Ordering::SeqCst);
    }

    /// The flag that is set once the film is replaced.
    pub(super) fn film(&self) -> Arc<AtomicBool> {
        Arc::clone(&lock(&self.film))
    }

    /// Shows a frame of a film, unless it is replaced.
    pub(super) fn show_of_film(&self, is_replaced: &AtomicBool, frame: Frame) {
        let mut shown = lock(&self.frame);
        if !is_replaced.load(Ordering::SeqCst) && !self.is_closed() {
            let order = self.newest.load(Ordering::SeqCst);
            *shown = Some(Arc::new(Frame { order, ..frame }));
            drop(shown);
            (self.wake)();
        }
    }

    /// The shown frame answers a later order, too, if it shows the same.
    pub(super) fn answer(&self, number: u64, stand: &Arc<Stand>) {
        let mut shown = lock(&self.frame);
        if let Some(frame) = shown.as_ref().filter(|frame| Arc::ptr_eq(&frame.stand, stand)) {
            *shown = Some(Arc::new(Frame { order: number, ..Frame::clone(frame) }));
        }
    }

    pub(super) fn frame(&self) -> Option<Arc<Frame>> {
        lock(&self.frame).clone()
    }

    pub(super) fn status(&self) -> Status {
        lock(&self.status).clone()
    }

    pub(super) fn say(&self, change: impl FnOnce(&mut Status)) {
        let mut status = lock(&self.status);
        let before = status.doing;
        change(&mut status);
        let is_new = status.doing != before || status.settled || status.error.is_some();
        drop(status);
        // Numbers alone are shown with the next frame.
        if is_new {
            (self.wake)();
        }
    }

    pub(super) fn fail(&self, message: String, help: Option<String>, is_fault: bool) {
        self.say(|status| {
            status.doing = "";
            status.error = Some(EngineError { message, help, is_fault });
        });
    }
}
