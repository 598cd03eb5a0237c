//! Memory use of the sketch.

use std::process::Command;

use emulated_board::wiring::BoardKind;

/// The sketch's README with the documented figures.
const README: &str = include_str!("../../../../firmware-protocol/arduino/motorlab/README.md");

/// Flash, and RAM without the stack, in bytes, from the linker.
fn sizes(kind: BoardKind) -> (u32, u32) {
    let output = Command::new("avr-size").arg(kind.firmware()).output();
    let text = String::from_utf8(output.expect("avr-size runs").stdout).expect("text");
    let numbers: Vec<u32> = text
        .lines()
        .nth(1)
        .expect("a line of sizes")
        .split_whitespace()
        .filter_map(|cell| cell.parse().ok())
        .collect();
    let [code, initialised, zeroed, ..] = numbers[..] else {
        panic!("{text}");
    };
    (code + initialised, initialised + zeroed)
}

/// The documented figure in kB in `row` for a board.
fn documented(row: &str, kind: BoardKind) -> f64 {
    let line = README.lines().find(|line| line.contains(row));
    let cells: Vec<&str> = line.expect("the row").split('|').collect();
    let cell = cells[2 + BoardKind::ALL
        .iter()
        .position(|&k| k == kind)
        .expect("known")];
    let figure = cell.trim().strip_suffix(" kB").expect("a figure in kB");
    figure.parse().expect("a number")
}

#[test]
fn the_sketch_fits_and_has_the_size_of_its_readme() {
    for (kind, flash_limit, ram_limit) in [
        (BoardKind::Uno, 32_256, 2_048),
        (BoardKind::Mega, 253_952, 8_192),
    ] {
        let (flash, ram) = sizes(kind);
        println!("{kind:?}: {flash} bytes of flash, {ram} of RAM");
        assert!(flash < flash_limit, "{flash}");
        // The stack has nested interrupts, a frame and its callers' frames.
        assert!(ram + 512 < ram_limit, "{ram} leaves too little stack");
        // Compilers differ by some percent.
        for (row, bytes) in [("| flash (", flash), ("| RAM (", ram)] {
            let said = documented(row, kind) * 1000.0;
            assert!((f64::from(bytes) / said - 1.0).abs() < 0.15, "{row} {said}");
        }
    }
}
