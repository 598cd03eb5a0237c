//! Tasks and timers of a page: its event loop runs them. The part of tokio that the recorder uses, under the same names.

use std::future::Future;
use std::marker::PhantomData;
use std::sync::Arc;
use std::time::Duration;

use js_sys::{Function, Promise};
use tokio::sync::Notify;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_time::Instant;

#[wasm_bindgen]
unsafe extern "C" {
    #[wasm_bindgen(js_name = setTimeout)]
    fn set_timeout(then: &Function, millis: f64);
}

/// Waits so long, or a little longer: browsers keep timers of 4 ms at the shortest.
pub async fn sleep(duration: Duration) {
    let millis = duration.as_secs_f64() * 1e3;
    let elapsed = Promise::new(&mut |resolve, _| set_timeout(&resolve, millis));
    // A timer does not fail.
    let _ = JsFuture::from(elapsed).await;
}

/// Waits until then.
pub async fn sleep_until(due: Instant) {
    sleep(due.saturating_duration_since(Instant::now())).await;
}

/// The time is over.
#[derive(Debug)]
pub struct Elapsed;

/// The output of `future`, if it ends in time.
pub async fn timeout<T>(duration: Duration, future: impl Future<Output = T>) -> Result<T, Elapsed> {
    tokio::select! {
        biased;
        value = future => Ok(value),
        () = sleep(duration) => Err(Elapsed),
    }
}

/// Treatment of ticks that nobody awaited in time.
#[derive(Debug, Clone, Copy)]
pub enum MissedTickBehavior {
    /// The next one comes a period after the late one.
    Delay,
}

/// Ticks, the first at once.
#[derive(Debug)]
pub struct Interval {
    period: Duration,
    next: Instant,
}

/// Ticks a period apart.
pub fn interval(period: Duration) -> Interval {
    Interval {
        period,
        next: Instant::now(),
    }
}

impl Interval {
    /// There is but one here.
    pub fn set_missed_tick_behavior(&mut self, _: MissedTickBehavior) {}

    /// The next tick. Safe to cancel.
    pub async fn tick(&mut self) {
        sleep_until(self.next).await;
        self.next = Instant::now() + self.period;
    }
}

/// A task that was begun, which gives a `T`. It continues where this is dropped, as tokio's.
#[derive(Debug)]
pub struct JoinHandle<T>(Arc<Notify>, PhantomData<T>);

impl<T> JoinHandle<T> {
    /// Ends the task.
    pub fn abort(&self) {
        self.0.notify_one();
    }
}

/// Begins a task.
pub fn spawn(task: impl Future<Output = ()> + 'static) -> JoinHandle<()> {
    let aborted = Arc::new(Notify::new());
    let handle = JoinHandle(Arc::clone(&aborted), PhantomData);
    spawn_local(async move {
        tokio::select! {
            () = aborted.notified() => {}
            () = task => {}
        }
    });
    handle
}
