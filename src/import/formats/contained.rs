//! Readers of other people's libraries that panic on damaged data, made to fail as ours do.
//!
//! Of 1500 damaged Parquet files three or four panic in the crate `parquet` 60.1 (an assertion on a negative offset, a missing
//! dictionary, an index beyond a buffer). Unfinished results are discarded with the panic.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use super::super::table::Table;
use super::{Form, FormatError};

thread_local! {
    /// This thread's panics are caught, and say nothing.
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Makes panics of threads that are quiet say nothing; all others go on as before.
static HOOK: Once = Once::new();

/// Reads; a panic is a broken file.
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
