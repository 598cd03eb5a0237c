//! Logs in the formats of common tools: ROS messages as text and in cells, InfluxDB, long tables, controllers'
//! clocks, SimpleFOC, servo pulses. Each has the counts, times and commands of the logged motor, or is reported with
//! what it lacks.

use std::fmt::Write as _;

use crate::support::foreign_logs::{Truth, asked, counts, imported, near};

const FLAGS: [&str; 2] = ["--counts-per-rev", "720"];

/// The run is the motor's; times since 1970 have a resolution of a quarter of a microsecond.
fn holds(truth: &Truth, text: &str, flags: &[&str]) {
    let (file, said) = imported("log.txt", text, &[&FLAGS[..], flags].concat());
    assert_eq!(counts(&file), truth.counts, "{text:.300}\n{said}");
    near(&file.column("t_s"), &truth.times(), 5e-7);
    near(&file.column("command_v"), &truth.commands(), 1e-6);
}

/// A text made of each row: its number, its time in ms, its command in V and its counts.
fn text(truth: &Truth, row: impl Fn(usize, u64, f64, i64) -> String) -> String {
    (truth.rows())
        .map(|k| row(k, truth.ms(k), truth.volts(k), truth.counts[k]))
        .collect()
}

/// A position in rad that rounds to the counts.
fn rad(counts: i64) -> f64 {
    counts as f64 / 720.0 * std::f64::consts::TAU
}

#[test]
fn ros_messages_as_text_and_in_cells() {
    let truth = Truth::steps(0.01, 300);
    let stamp = |ms: u64| (1_700_000_000 + ms / 1000, ms % 1000 * 1_000_000);
    for (list, end) in [("\n- ", ""), (" [", "]")] {
        let echoed = text(&truth, |_, ms, volts, counts| {
            let ((s, ns), rad) = (stamp(ms), rad(counts));
            format!(
                "header:\n  stamp:\n    sec: {s}\n    nanosec: {ns}\n  frame_id: ''\nname:\n- wheel\n\
                 position:{list}{rad:.9}{end}\nvelocity:{list}0.0{end}\neffort:{list}{volts:.9}{end}\n---\n"
            )
        });
        holds(&truth, &echoed, &["--command", "effort[0]:V"]);
    }
    let cells = text(&truth, |_, ms, volts, counts| {
        let ((s, ns), rad) = (stamp(ms), rad(counts));
        format!("{s},{ns},['wheel'],[{rad:.9}],\"({volts:.9},)\"\n")
    });
    let cells = format!("header.stamp.secs,header.stamp.nsecs,name,position,effort\n{cells}");
    let flags = ["--position", "position[0]:rad", "--command", "effort[0]:V"];
    holds(&truth, &cells, &flags);
}

#[test]
fn influx_and_long_tables() {
    let truth = Truth::steps(0.01, 300);
    let lines = text(&truth, |_, ms, volts, counts| {
        let ns = 1_700_000_000_000_000_000 + 1_000_000 * ms;
        format!("motor,id=left counts={counts}i,voltage={volts:.9},mode=\"a b\" {ns}\n")
    });
    holds(&truth, &lines, &[]);
    let long = text(&truth, |_, ms, volts, counts| {
        format!("{ms},counts,{counts}\n{ms},voltage,{volts:.9}\n")
    });
    holds(&truth, &format!("time_ms,signal,value\n{long}"), &[]);
    // One signal after the other, each with its names.
    let stamped = |ms: u64| format!("2026-04-13T12:00:{:02}.{:03}Z", ms / 1000, ms % 1000);
    let names = ",result,table,_time,_value,_field\n";
    let first = text(&truth, |_, ms, _, counts| {
        format!(",,0,{},{counts},counts\n", stamped(ms))
    });
    let second = text(&truth, |_, ms, volts, _| {
        format!(",,1,{},{volts:.9},voltage\n", stamped(ms))
    });
    let flux =
        format!("#group,false,false\n#datatype,string,long\n{names}{first}\n{names}{second}");
    holds(&truth, &flux, &[]);
}

#[test]
fn clocks_of_controllers_and_spreadsheets() {
    let truth = Truth::steps(0.01, 300);
    let table = |name: &str, clock: &dyn Fn(u64) -> String| {
        let rows = text(&truth, |_, ms, volts, counts| {
            format!("{},{volts:.9},{counts}\n", clock(ms))
        });
        format!("{name},voltage,counts\n{rows}")
    };
    let clocks: [(&str, &dyn Fn(u64) -> String); 8] = [
        ("time", &|ms| {
            format!(
                "{}:{:06.3}",
                (ms + 58_000) / 60_000,
                ((ms + 58_000) % 60_000) as f64 / 1e3
            )
        }),
        ("time", &|ms| format!("0:00:{:06.3}", ms as f64 / 1e3)),
        ("time", &|ms| {
            format!("23:59:{:02}:{:03}", 50 + ms / 1000, ms % 1000)
        }),
        ("time", &|ms| format!("T#{ms}ms")),
        ("Timestamp", &|ms| format!("{ms}.000 ms")),
        ("Time", &|ms| {
            format!("{:.10}", 46_023.5 + ms as f64 / 86_400_000.0)
        }),
        ("Date,Time", &|ms| {
            format!("01/05/2026,12:00:{:02};{:03}", ms / 1000, ms % 1000)
        }),
        ("Time,Millisecond", &|ms| {
            format!("12:00:{:02},{}", ms / 1000, ms % 1000)
        }),
    ];
    for (name, clock) in clocks {
        let log = table(name, clock);
        let (file, said) = imported("log.csv", &log, &FLAGS);
        assert_eq!(counts(&file), truth.counts, "{log:.200}\n{said}");
        near(&file.column("t_s"), &truth.times(), 5e-6);
    }
    // Times of Teleplot in s, ms and us: the steps distinguish them.
    for digits in [(3, 1e-3), (0, 1.0), (0, 1e3)] {
        let lines = text(&truth, |_, ms, volts, counts| {
            let time = format!("{:.*}", digits.0, (5000 + ms) as f64 * digits.1);
            format!(">counts:{time}:{counts}\n>voltage:{time}:{volts:.9}\n")
        });
        holds(&truth, &lines, &[]);
    }
}

#[test]
fn a_banner_of_keys_and_numbers_is_no_table() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |_, ms, volts, counts| {
        format!(
            "\"Data\",12:00:{:02};{:03},{volts:.9},{counts}\n",
            ms / 1000,
            ms % 1000
        )
    });
    let banner = "\"Trend Name:\",\"Trend\"\n\"Tags:\",2\n\"Period:\",10 ms\n\"Start:\",5\n\"Header:\",\"Time\",\"Motor_Voltage\",\"Counts\"\n";
    holds(&truth, &format!("{banner}{rows}"), &[]);
}

#[test]
fn cells_with_units_and_hexadecimal_counters() {
    let truth = Truth::steps(0.01, 300);
    let rows = text(&truth, |_, ms, volts, counts| {
        format!("{ms} ms;{volts:.9} V;0x{:08X}\n", counts as u32)
    });
    holds(
        &truth,
        &format!("Time;Motor;Counts\n{rows}"),
        &["--command", "Motor"],
    );
    let rows = text(&truth, |_, ms, volts, counts| {
        format!("[{ms}ms] Counts: {counts} | Voltage: {volts:.9}V\n")
    });
    holds(&truth, &rows, &[]);
}

#[test]
fn names_of_drives_and_pulses_of_servos() {
    let truth = Truth::steps(0.01, 300);
    let foc = text(&truth, |_, ms, volts, counts| {
        format!("{ms},{volts:.9},{volts:.9},0,{:.9}\n", rad(counts))
    });
    let foc = format!("time_ms,target,Uq,Ud,angle\n{foc}");
    let flags = ["--position", "angle:rad"];
    holds(&truth, &foc, &flags);
    let pulses = text(&truth, |_, ms, volts, counts| {
        format!("{ms},{:.6},{counts}\n", 1500.0 + 500.0 * volts / 12.0)
    });
    let pulses = format!("time_ms,esc_us,counts\n{pulses}");
    let flags = ["--command", "esc_us:servo", "--supply", "12"];
    holds(&truth, &pulses, &flags);
    let said = asked("log.csv", &pulses, &FLAGS);
    assert!(said.contains("--command esc_us:servo"), "{said}");
    // A constant column is not the command if another one has pulses.
    let rows = text(&truth, |_, ms, volts, counts| {
        format!(
            "{ms},{:.6},0.01,11.1,{counts}\n",
            1500.0 + 500.0 * volts / 12.0
        )
    });
    let stand = format!("time_ms,ESC signal (us),Torque (N·m),Voltage (V),counts\n{rows}");
    let said = asked("log.csv", &stand, &FLAGS);
    assert!(said.contains("--command 'ESC signal (us):servo'"), "{said}");
}

#[test]
fn an_electrical_speed_is_not_read_as_the_shafts() {
    let truth = Truth::steps(0.01, 300);
    for name in ["erpm", "eRPM[0]", "Motor Electrical Speed (RPM)"] {
        let mut log = format!("time_ms,voltage,{name}\n");
        for k in truth.rows() {
            let before = truth.counts[k.saturating_sub(1)];
            let rpm = (truth.counts[k] - before) as f64 / 720.0 / 0.01 * 60.0;
            let _ = writeln!(
                log,
                "{},{:.6},{:.3}",
                truth.ms(k),
                truth.volts(k),
                7.0 * rpm
            );
        }
        let said = asked("log.csv", &log, &FLAGS);
        assert!(
            said.contains("electrical speed") && said.contains("scale"),
            "{said}"
        );
    }
}

#[test]
fn journals_carriage_returns_and_fortrans_numbers() {
    let truth = Truth::steps(0.01, 300);
    let command = ["--command", "voltage:V"];
    for iso in [false, true] {
        let journal = text(&truth, |_, ms, volts, counts| {
            let (s, us) = (ms / 1000, ms % 1000 * 1000);
            let stamp = match iso {
                true => format!("2026-04-13T06:12:{s:02}.{us:06}+0000"),
                false => format!("Apr 13 06:12:{s:02}.{us:06}"),
            };
            format!("{stamp} rpi motor[812]: counts={counts} voltage={volts:.9}\n")
        });
        holds(&truth, &journal, &command);
    }
    let journal = text(&truth, |_, ms, volts, counts| {
        let s = ms / 1000;
        format!(
            "Apr 13 06:12:{s:02} rpi motor[812]: t_ms={ms} counts={counts} voltage={volts:.9}\n"
        )
    });
    holds(&truth, &journal, &command);
    let returns = text(&truth, |_, ms, volts, counts| {
        format!("{ms},{counts},{volts:.9}\r")
    });
    holds(&truth, &format!("t_ms,counts,voltage\r{returns}"), &command);
    let fortran = text(&truth, |_, ms, volts, counts| {
        let row = format!("{:.9E} {counts:.3E} {volts:.9E}\n", 1e-3 * ms as f64);
        row.replace("E-", "D-").replace('E', "D+0")
    });
    holds(&truth, &format!("t_s counts voltage\n{fortran}"), &command);
}

#[test]
fn unread_formats_are_named_with_their_conversion() {
    let lines = |line: fn(u64) -> String| (0..50).map(line).collect::<Vec<_>>().join("\n");
    let unread = [
        (
            lines(|k| {
                format!(
                    "Stats {k}.0: gcodein=0  mcu: mcu_awake=0.002 bytes_write={k} freq=180003031"
                )
            }),
            "Klipper",
            "l.startswith('Stats ')",
        ),
        (
            lines(|k| format!("X:{k}.00 Y:0.00 Z:0.00 E:0.00 Count X:{} Y:0 Z:0", 80 * k)),
            "Marlin",
            "sed -nE",
        ),
        (
            lines(|k| format!("Recv:  T:{k}.00 /200.00 B:21.00 /60.00 @:127 B@:0")),
            "Marlin",
            "no position",
        ),
        (
            lines(|k| format!("motor/{} {k}", ["pos", "pwm"][k as usize % 2])),
            "MQTT",
            "mosquitto_sub",
        ),
        (
            lines(|k| format!("17{k:08}.5 motor/{} {k}", ["pos", "pwm"][k as usize % 2])),
            "MQTT",
            "(echo time,topic,value; sed 's/ /,/g' FILE) > log.csv",
        ),
        (
            lines(|k| format!("motor/state {{\"t_ms\": {k}, \"pos\": {k}}}")),
            "MQTT",
            "sed 's/^[^{]*//' FILE > log.jsonl",
        ),
        (
            lines(|k| {
                format!("{{\"__REALTIME_TIMESTAMP\":\"17{k:014}\",\"MESSAGE\":\"pos={k}\"}}")
            }),
            "systemd",
            "jq -r",
        ),
    ];
    for (log, form, remedy) in unread {
        let said = asked("log.txt", &log, &FLAGS);
        assert!(said.contains(form) && said.contains(remedy), "{said}");
    }
    let frames = (0..50).fold(String::new(), |mut text, k| {
        let _ = writeln!(text, "(17000000{k:02}.000000) can0 181#{k:08X}");
        text
    });
    let said = asked("log.txt", &frames, &FLAGS);
    assert!(
        said.contains("CAN frames") && said.contains("cantools"),
        "{said}"
    );
    let levels = (0..50).fold(
        "Time [s],Channel 0,Channel 1\n".to_owned(),
        |mut text, k| {
            let (a, b) = [(0, 0), (1, 0), (1, 1), (0, 1)][k % 4];
            let _ = writeln!(text, "{:.6},{a},{b}", 0.001 * k as f64);
            text
        },
    );
    let said = asked("log.txt", &levels, &["--command", "6V@0s"]);
    assert!(said.contains("A and B") && said.contains("awk"), "{said}");
}
