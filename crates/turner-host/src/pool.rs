//! Threads for WebAssembly: tasks for workers that the page has started.
//!
//! ```text
//! scope.spawn(f) ──► queue ──► a worker in `serve` runs it
//!                      └─────► or whoever joins it first, if no worker has begun it
//! ```
//!
//! A joined task that no worker has begun runs in the thread that joins it. So nothing waits for workers that are busy or
//! do not exist, and tasks may start tasks.

use std::any::Any;
use std::collections::VecDeque;
use std::io;
use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

type Work = Box<dyn FnOnce() + Send>;
type Outcome<T> = Result<T, Box<dyn Any + Send>>;
/// Where a task leaves its result.
type Place<T> = Arc<Mutex<Option<Outcome<T>>>>;

/// Tasks that no worker has begun.
static QUEUE: Mutex<Queue> = Mutex::new(Queue { tasks: VecDeque::new(), workers: 0 });
static ARRIVED: Condvar = Condvar::new();

struct Queue {
    tasks: VecDeque<Arc<Task>>,
    workers: usize,
}

enum State {
    Waits(Work),
    Runs,
    Done,
}

struct Task {
    state: Mutex<State>,
    done: Condvar,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Task {
    /// Runs it, unless it has begun.
    fn run(&self) {
        let mut state = lock(&self.state);
        if !matches!(*state, State::Waits(_)) {
            return;
        }
        let State::Waits(work) = std::mem::replace(&mut *state, State::Runs) else { return };
        drop(state);
        work();
        *lock(&self.state) = State::Done;
        self.done.notify_all();
    }

    /// Runs it here if nobody has begun it, and waits until it is done.
    fn finish(&self) {
        self.run();
        let mut state = lock(&self.state);
        while !matches!(*state, State::Done) {
            state = self.done.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Number of threads that run at the same time: the workers and the caller.
pub fn available() -> usize {
    lock(&QUEUE).workers + 1
}

/// Runs tasks in the calling thread until the page ends it.
pub fn serve() -> ! {
    let mut queue = lock(&QUEUE);
    queue.workers += 1;
    loop {
        while let Some(task) = queue.tasks.pop_front() {
            drop(queue);
            task.run();
            drop(task);
            queue = lock(&QUEUE);
        }
        queue = ARRIVED.wait(queue).unwrap_or_else(PoisonError::into_inner);
    }
}

/// Queues a task.
fn queue(work: Work) -> Arc<Task> {
    let task = Arc::new(Task { state: Mutex::new(State::Waits(work)), done: Condvar::new() });
    lock(&QUEUE).tasks.push_back(Arc::clone(&task));
    ARRIVED.notify_one();
    task
}

/// A task and the place of its result.
fn with_result<'a, T: Send + 'a>(
    work: impl FnOnce() -> T + Send + 'a,
) -> (Box<dyn FnOnce() + Send + 'a>, Place<T>) {
    let result = Arc::new(Mutex::new(None));
    let place = Arc::clone(&result);
    let work = move || *lock(&place) = Some(catch_unwind(AssertUnwindSafe(work)));
    (Box::new(work), result)
}

/// See [`std::thread::Scope`].
pub struct Scope<'scope, 'env: 'scope> {
    tasks: Mutex<Vec<Arc<Task>>>,
    scope: PhantomData<&'scope mut &'scope ()>,
    env: PhantomData<&'env mut &'env ()>,
}

/// See [`std::thread::ScopedJoinHandle`].
pub struct ScopedJoinHandle<'scope, T> {
    task: Arc<Task>,
    result: Place<T>,
    scope: PhantomData<&'scope ()>,
}

/// See [`std::thread::scope`].
pub fn scope<'env, T>(f: impl for<'scope> FnOnce(&'scope Scope<'scope, 'env>) -> T) -> T {
    let scope = Scope { tasks: Mutex::default(), scope: PhantomData, env: PhantomData };
    let made = catch_unwind(AssertUnwindSafe(|| f(&scope)));
    // What the tasks borrow lives until here: none may outlast the scope, whatever `f` did.
    loop {
        let Some(task) = lock(&scope.tasks).pop() else { break };
        task.finish();
    }
    made.unwrap_or_else(|panic| resume_unwind(panic))
}

impl<'scope> Scope<'scope, '_> {
    /// See [`std::thread::Scope::spawn`].
    pub fn spawn<T: Send + 'scope>(
        &'scope self,
        work: impl FnOnce() -> T + Send + 'scope,
    ) -> ScopedJoinHandle<'scope, T> {
        let (work, result) = with_result(work);
        // SAFETY: only the lifetime changes. `scope` returns after every task has run and its closure is gone, so the
        // closure does not outlive what it borrows.
        let work = unsafe { std::mem::transmute::<Box<dyn FnOnce() + Send + 'scope>, Work>(work) };
        let task = queue(work);
        lock(&self.tasks).push(Arc::clone(&task));
        ScopedJoinHandle { task, result, scope: PhantomData }
    }
}

impl<T> ScopedJoinHandle<'_, T> {
    /// See [`std::thread::ScopedJoinHandle::join`].
    pub fn join(self) -> Outcome<T> {
        self.task.finish();
        lock(&self.result).take().expect("a finished task has left its result")
    }
}

/// See [`std::thread::Builder`]. Without workers, `spawn` is an error: nobody would join the task and so run it.
#[derive(Debug, Default)]
pub struct Builder(());

/// See [`std::thread::JoinHandle`].
pub struct JoinHandle<T> {
    task: Arc<Task>,
    result: Place<T>,
}

impl<T> JoinHandle<T> {
    /// See [`std::thread::JoinHandle::join`].
    pub fn join(self) -> Outcome<T> {
        self.task.finish();
        lock(&self.result).take().expect("a finished task has left its result")
    }
}

impl Builder {
    /// See [`std::thread::Builder::new`].
    pub fn new() -> Builder {
        Builder(())
    }

    /// Workers have no names.
    #[must_use]
    pub fn name(self, _name: String) -> Builder {
        self
    }

    /// See [`std::thread::Builder::spawn`].
    pub fn spawn<T: Send + 'static>(
        self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> io::Result<JoinHandle<T>> {
        if lock(&QUEUE).workers == 0 {
            return Err(io::Error::new(io::ErrorKind::Unsupported, "the page has no workers"));
        }
        let (work, result) = with_result(work);
        Ok(JoinHandle { task: queue(work), result })
    }

    /// See [`std::thread::Builder::spawn_scoped`].
    pub fn spawn_scoped<'scope, T: Send + 'scope>(
        self,
        scope: &'scope Scope<'scope, '_>,
        work: impl FnOnce() -> T + Send + 'scope,
    ) -> io::Result<ScopedJoinHandle<'scope, T>> {
        Ok(scope.spawn(work))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// The sum of squares below `n`, in many nested tasks.
    fn sum(n: u64) -> u64 {
        if n < 4 {
            return (0..n).map(|i| i * i).sum();
        }
        scope(|scope| {
            let halves = [0, 1].map(|odd| scope.spawn(move || scope_of_odd(n, odd)));
            halves.into_iter().map(|half| half.join().unwrap()).sum()
        })
    }

    fn scope_of_odd(n: u64, odd: u64) -> u64 {
        scope(|scope| {
            let each: Vec<_> = (0..n).filter(|i| i % 2 == odd).map(|i| scope.spawn(move || i * i)).collect();
            each.into_iter().map(|square| square.join().unwrap()).sum()
        })
    }

    #[test]
    fn tasks_run_without_workers_with_workers_and_nested() {
        assert_eq!(sum(100), 328_350);
        let before = available();
        for _ in 0..3 {
            std::thread::spawn(|| serve());
        }
        while available() < before + 3 {
            std::thread::yield_now();
        }
        (0..200).for_each(|_| assert_eq!(sum(100), 328_350));
    }

    #[test]
    fn a_scope_ends_after_its_tasks_and_borrows_what_it_is_given() {
        let (mut parts, count) = ([1, 2, 3], AtomicUsize::new(0));
        scope(|scope| {
            for part in &mut parts {
                scope.spawn(|| {
                    *part *= 10;
                    count.fetch_add(1, Ordering::Relaxed);
                });
            }
        });
        assert_eq!((parts, count.into_inner()), ([10, 20, 30], 3));
    }

    #[test]
    fn a_panic_is_the_result_of_join() {
        let joined = scope(|scope| scope.spawn(|| panic!("on purpose")).join());
        assert!(joined.is_err());
        let ended = AtomicUsize::new(0);
        let outer = catch_unwind(AssertUnwindSafe(|| {
            scope(|scope| {
                scope.spawn(|| ended.fetch_add(1, Ordering::Relaxed));
                panic!("on purpose");
            })
        }));
        assert!(outer.is_err() && ended.into_inner() == 1);
    }
}
