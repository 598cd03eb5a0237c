//! Logs of measuring instruments: LabVIEW with a time for each signal, oscilloscopes with a start and an increment,
//! header lines that state the sample time.

use crate::support::foreign_logs::{Truth, asked, counts, imported, near, proposed};

const COUNTS: [&str; 2] = ["--counts-per-rev", "720"];

/// A text made of each row: its time in s, its command in V and its counts.
fn text(truth: &Truth, row: impl Fn(usize, f64, f64, i64) -> String) -> String {
    (truth.rows())
        .map(|k| row(k, truth.t_s(k), truth.volts(k), truth.counts[k]))
        .collect()
}

/// The run is the motor's.
fn holds(truth: &Truth, text: &str, flags: &[&str]) {
    let (file, said) = imported("log.txt", text, &[&COUNTS[..], flags].concat());
    assert_eq!(counts(&file), truth.counts, "{text:.300}\n{said}");
    near(&file.column("t_s"), &truth.times(), 1e-9);
    near(&file.column("command_v"), &truth.commands(), 1e-6);
}

const LABVIEW: &str = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tYes\nX_Columns\tMulti\n\
                       Time_Pref\tRelative\n***End_of_Header***\t\n\t\nChannels\t2\t\t\t\nSamples\tN\t\tN\t\nY_Unit_Label\tVolts\t\tcounts\t\n\
                       X_Dimension\tTime\t\tTime\t\nX0\t0.0E+0\t\t0.0E+0\t\nDelta_X\t0.01\t\t0.01\t\n***End_of_Header***\t\t\t\t\n\
                       X_Value\tVoltage\tX_Value\tEncoder\tComment\n";

#[test]
fn labview_with_a_time_for_each_signal() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |_, t, u, n| {
        format!("{t:.6}\t{u:.6}\t{t:.6}\t{n}\n")
    });
    holds(&truth, &format!("{LABVIEW}{rows}"), &[]);
    // The command at a tenth of the rate in shorter columns: it is held.
    let rows = text(&truth, |k, t, _, n| match truth.rows().nth(10 * k) {
        Some(at) => format!(
            "{:.6}\t{:.6}\t{t:.6}\t{n}\n",
            truth.t_s(at),
            truth.volts(at)
        ),
        None => format!("\t\t{t:.6}\t{n}\n"),
    });
    holds(&truth, &format!("{LABVIEW}{rows}"), &[]);
}

#[test]
fn oscilloscopes_that_write_a_start_and_an_increment() {
    let truth = Truth::steps(0.01, 300);
    let flags = ["--command", "CH1:V", "--position", "CH2:rev"];
    let turns = |n: i64| n as f64 / 720.0;
    let older = text(&truth, |k, _, u, n| {
        format!("{k},{u:.6},{:.9e},\n", turns(n))
    });
    let names = "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-5.000000e-01,1.000000e-02\n";
    holds(&truth, &format!("{names}{older}"), &flags);
    let newer = text(&truth, |_, _, u, n| format!("{u:.6},{:.9e},,\n", turns(n)));
    let names = "CH1V,CH2V,t0 = -5.000e-01,tInc = 1.000e-02\n";
    holds(&truth, &format!("{names}{newer}"), &flags);
    let said = asked("log.csv", &format!("{names}{newer}"), &COUNTS);
    assert!(said.contains("`time` in s, a row every 0.01 s"), "{said}");
}

#[test]
fn a_line_that_states_the_sample_time_proposes_it() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |_, _, u, n| format!("{u:.6},{n}\n"));
    for line in [
        "Sample Interval,1.0E-02",
        "# fs = 100 Hz",
        "\"Sampling Period:\",10 ms",
    ] {
        let log = format!("{line}\nvoltage,encoder\n{rows}");
        let said = asked("log.csv", &log, &COUNTS);
        assert!(said.contains("--time 10ms"), "{line}: {said}");
        let flags = proposed(&said, &[]);
        let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        let (file, said) = imported("log.csv", &log, &flags);
        assert_eq!(counts(&file), truth.counts, "{said}");
        near(&file.column("t_s"), &truth.times(), 1e-9);
    }
}
