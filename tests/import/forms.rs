//! Text logs that are no plain tables: JSON, tuples, tables with bars, pairs of columns, one signal per line, LVM.
//! Counts, times and commands are those of the logged motor.

use std::fs;

use crate::support::command::run;
use crate::support::foreign_logs::{Truth, asked, counts, import, imported, log, near};

const FLAGS: [&str; 4] = ["--counts-per-rev", "720", "--supply", "12"];

/// The run is the motor's.
fn holds(truth: &Truth, text: &str, flags: &[&str]) {
    let (file, said) = imported("log.txt", text, &[&FLAGS[..], flags].concat());
    assert_eq!(counts(&file), truth.counts, "{text:.200}\n{said}");
    near(&file.column("t_s"), &truth.times(), 1e-9);
    near(&file.column("command_v"), &truth.commands(), 1e-6);
}

fn lines(truth: &Truth, line: impl Fn(u64, i64, i64) -> String) -> String {
    (truth.rows())
        .map(|k| line(truth.ms(k), truth.pwm[k], truth.counts[k]) + "\n")
        .collect()
}

#[test]
fn one_row_per_line_in_any_brackets() {
    let truth = Truth::steps(0.01, 300);
    let unnamed = [
        "--time",
        "1:ms",
        "--command",
        "2:pwm",
        "--position",
        "3:counts",
    ];
    for row in [
        "(T, U, N)",
        "[T, U, N],",
        "/*T,U,N*/",
        "[[T U N]",
        "array([T, U, N])",
        "T | U | N",
    ] {
        let text = lines(&truth, |t, u, n| {
            let row = row
                .replace('T', &t.to_string())
                .replace('U', &u.to_string());
            row.replace('N', &n.to_string())
        });
        holds(&truth, &text, &unnamed);
    }
    let rows = lines(&truth, |t, u, n| format!("| {t} | {u} | {n} |"));
    holds(
        &truth,
        &format!("| time_ms | pwm | counts |\n|---|--:|---|\n{rows}"),
        &[],
    );
    let rows = lines(&truth, |t, u, n| format!("{t:>8} {u:>8} {n:>8}"));
    holds(
        &truth,
        &format!("time_ms pwm counts\n------- --- ------\n{rows}"),
        &[],
    );
}

#[test]
fn esp_idf_logs_and_colours() {
    let truth = Truth::steps(0.01, 300);
    let counts = ["--position", "pos:counts"];
    let text = lines(&truth, |t, u, n| format!("I ({t}) motor: pos={n} pwm={u}"));
    holds(&truth, &text, &counts);
    let text = lines(&truth, |t, u, n| {
        format!("\u{1b}[0;32mI ({t}) motor: pos={n} pwm={u}\u{1b}[0m")
    });
    holds(&truth, &text, &counts);
}

#[test]
fn json_as_lines_and_as_a_document() {
    let truth = Truth::steps(0.01, 300);
    let object = |t, u, n| format!("{{\"t_ms\": {t}, \"pwm\": {u}, \"counts\": {n}}}");
    holds(&truth, &lines(&truth, object), &[]);
    let python = |t, u, n| format!("{{'t_ms': {t}, 'pwm': {u}, 'counts': {n}}}");
    holds(&truth, &lines(&truth, python), &[]);
    let rows: Vec<String> = (lines(&truth, object).lines()).map(str::to_owned).collect();
    holds(&truth, &format!("[{}]", rows.join(",\n ")), &[]);
    let nested =
        |t, u, n| format!("{{\"t_ms\": {t}, \"motor\": {{\"pwm\": {u}, \"counts\": {n}}}}}");
    holds(&truth, &lines(&truth, nested), &[]);
    let said = asked(
        "log.json",
        "{\"rig\": {\"a\": 1}, \"rows\": [{\"t\": 0}]}",
        &[],
    );
    assert!(
        said.contains("nested JSON") && said.contains("pandas.json_normalize"),
        "{said}"
    );
}

#[test]
fn teleplot_and_one_signal_per_line() {
    let truth = Truth::steps(0.01, 300);
    let counts = ["--position", "pos:counts"];
    let text = lines(&truth, |t, u, n| format!(">pwm:{t}:{u}\n>pos:{t}:{n}"));
    holds(&truth, &text, &counts);
    let text = lines(&truth, |_, u, n| format!(">pwm:{u}\n>pos:{n}"));
    holds(&truth, &text, &[&counts[..], &["--time", "10ms"]].concat());
    let signal = |name: &str, cell: &dyn Fn(usize) -> String| {
        let cells: Vec<String> = truth.rows().map(cell).collect();
        format!("{name},{}\n", cells.join(","))
    };
    let text = signal("time_ms", &|k| truth.ms(k).to_string())
        + &signal("pwm", &|k| truth.pwm[k].to_string())
        + &signal("counts", &|k| truth.counts[k].to_string());
    holds(&truth, &text, &[]);
    let python: String = (text.lines())
        .map(|line| line.replacen(',', " = [", 1) + "]\n")
        .collect();
    holds(&truth, &python, &[]);
}

#[test]
fn decimal_commas_in_quotes() {
    let truth = Truth::steps(0.01, 300);
    let rows: String = (truth.rows())
        .map(|k| {
            let row = format!(
                "\"{:.3}\";\"{:.6}\";\"{}\"\n",
                truth.t_s(k),
                truth.volts(k),
                truth.counts[k]
            );
            row.replace(['.', ';'], ",")
        })
        .collect();
    holds(
        &truth,
        &format!("\"Time (s)\",\"Voltage (V)\",\"Encoder\"\n{rows}"),
        &[],
    );
}

#[test]
fn a_pair_of_columns_for_each_signal() {
    let truth = Truth::steps(0.01, 300);
    let rows = lines(&truth, |t, u, n| format!("{t},{n},{t},{u}"));
    let text = format!("Position [counts],,duty_255,\nTime [ms],Y,Time [ms],Y\n{rows}");
    holds(&truth, &text, &[]);
    // Each signal has its own times: the command is held.
    let rows = lines(&truth, |t, u, n| format!("{t}.5,{n},{t},{u}"));
    let text = format!("Position [counts],,duty_255,\nTime [ms],Y,Time [ms],Y\n{rows}");
    let (file, said) = imported("log.csv", &text, &FLAGS);
    assert_eq!(counts(&file), truth.counts, "{said}");
    near(&file.column("command_v"), &truth.commands(), 1e-6);
    let rows = lines(&truth, |t, u, n| format!("{};{n};{};{u}", t / 10, t / 10));
    let text = format!(
        "Name;Scope;;\nName;Axis.ActPos;Name;pwm\nSampleTime[ms];10;SampleTime[ms];10\nUnit;counts;Unit;\n;;;\n{rows}"
    );
    holds(&truth, &text, &[]);
}

#[test]
fn lvm_and_a_matrix_as_matlab_prints_it() {
    let truth = Truth::steps(0.01, 300);
    let rows = lines(&truth, |_, u, n| format!("\t{u},000000\t{n},000000"));
    let text = format!(
        "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tNo\n***End_of_Header***\t\n\t\n\
         Channels\t2\t\nSamples\t300\t300\t\nX0\t0,0E+0\t0,0E+0\t\nDelta_X\t0,010000\t0,010000\t\n***End_of_Header***\t\t\t\n\
         X_Value\tpwm\tcounts\tComment\n{rows}"
    );
    holds(&truth, &text, &[]);
    let rows = lines(&truth, |t, u, n| {
        let scaled = |number: f64| format!("{:.4}", number / 1000.0);
        format!(
            "    {}    {}    {}",
            scaled(t as f64),
            scaled(u as f64),
            scaled(n as f64)
        )
    });
    let unnamed = [
        "--time",
        "1:ms",
        "--command",
        "2:pwm",
        "--position",
        "3:counts",
        "--pwm-full",
        "255",
    ];
    let (file, said) = imported(
        "log.txt",
        &format!("data =\n\n   1.0e+03 *\n\n{rows}"),
        &[&FLAGS[..], &unnamed].concat(),
    );
    assert!(said.contains("times 1000"), "{said}");
    near(&file.column("t_s"), &truth.times(), 1e-4);
}

/// The names of the Arduino PID library and of process control.
#[test]
fn the_output_of_a_controller_is_the_command() {
    let truth = Truth::steps(0.02, 300);
    for names in [
        "millis,Setpoint,Input,Output",
        "t_ms,SP,PV,OP",
        "time_ms,target,speed,effort",
    ] {
        let rows = (truth.rows()).map(|k| {
            format!(
                "{},100,{},{:.1}\n",
                truth.ms(k),
                truth.rpm(k),
                truth.pwm[k] as f64 / 200.0 * 255.0
            )
        });
        let text = format!("{names}\n{}", rows.collect::<String>());
        let said = asked("log.csv", &text, &[]);
        let (input, output) = names
            .split_once(',')
            .map(|(_, rest)| {
                let names: Vec<&str> = rest.split(',').collect();
                (names[1].to_owned(), names[2].to_owned())
            })
            .expect("names");
        assert!(said.contains(&format!("--command {output}:pwm")), "{said}");
        assert!(said.contains(&format!("--speed {input}:rpm")), "{said}");
    }
}

#[test]
fn unreadable_formats_are_named_with_their_conversion() {
    for (name, content, words) in [
        (
            "log.hoot",
            &b"\x01\x02\x03\x04"[..],
            ["Phoenix", "owlet FILE log.wpilog"],
        ),
        (
            "log.npy",
            b"\x93NUMPY\x01\x00v\x00",
            ["NumPy", "numpy.savetxt"],
        ),
        (
            "log.txt",
            b"Dear reader,\nno log\n",
            ["no table of numbers", "hint: a log is text in columns"],
        ),
    ] {
        let directory = tempfile::tempdir().expect("a directory");
        fs::write(directory.path().join(name), content).expect("written");
        let finished = run(directory.path(), &["import", name]);
        assert_eq!(finished.status, Some(2), "{name}");
        for words in words {
            assert!(
                finished.messages.contains(words),
                "{name}: {}",
                finished.messages
            );
        }
        assert!(
            !finished.messages.contains("--map"),
            "{name}: {}",
            finished.messages
        );
    }
    let truth = Truth::steps(0.01, 300);
    let text = lines(&truth, |t, u, n| {
        format!("{t},{u},{:.2}", if n % 2 == 0 { 0.4 } else { 4.1 })
    });
    let said = asked(
        "log.csv",
        &format!("time_ms,pwm,photodiode_V\n{text}"),
        &["--supply", "12"],
    );
    assert!(
        said.contains("count its edges first") && said.contains("counted.csv"),
        "{said}"
    );
}

/// Rows in a wrapping syntax are rejected with their reason.
#[test]
fn a_bad_row_in_brackets_is_named_by_its_line() {
    let truth = Truth::steps(0.01, 100);
    let text = lines(&truth, |t, u, n| match t {
        500 => "(500, x)".to_owned(),
        _ => format!("({t}, {u}, {n})"),
    });
    let directory = tempfile::tempdir().expect("a directory");
    let flags = [
        "--time",
        "1:ms",
        "--command",
        "2:pwm",
        "--position",
        "3:counts",
    ];
    let finished = import(
        directory.path(),
        "log.txt",
        &text,
        &[&FLAGS[..], &flags].concat(),
    );
    assert_eq!(finished.status, Some(1), "{}", finished.messages);
    assert!(
        finished.messages.contains("line 51: 2 cells"),
        "{}",
        finished.messages
    );
}

#[test]
fn vectors_that_matlab_prints_and_a_table_on_its_side_with_decimal_commas() {
    let truth = Truth::steps(0.01, 300);
    let numbers = |of: &dyn Fn(usize) -> String, between: &str| -> String {
        let all: Vec<String> = truth.rows().map(of).collect();
        all.join(between)
    };
    let (ms, volts) = (
        |k: usize| truth.ms(k).to_string(),
        |k: usize| format!("{:.6}", truth.volts(k)),
    );
    let turned = |k: usize| truth.counts[k].to_string();
    let printed =
        |name: &str, of: &dyn Fn(usize) -> String| format!("\n{name} =\n\n{}\n", numbers(of, "\n"));
    let text = printed("time_ms", &ms) + &printed("voltage", &volts) + &printed("counts", &turned);
    holds(&truth, &text, &[]);
    let line = |name: &str, of: &dyn Fn(usize) -> String| {
        format!("{name};{}\n", numbers(of, ";").replace('.', ","))
    };
    let text = line("time [ms]", &ms) + &line("U [V]", &volts) + &line("n [counts]", &turned);
    holds(&truth, &text, &[]);
}

#[test]
fn labels_of_several_words_between_bars_after_a_time_in_brackets() {
    let truth = Truth::steps(0.01, 300);
    let mut text = String::new();
    for k in truth.rows() {
        text.push_str(&format!(
            "[{:.3}] Encoder: {} counts | Motor PWM: {}\n",
            truth.t_s(k),
            truth.counts[k],
            truth.pwm[k]
        ));
    }
    holds(&truth, &text, &[]);
}

#[test]
fn thousands_separators_are_no_decimal_commas() {
    let truth = Truth::steps(0.01, 300);
    let grouped = |number: i64| {
        let digits = number.abs().to_string();
        let mut text = String::new();
        for (at, digit) in digits.chars().enumerate() {
            if at > 0 && (digits.len() - at).is_multiple_of(3) {
                text.push(',');
            }
            text.push(digit);
        }
        format!("\"{}{text}\"", if number < 0 { "-" } else { "" })
    };
    let us = |k: usize| grouped(1000 * truth.ms(k) as i64);
    let turned = |k: usize| grouped(truth.counts[k]);
    let volts = |k: usize| format!("{:.6}", truth.volts(k));
    let text = log(
        "time_us,counts,voltage",
        truth.rows(),
        &[&us, &turned, &volts],
    );
    holds(&truth, &text, &[]);
}

/// MegunoLink names each number; MATLAB names a matrix, and not its columns.
#[test]
fn megunolink_is_read_and_a_matrix_name_is_no_column() {
    let truth = Truth::steps(0.01, 300);
    let text = lines(&truth, |_, u, n| {
        format!("{{TIMEPLOT|DATA|counts|T|{n}}}\n{{TIMEPLOT:Motor|DATA|pwm:b|T|{u}}}")
    });
    holds(&truth, &text, &["--time", "10ms"]);
    let rows = lines(&truth, |t, u, n| format!("    {t}    {u}    {n}"));
    let said = asked("log.txt", &format!("out =\n\n{rows}"), &FLAGS);
    assert!(!said.contains('='), "{said}");
}
