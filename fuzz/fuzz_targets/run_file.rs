//! Arbitrary bytes as a run file: no panic, a run satisfies the invariants of a run, and reading is independent of
//! the chunks of the source.
#![no_main]

use std::io::{self, Read};

use motorlab::recording::read_run_from;

/// A source that returns at most `chunk` bytes per read.
struct InChunks<'a> {
    bytes: &'a [u8],
    chunk: usize,
}

impl Read for InChunks<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.chunk.min(buffer.len());
        (&mut self.bytes).take(length as u64).read(buffer)
    }
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let whole = read_run_from(bytes, "whole");
    let chunk = usize::from(bytes.last().copied().unwrap_or(0)) + 1;
    let in_chunks = read_run_from(InChunks { bytes, chunk }, "whole");
    let (run, notes) = match (whole, in_chunks) {
        (Ok(whole), Ok(in_chunks)) => {
            assert_eq!(format!("{whole:?}"), format!("{in_chunks:?}"));
            whole
        }
        (Err(whole), Err(in_chunks)) => {
            assert_eq!(whole.to_string(), in_chunks.to_string());
            return;
        }
        (whole, in_chunks) => panic!("{whole:?} as a whole, {in_chunks:?} in chunks of {chunk}"),
    };
    for note in notes {
        let _ = note.to_string();
    }
    let length = run.len();
    assert!(length > 0 && run.t_s[0] == 0.0);
    assert!(run.t_s.len() == length && run.command.len() == length);
    assert!(run.t_s.windows(2).all(|pair| pair[0] <= pair[1]));
    assert!(run.t_s.iter().chain(&run.command).all(|x| x.is_finite()));
    assert!(run.sample_time_s > 0.0 && run.counts_per_rev > 0.0);
    let lengths = [
        run.seq.as_ref().map(Vec::len),
        run.host_t_s.as_ref().map(Vec::len),
        run.velocity_rad_s.as_ref().map(Vec::len),
        run.flags.as_ref().map(Vec::len),
        run.measured_supply_v.as_ref().map(Vec::len),
        run.measured_current_a.as_ref().map(Vec::len),
    ];
    assert!(lengths.iter().flatten().all(|&found| found == length));
});
