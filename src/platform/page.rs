//! Tasks and timers on a web page's event loop: the part of tokio that the recorder uses, under the same names.

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

/// Waits this long or slightly longer: browsers have timers of at least 4 ms.
pub async fn sleep(duration: Duration) {
    let millis = duration.as_secs_f64() * 1e3;
    let elapsed = Promise::new(&mut |resolve, _| set_timeout(&resolve, millis));
    // A timer does not fail.
    let _ = JsFuture::from(elapsed).await;
}

pub async fn sleep_until(due: Instant) {
    sleep(due.saturating_duration_since(Instant::now())).await;
}

/// The time limit has passed.
#[derive(Debug)]
pub struct Elapsed;

/// The output of `future`, unless the time limit passes first.
pub async fn timeout<T>(duration: Duration, future: impl Future<Output = T>) -> Result<T, Elapsed> {
    tokio::select! {
        biased;
        value = future => Ok(value),
        () = sleep(duration) => Err(Elapsed),
    }
}

/// Treatment of missed ticks.
#[derive(Debug, Clone, Copy)]
pub enum MissedTickBehavior {
    /// The next tick is one period after the late one.
    Delay,
}

/// Ticks; the first is immediate.
#[derive(Debug)]
pub struct Interval {
    period: Duration,
    next: Instant,
}

/// Ticks of this period.
pub fn interval(period: Duration) -> Interval {
    Interval {
        period,
        next: Instant::now(),
    }
}

impl Interval {
    /// `Delay` is the only behavior here.
    pub fn set_missed_tick_behavior(&mut self, _: MissedTickBehavior) {}

    /// The next tick; cancel-safe.
    pub async fn tick(&mut self) {
        sleep_until(self.next).await;
        self.next = Instant::now() + self.period;
    }
}

/// A spawned task with the result `T`. Dropping the handle does not end it, as in tokio.
#[derive(Debug)]
pub struct JoinHandle<T>(Arc<Notify>, PhantomData<T>);

impl<T> JoinHandle<T> {
    /// Ends the task.
    pub fn abort(&self) {
        self.0.notify_one();
    }
}

/// Spawns a task.
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
