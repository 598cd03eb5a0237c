//! Converts panics of third-party readers to errors.
//!
//! Of 1500 damaged Parquet files three or four cause a panic in the crate `parquet` 60.1 (an assertion on a negative
//! offset, a missing dictionary, an index beyond a buffer). Partial results are discarded.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use super::super::table::Table;
use super::{Form, FormatError};

thread_local! {
    /// Panics of this thread are caught, and not printed.
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Installs a panic hook that is silent for threads with this flag.
static HOOK: Once = Once::new();

/// Runs a reader; a panic is a damaged file.
pub(super) fn contained(
    form: Form,
    read: impl FnOnce() -> Result<Table, FormatError>,
) -> Result<Table, FormatError> {
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_QUIET.get() {
                before(panic);
            }
        }));
    });
    IS_QUIET.set(true);
    let read = catch_unwind(AssertUnwindSafe(read));
    IS_QUIET.set(false);
    read.unwrap_or_else(|_| Err(form.broken("its parts contradict each other")))
}
