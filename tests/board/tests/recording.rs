//! Recordings of the emulated boards against what really happened on them.

use emulated_board::bench::MotorShaft;
use emulated_board::board::Board;
use emulated_board::host::Host;
use emulated_board::wiring::BoardKind;
use firmware_protocol::{BoardMessage, EndReason};
use motorlab::motor::Motor;

#[test]
fn every_count_of_a_step_is_the_true_one() {
    for kind in BoardKind::ALL {
        let shaft = MotorShaft::new(&Motor::default()).expect("the default motor");
        let mut host = Host::new(Board::new(kind, shaft).expect("a board"));
        let hello = host.hello().expect("HELLO");
        assert_eq!(hello.counts_per_rev, 720);
        host.configure(3000, false, &[(100, 0), (100, 4500)])
            .expect("configured");
        let (samples, end) = host.record(600).expect("a recording");
        let complete = BoardMessage::End {
            taken: 600,
            dropped: 0,
            reason: EndReason::Complete,
        };
        assert_eq!(end, complete);
        let ticks = &host.board.truth().ticks;
        assert_eq!((samples.len(), ticks.len()), (600, 600));
        for (sample, tick) in samples.iter().zip(ticks) {
            assert_eq!(i64::from(sample.counts), tick.count, "{sample:?}");
        }
        assert!(samples[599].counts > 700);
    }
}
