//! How far the sketch goes without a loss.

use emulated_board::bench::SteadyShaft;
use emulated_board::wiring::BoardKind;

use crate::support::{assert_true, complete, with_shaft};

/// The handout's motor makes at most 737 counts/s; the last is a hundred times as many.
#[test]
fn edges_at_a_high_rate_are_all_counted() {
    for kind in BoardKind::ALL {
        for counts_per_s in [1_000.0, 20_000.0, 50_000.0, 70_000.0] {
            let mut host = with_shaft(kind, SteadyShaft::new(counts_per_s));
            host.configure(3000, false, &[(10, 0), (90, 4500), (10, 0), (1, -4500)])
                .expect("configured");
            let (heard, end) = host.record(210).expect("a recording");
            assert_eq!(end, complete(210), "{kind:?} {counts_per_s}");
            let flagged = heard.iter().find(|sample| sample.flags.encoder_error);
            assert_eq!(flagged, None, "{kind:?} {counts_per_s}");
            assert_true(&heard, &host.board.truth().ticks);
        }
    }
}
