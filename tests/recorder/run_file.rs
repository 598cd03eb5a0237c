//! Run files of other writers: accepted, noted, refused.

use std::io::Read;

use motorlab::recording::{ReadNote, ReadProblem, Run, read_run, read_run_from, write_run};
use proptest::prelude::*;

const HEADER: &str = "# format = \"motorlab-run/1\"\n# sample_time_s = 0.003\n# counts_per_rev = 720\n# supply_v = 4.5\n# profile = \"step\"\n# complete = true\n";

fn read(text: &str) -> Result<(Run, Vec<ReadNote>), ReadProblem> {
    read_run_from(text.as_bytes(), "run.csv").map_err(|error| error.problem)
}

fn message(text: &str) -> String {
    read_run_from(text.as_bytes(), "run.csv")
        .expect_err("a run that cannot be read")
        .to_string()
}

#[test]
fn the_documented_example_is_read() {
    let text = format!(
        "{HEADER}seq,t_s,host_t_s,command_v,counts,velocity_rad_s,flags\n0,0.000000,1.5,0,0,,\n1,0.003000,1.503,4.5,2,5.8,overrun+saturated\n"
    );
    let (run, notes) = read(&text).unwrap();
    assert_eq!(notes, []);
    assert_eq!(run.counts, [0, 2]);
    assert_eq!(run.t_s, [0.0, 0.003]);
    assert_eq!(run.command, [0.0, 4.5]);
    assert_eq!(run.seq.as_deref(), Some(&[0, 1][..]));
    assert_eq!(run.velocity_rad_s.unwrap(), [None, Some(5.8)]);
    let flags = run.flags.unwrap()[1];
    assert!(flags.overrun && flags.saturated && !flags.dropped);
    assert_eq!(run.header["profile"].as_str(), Some("step"));
}

#[test]
fn only_three_columns_are_needed_and_their_order_is_free() {
    let (run, _) = read(&format!(
        "{HEADER}counts,command_a,t_s\n5,0.1,0\n6,0.2,0.003\n"
    ))
    .unwrap();
    assert_eq!(run.command_kind, motorlab::recording::CommandKind::Current);
    assert_eq!(run.counts, [5, 6]);
}

#[test]
fn line_ends_byte_order_mark_and_spreadsheet_numbers_are_read() {
    let text = format!("\u{feff}{HEADER}t_s,command_v,counts\n0,0,0.0\n\"0.003\", 4.5 ,-2\n");
    let (run, notes) = read(&text.replace('\n', "\r\n")).unwrap();
    assert_eq!(run.counts, [0, -2]);
    assert_eq!(notes, []);
    // A pipe may deliver single bytes.
    let bytes = text.as_bytes();
    let in_blocks = bytes[..1].chain(&bytes[1..2]).chain(&bytes[2..]);
    let (run, _) = read_run_from(in_blocks, "a pipe").unwrap();
    assert_eq!(run.counts, [0, -2]);
    // The column names came from another file, with its byte order mark.
    let text = format!("{HEADER}\u{feff}t_s,command_v,counts\n0,0,7\n");
    for cut in 0..=text.len() {
        let (begin, rest) = text.as_bytes().split_at(cut);
        let run = read_run_from(begin.chain(rest), "a pipe");
        assert_eq!(
            run.unwrap().0.counts,
            [7],
            "in blocks of {cut} and the rest"
        );
    }
}

#[test]
fn a_torn_tail_is_left_out_and_reported() {
    let header = HEADER.replace("# complete = true\n", "");
    let whole = format!("{header}t_s,command_v,counts\n0,0,0\n0.003,4.5,12\n0.006,4.5,134\n");
    let last_row = "0.006,4.5,134\n".len();
    for cut in 1..last_row {
        let text = &whole[..whole.len() - cut];
        let (run, notes) = read(text).unwrap();
        assert_eq!(run.counts, [0, 12], "{cut}: {notes:?}");
        assert_eq!(
            notes,
            [ReadNote::TornTail { row: 9 }, ReadNote::NotComplete],
            "{cut}"
        );
    }
}

#[test]
fn errors_name_file_row_and_column() {
    let table = |rows: &str| format!("{HEADER}t_s,command_v,counts\n{rows}");
    assert_eq!(
        message(&table("0,0,0\n0.003,x,1\n0.006,0,2\n")),
        "run.csv: row 9, column `command_v`: `x` is not a finite number\nhint: correct the cell, or remove the row"
    );
    assert_eq!(
        message(&table("0,0,0\n0.003,NaN,1\n")),
        "run.csv: row 9, column `command_v`: `NaN` is not a finite number\nhint: correct the cell, or remove the row"
    );
    assert!(message(&table("0,inf,0\n0.1,0,0\n")).contains("row 8, column `command_v`"));
    assert!(
        message(&table("0,0,99999999999999999999\n0.1,0,0\n")).contains("row 8, column `counts`")
    );
    assert!(message(&table("0,0,1.5\n0.1,0,0\n")).contains("row 8, column `counts`: `1.5`"));
    assert_eq!(
        message(&table("0,0\n0.003,0,1\n")),
        "run.csv: row 8 has 2 cells where the columns are 3\nhint: complete the row, or remove it"
    );
    assert!(message(&table("0,0,0\n0.003,0,1\n0.003,0,2\n")).contains("row 10, column `t_s`"));
    assert!(message(&table("0,0,0\n3601,0,1\n")).contains("row 9, column `t_s`: time leaps"));
    assert!(matches!(read(&table("")), Err(ReadProblem::Empty)));
    assert!(matches!(read(HEADER), Err(ReadProblem::NoColumns)));
    assert!(
        message(&format!("{HEADER}time,volts,pos\n0,0,0\n"))
            .contains("no column `t_s` (it names: time, volts, pos)")
    );
    assert!(message(&format!("{HEADER}t_s,t_s,counts\n0,0,0\n")).contains("`t_s` twice"));
    assert!(message("# counts_per_rev = 720\n# oops\nt_s\n").contains("line 2"));
    assert!(message("t_s,command_v,counts\n0,0,0\n").contains("lacks `counts_per_rev`"));
    assert!(message(&HEADER.replace("720", "0")).contains("`counts_per_rev` is 0"));
    assert!(message(&HEADER.replace("run/1", "run/7")).contains("motorlab-run/7"));
}

#[test]
fn a_header_without_sample_time_takes_it_from_the_rows() {
    let header = HEADER.replace("# sample_time_s = 0.003\n", "");
    let (run, notes) = read(&format!(
        "{header}t_s,command_v,counts\n5,0,0\n5.01,0,0\n5.02,0,1\n"
    ))
    .unwrap();
    assert!((run.sample_time_s - 0.01).abs() < 1e-9);
    assert_eq!(run.t_s[0], 0.0);
    assert_eq!(notes.len(), 2);
}

#[test]
fn other_files_fail_early_and_with_little_memory() {
    assert!(read_run_from(std::io::repeat(0), "/dev/zero").is_err());
    let endless = HEADER.as_bytes().chain(std::io::repeat(0));
    let error = read_run_from(endless, "endless").unwrap_err();
    assert!(
        error.to_string().contains("longer than 65536 bytes"),
        "{error}"
    );
    let comments = std::io::repeat(b'#');
    assert!(read_run_from(comments, "hashes").is_err());
    assert!(read_run_from(&b"\xff\xfe\x00t_s,command_v"[..], "utf16").is_err());
    let error = read_run(std::path::Path::new("no/such/run.csv")).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("no/such/run.csv: cannot be read")
    );
    assert!(
        read_run(std::path::Path::new("."))
            .unwrap_err()
            .to_string()
            .contains("directory")
    );
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_read_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = read_run_from(&bytes[..], "noise");
        let mut text = format!("{HEADER}t_s,command_v,counts\n").into_bytes();
        text.extend_from_slice(&bytes);
        let _ = read_run_from(&text[..], "noise");
    }

    #[test]
    fn a_written_run_is_read_back_unchanged(
        rows in proptest::collection::vec((1e-6f64..10.0, -50.0f64..50.0, any::<i32>()), 1..50),
    ) {
        let mut t_s = 0.0;
        let mut run = Run { sample_time_s: 0.003, counts_per_rev: 720.0, complete: true, ..Run::default() };
        run.header.insert("sample_time_s".into(), 0.003.into());
        run.header.insert("counts_per_rev".into(), 720.into());
        run.header.insert("kept".into(), "as it is".into());
        for (step, command, counts) in rows {
            run.t_s.push(t_s);
            run.command.push(command);
            run.counts.push(i64::from(counts));
            t_s += step;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        write_run(&run, &path).unwrap();
        let (read, notes) = read_run(&path).unwrap();
        prop_assert_eq!(notes, []);
        prop_assert_eq!(&read.command, &run.command);
        prop_assert_eq!(&read.counts, &run.counts);
        prop_assert_eq!(&read.t_s, &run.t_s);
        prop_assert_eq!(read.header["kept"].as_str(), Some("as it is"));
    }
}
