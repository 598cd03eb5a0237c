//! Exports of spreadsheets, pandas, recorders and loggers. Each has the counts, times and commands of the logged motor, or is
//! refused or asked about.

use crate::support::foreign_logs::{Truth, asked, counts, imported, near};

const COUNTS: [&str; 2] = ["--counts-per-rev", "720"];

/// The run is the motor's; times since 1970 have a resolution of a quarter of a microsecond.
fn holds(truth: &Truth, text: &str, flags: &[&str]) {
    let (file, said) = imported("log.txt", text, &[&COUNTS[..], flags].concat());
    assert_eq!(counts(&file), truth.counts, "{text:.300}\n{said}");
    near(&file.column("t_s"), &truth.times(), 5e-7);
    near(&file.column("command_v"), &truth.commands(), 0.006);
}

/// A text made of each row: its time in s, its command in V and its counts.
fn text(truth: &Truth, row: impl Fn(f64, f64, i64) -> String) -> String {
    (truth.rows())
        .map(|k| row(truth.t_s(k), truth.volts(k), truth.counts[k]))
        .collect()
}

/// With decimal commas, and commas in place of the semicolons.
fn with_commas(text: &str) -> String {
    text.replace(['.', ';'], ",")
}

#[test]
fn fields_in_single_quotes() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |t, u, n| format!("'{t:.3}','{u:.2}', '{n}'\n"));
    holds(
        &truth,
        &format!("'time_s','voltage [V]','counts'\n{rows}"),
        &[],
    );
    let rows = text(&truth, |t, u, n| format!("'{t:.3}';'{u:.2}';'{n}'\n"));
    let names = "'time_s';'voltage [V]';'counts'\n";
    holds(&truth, &with_commas(&format!("{names}{rows}")), &[]);
    // A separator within quotes is none, and an apostrophe within a number separates its thousands.
    let rows = text(&truth, |t, u, n| {
        format!(
            "{t:.3},'at, {n}',{u:.2},{}'{:03}\n",
            100 + n / 1000,
            n % 1000
        )
    });
    let (file, said) = imported(
        "log.csv",
        &format!("t_s,note,voltage_V,counts\n{rows}"),
        &COUNTS,
    );
    let expected: Vec<i64> = truth.counts.iter().map(|n| 100_000 + n).collect();
    assert_eq!(counts(&file), expected, "{said}");
}

#[test]
fn decimal_commas_beside_whole_numbers_between_commas() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |t, u, n| format!("{t:.3};{u:.2};{n}\n"));
    let (file, said) = imported(
        "log.csv",
        &with_commas(&format!("time_s;voltage_V;counts\n{rows}")),
        &COUNTS,
    );
    assert!(said.contains("`counts` in whole numbers"), "{said}");
    assert_eq!(counts(&file), truth.counts);
    near(&file.column("t_s"), &truth.times(), 1e-9);
    near(&file.column("command_v"), &truth.commands(), 0.006);
    let rows = text(&truth, |t, u, n| format!("{:.0};{u:.2};{n}\n", 1000.0 * t));
    holds(
        &truth,
        &with_commas(&format!("time_ms;voltage_V;counts\n{rows}")),
        &[],
    );
    // Of one digit, nothing shows which columns have decimals: every column is asked for, and why is said.
    let rows = text(&truth, |t, u, n| format!("{t:.2};{u:.1};{n}\n"));
    let one_digit = text(&truth, |t, u, n| format!("{:.0};{u:.1};{n}\n", 1000.0 * t));
    let trimmed = text(&truth, |t, u, n| format!("{t};{u};{n}\n"));
    for (names, rows) in [
        ("time_ms;voltage_V;counts\n", &one_digit),
        ("time_s;voltage_V;counts\n", &trimmed),
        ("", &rows),
    ] {
        let said = asked("log.csv", &with_commas(&format!("{names}{rows}")), &COUNTS);
        let is_refused = said.contains("several ways");
        let is_asked = said.contains("--command COLUMN:UNIT") && said.contains("decimal points");
        assert!(is_refused || is_asked, "{names}{said}");
    }
    // The first column of R has the numbers of the rows and no name.
    let rows: String = (truth.rows())
        .map(|k| {
            format!(
                "{},{},{:.6},{}\n",
                k + 1,
                truth.ms(k),
                truth.volts(k),
                truth.counts[k]
            )
        })
        .collect();
    holds(&truth, &format!("time_ms,voltage_V,counts\n{rows}"), &[]);
}

#[test]
fn pairs_by_the_ends_of_their_names() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |t, u, n| format!("{t:.3},{n},{t:.3},{u:.6}\n"));
    for [x, y] in [["_X", "_Y"], [" x", " y"], [".X", ".Y"]] {
        let names = format!("Encoder [counts]{x},Encoder [counts]{y},Voltage{x},Voltage{y}\n");
        holds(&truth, &format!("{names}{rows}"), &["--time", "X:s"]);
    }
}

#[test]
fn a_transposed_table_with_units_in_its_labels_or_beside_them() {
    let truth = Truth::steps(0.01, 300);
    let signal = |label: &str, of: &dyn Fn(usize) -> String| {
        let cells: Vec<String> = truth.rows().map(of).collect();
        format!("{label};{}\n", cells.join(";"))
    };
    for [t, u, n] in [
        ["Time (s)", "Voltage (V)", "Encoder (counts)"],
        ["Time [s]", "Voltage [V]", "Encoder [counts]"],
        ["Time;s", "Voltage;V", "Encoder;counts"],
        [
            "\"Time\";\"[s]\"",
            "\"Voltage\";\"[V]\"",
            "\"Encoder\";\"[counts]\"",
        ],
    ] {
        let text = signal(t, &|k| format!("{:.3}", truth.t_s(k)))
            + &signal(u, &|k| format!("{:.6}", truth.volts(k)))
            + &signal(n, &|k| truth.counts[k].to_string());
        holds(&truth, &text, &[]);
        holds(&truth, &text.replace('.', ","), &[]);
        holds(&truth, &text.replace(';', "\t"), &[]);
    }
    let text = signal("Time [ms]:", &|k| truth.ms(k).to_string())
        + &signal("PWM [0-255]:", &|k| truth.pwm[k].to_string())
        + &signal("Encoder [counts]:", &|k| truth.counts[k].to_string());
    holds(&truth, &text.replace(';', " "), &["--supply", "12"]);
}

#[test]
fn frames_of_pandas_in_every_orient() {
    let truth = Truth::steps(0.01, 300);
    let cells = |row: &dyn Fn(usize) -> String| -> String {
        truth.rows().map(row).collect::<Vec<_>>().join(",")
    };
    let by = |of: &dyn Fn(usize) -> String| cells(&|k| format!("\"{k}\":{}", of(k)));
    let (t, u, n) = (
        |k: usize| format!("{:.2}", truth.t_s(k)),
        |k: usize| format!("{:.6}", truth.volts(k)),
        |k: usize| truth.counts[k].to_string(),
    );
    let row = |k: usize| format!("[{},{},{}]", t(k), u(k), n(k));
    let object = |k: usize| {
        format!(
            "{{\"time_s\":{},\"voltage_V\":{},\"counts\":{}}}",
            t(k),
            u(k),
            n(k)
        )
    };
    let names = "[\"time_s\",\"voltage_V\",\"counts\"]";
    let index = cells(&|k| k.to_string());
    for json in [
        format!(
            "{{\"columns\":{names},\"index\":[{index}],\"data\":[{}]}}",
            cells(&row)
        ),
        format!("{{{}}}", by(&object)),
        format!(
            "{{\"time_s\":{{{}}},\"voltage_V\":{{{}}},\"counts\":{{{}}}}}",
            by(&t),
            by(&u),
            by(&n)
        ),
        format!(
            "{{\"schema\":{{\"fields\":[]}},\"data\":[{}]}}",
            cells(&object)
        ),
        format!("[{}]", cells(&object)),
    ] {
        holds(&truth, &json, &[]);
    }
    // The index is the time.
    let row = |k: usize| format!("[{},{}]", u(k), n(k));
    let index = cells(&|k| (1_700_000_000_000 + truth.ms(k)).to_string());
    let names = "[\"voltage_V\",\"counts\"]";
    let json = format!(
        "{{\"columns\":{names},\"index\":[{index}],\"data\":[{}]}}",
        cells(&row)
    );
    holds(&truth, &json, &[]);
}

#[test]
fn messages_of_loggers() {
    let truth = Truth::steps(0.01, 300);
    let stamp = |t: f64| {
        format!(
            "2026-04-13 12:34:{:02},{:03}",
            t as u64,
            (1000.0 * t).round() as u64 % 1000
        )
    };
    let python = text(&truth, |t, u, n| {
        format!("{} INFO motor: voltage_V={u:.6} counts={n}\n", stamp(t))
    });
    holds(&truth, &python, &[]);
    let other = text(&truth, |t, u, n| {
        format!(
            "{} - motor - DEBUG - voltage_V: {u:.6}, counts: {n}\n",
            stamp(t)
        )
    });
    holds(&truth, &other, &[]);
    let ros = text(&truth, |t, u, n| {
        format!(
            "[INFO] [{:.9}] [motor]: voltage_V: {u:.6} counts: {n}\n",
            1.7e9 + t
        )
    });
    holds(&truth, &ros, &[]);
    let yaml = text(&truth, |t, u, n| {
        format!("- {{t_s: {t:.3}, voltage_V: {u:.6}, counts: {n}}}\n")
    });
    holds(&truth, &yaml, &[]);
    let foxglove = text(&truth, |t, u, n| {
        let s = 1.7e9 + t;
        format!("{t:.3},{s:.9},/motor.voltage,{u:.6}\n{t:.3},{s:.9},/encoder.counts,{n}\n")
    });
    holds(
        &truth,
        &format!("elapsed,receive time,topic,value\n{foxglove}"),
        &[],
    );
    let simulink = text(&truth, |t, u, n| format!("{t:.3},{u:.6},{t:.3},{n}\n"));
    let names = "time,voltage,time,encoder\nUnit: s,Unit: V,Unit: s,Unit: counts\n";
    holds(&truth, &format!("{names}{simulink}"), &[]);
}

#[test]
fn clocks_that_count_rows_or_parts_of_a_second() {
    let truth = Truth::steps(0.01, 300);
    let rows = |of: &dyn Fn(usize) -> String| -> String {
        (truth.rows())
            .map(|k| format!("{},{:.6},{}\n", of(k), truth.volts(k), truth.counts[k]))
            .collect()
    };
    let stamped = |k: usize| format!("{:02}.{:03}", truth.ms(k) / 1000, truth.ms(k) % 1000);
    // TIA Portal: `Time` is the number of the row.
    let log = rows(&|k| format!("{k},13.04.2026 12:34:{}", stamped(k)));
    holds(
        &truth,
        &format!("Time,Timestamp,voltage,encoder\n{log}"),
        &[],
    );
    let log = rows(&|k| format!("13-Apr-2026 12:34:{}", stamped(k)));
    holds(&truth, &format!("Time,voltage,encoder\n{log}"), &[]);
    for (name, step) in [
        ("time_cs", 1),
        ("time_100us", 100),
        ("Time [0.1 ms]", 100),
        ("t (10 µs)", 1000),
    ] {
        let log = format!(
            "{name},voltage,encoder\n{}",
            rows(&|k| (step * k).to_string())
        );
        let said = asked("log.csv", &log, &COUNTS);
        assert!(
            said.contains("by its name") && said.contains("--time 10ms"),
            "{said}"
        );
    }
    // Another column tells that a step of 10 is no time of 10 ms.
    let log = rows(&|k| format!("{},{}", 10 * k, truth.ms(k) * 100));
    let said = asked(
        "log.csv",
        &format!("t,host_us,voltage,encoder\n{log}"),
        &[&COUNTS[..], &["--time", "t"]].concat(),
    );
    assert!(said.contains("--time t:"), "{said}");
}

#[test]
fn a_coarser_column_is_not_proposed_and_a_constant_period_is_full_drive() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |t, u, n| {
        let width = (u / 12.0 * 2000.0).round();
        format!(
            "{:.0},{width},2000,{},{:.3}\n",
            1000.0 * t,
            n.div_euclid(720),
            0.5 * n.rem_euclid(720) as f64
        )
    });
    let log = format!("time_ms,pwm,pwm_period,turns,angle_deg\n{rows}");
    let said = asked("log.csv", &log, &["--supply", "12"]);
    assert!(
        said.contains("2000 is full drive, as `pwm_period` is"),
        "{said}"
    );
    assert!(said.contains("--position angle_deg"), "{said}");
    let flags = ["--supply", "12", "--position", "angle_deg"];
    let (file, said) = imported("log.csv", &log, &flags);
    near(&file.column("command_v"), &truth.commands(), 0.01);
    assert_eq!(counts(&file), truth.counts, "{said}");
}

#[test]
fn channels_of_an_encoder_are_no_position() {
    let log: String = (0..200).fold("Time[s], Enc A, Enc B\n".to_owned(), |text, k| {
        let (a, b) = [(0, 0), (1, 0), (1, 1), (0, 1)][k % 4];
        text + &format!("{:.6}, {a}, {b}\n", 0.001 * k as f64)
    });
    let said = asked("log.csv", &log, &["--command", "6V@0s"]);
    assert!(
        said.contains("channels A and B") && said.contains("--position COLUMN:UNIT"),
        "{said}"
    );
    let said = asked(
        "log.vcd",
        "$date today $end\n$timescale 1us $end\n",
        &COUNTS,
    );
    assert!(
        said.contains("VCD") && said.contains("sigrok-cli"),
        "{said}"
    );
}
