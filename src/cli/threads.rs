//! `--threads`: number of threads of a computation.

use clap::Args;

use super::Failure;
use crate::hint::In;

/// Most threads: more than any computer has cores.
const MOST_THREADS: u16 = 4096;

/// `--threads`, shared by every subcommand that computes.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Threads {
    /// Number of threads; use 1 on a shared machine. The answer does not depend on it, to the last bit. [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_THREADS)))]
    threads: Option<u16>,
}

impl Threads {
    /// Sets the number of threads; call before any computation.
    pub(super) fn set(self) -> Result<(), Failure> {
        let Some(threads) = self.count() else {
            return Ok(());
        };
        // The process's thread pool is created once, by its first user.
        let built = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global();
        match built {
            Err(_) if rayon::current_num_threads() == threads => Ok(()),
            Err(error) => Err(Failure::device(In::new(
                format!("--threads {threads}"),
                error,
            ))),
            Ok(()) => Ok(()),
        }
    }

    pub(super) fn count(self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}
