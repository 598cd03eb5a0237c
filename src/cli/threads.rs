//! `--threads`: how many threads compute.

use clap::Args;

use super::Failure;
use crate::hint::In;

/// Most threads that may be asked for: more than any computer has cores.
const MOST_THREADS: u16 = 4096;

/// `--threads`, in the same words for every subcommand that computes.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Threads {
    /// Number of threads; use 1 on a shared machine. The answer does not depend on it, to the last bit. [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_THREADS)))]
    threads: Option<u16>,
}

impl Threads {
    /// Has so many threads compute from now on; before anything is computed.
    pub(super) fn set(self) -> Result<(), Failure> {
        let Some(threads) = self.count() else {
            return Ok(());
        };
        // The pool of a process is made once, by whoever computes first.
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

    /// How many were asked for.
    pub(super) fn count(self) -> Option<usize> {
        self.threads.map(usize::from)
    }
}
