//! Resources used by a running process, from Linux's `/proc`; `None` elsewhere, or when it has ended.

use std::fs;

/// Linux counts processor time in hundredths of a second for every program (`USER_HZ`).
const TICKS_PER_S: f64 = 100.0;

pub fn cpu_s(pid: u32) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // After the name in brackets, which may contain anything: user and system time are the 14th and 15th field of
    // proc_pid_stat(5).
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |index: usize| fields.get(index)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS_PER_S)
}

/// Peak memory so far in kB (`VmHWM`).
pub fn peak_memory_kb(pid: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}
