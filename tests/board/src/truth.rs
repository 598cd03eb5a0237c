//! True events on the board, for comparison with what it sent.

use std::io::{self, Write};

use crate::board::{Drive, seconds};

/// One tick of the sampling timer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// Cycle at which the timer matched.
    pub due: u64,
    /// Cycle at which its interrupt began: the true time of the sample.
    pub entered: u64,
    /// Counts by the encoder's pins until then.
    pub count: i64,
    /// The wheel's true angle then, in counts; the count is its integral part.
    pub angle_counts: f64,
    /// Its rate.
    pub counts_per_s: f64,
}

/// Log of true events.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Truth {
    /// Every tick, first to last.
    pub ticks: Vec<Tick>,
    /// Every change of the driver's pins with its cycle, to within 10 us.
    pub drives: Vec<(u64, Drive)>,
    /// Cycle at which the latest byte reached the board.
    pub last_received: u64,
    /// Cycles of the resets.
    pub resets: Vec<u64>,
}

impl Truth {
    /// Writes the ticks as CSV: `tick,due_s,entered_s,count,angle_counts,motor_v`, with the voltage at the motor at
    /// the tick.
    pub fn write_csv(&self, mut output: impl Write) -> io::Result<()> {
        writeln!(output, "tick,due_s,entered_s,count,angle_counts,motor_v")?;
        let mut drives = self.drives.iter().peekable();
        let mut motor_v = 0.0;
        for (index, tick) in self.ticks.iter().enumerate() {
            while let Some((_, drive)) = drives.next_if(|(cycle, _)| *cycle <= tick.entered) {
                motor_v = drive.motor_v;
            }
            writeln!(
                output,
                "{index},{:.7},{:.7},{},{:.4},{motor_v}",
                seconds(tick.due),
                seconds(tick.entered),
                tick.count,
                tick.angle_counts,
            )?;
        }
        output.flush()
    }
}
