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

/// Where it ends: run with `--ignored --nocapture`.
#[test]
#[ignore = "prints figures"]
fn limits() {
    for kind in BoardKind::ALL {
        for rate in (30..=160).step_by(5) {
            let mut host = with_shaft(kind, SteadyShaft::new(f64::from(rate) * 1000.0));
            host.configure(3000, false, &[(10, 0), (1, 4500)])
                .expect("configured");
            if host
                .ask(&firmware_protocol::HostMessage::Start { samples: 300 })
                .is_err()
            {
                println!("{kind:?} {rate} k/s: no answer");
                continue;
            }
            let Ok((heard, _)) = host.until_end(4.0) else {
                println!("{kind:?} {rate} k/s: no END");
                continue;
            };
            let ticks = &host.board.truth().ticks;
            let wrong = heard
                .iter()
                .filter(|s| i64::from(s.counts) != ticks[usize::from(s.sequence)].count)
                .count();
            let flagged = heard.iter().filter(|s| s.flags.encoder_error).count();
            let overrun = heard.iter().filter(|s| s.flags.overrun).count();
            println!(
                "{kind:?} {rate} k/s: {} heard, {wrong} wrong, {flagged} flagged, {overrun} overrun",
                heard.len()
            );
        }
        for ts in [
            3000, 2500, 2000, 1800, 1700, 1600, 1500, 1200, 1000, 500, 400, 300, 250, 200, 150,
            125, 100,
        ] {
            let shaft =
                emulated_board::bench::MotorShaft::new(&motorlab::motor::Motor::default()).unwrap();
            let mut host = with_shaft(kind, shaft);
            host.configure(ts, false, &[(1, 4500)]).expect("configured");
            let _ = host.ask(&firmware_protocol::HostMessage::Start { samples: 1000 });
            let (heard, end) = host.until_end(6.0).expect("END");
            let overrun = heard.iter().filter(|s| s.flags.overrun).count();
            println!(
                "{kind:?} TS {ts}: {} heard, {overrun} overrun, {end:?}",
                heard.len()
            );
        }
    }
}
