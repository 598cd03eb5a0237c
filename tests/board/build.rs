//! Compiles the sketch for both boards, as the Arduino IDE does, and the C part of the emulator.
//!
//! The flags are those of the Arduino AVR platform (platform.txt) without link-time optimisation, so that symbols
//! keep their names; the core is linked as an archive, as in the IDE.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Location of the core in Debian's arduino-core-avr.
const CORE: &str = "/usr/share/arduino/hardware/arduino/avr";

/// Name of the board, processor, macro of boards.txt, variant of the core.
const BOARDS: [(&str, &str, &str, &str); 2] = [
    ("UNO", "atmega328p", "AVR_UNO", "standard"),
    ("MEGA", "atmega2560", "AVR_MEGA2560", "mega"),
];

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let sketch = here.join("../../firmware-protocol/arduino/motorlab");
    println!("cargo:rerun-if-changed={}", sketch.display());
    println!("cargo:rerun-if-changed=src/shim.c");
    for board in BOARDS {
        let elf = compile(&sketch, &out, board);
        println!("cargo:rustc-env={}_ELF={}", board.0, elf.display());
    }
    cc::Build::new()
        .file("src/shim.c")
        .include("/usr/include/simavr")
        .flag("-std=gnu11")
        .warnings(true)
        .compile("shim");
    println!("cargo:rustc-link-lib=simavr");
    println!("cargo:rustc-link-lib=elf");
}

/// Compiles and links sketch and core; returns the path of the ELF file.
fn compile(sketch: &Path, out: &Path, board: (&str, &str, &str, &str)) -> PathBuf {
    let (name, processor, define, variant) = board;
    let out = out.join(name);
    std::fs::create_dir_all(&out).expect("OUT_DIR can be written");
    let core = Path::new(CORE).join("cores/arduino");
    let flags = [
        "-g".to_owned(),
        "-Os".to_owned(),
        "-ffunction-sections".to_owned(),
        "-fdata-sections".to_owned(),
        format!("-mmcu={processor}"),
        "-DF_CPU=16000000L".to_owned(),
        "-DARDUINO=10819".to_owned(),
        format!("-DARDUINO_{define}"),
        "-DARDUINO_ARCH_AVR".to_owned(),
        // gcc-avr 5.4 lacks this constant in C++, which WString.cpp uses.
        "-DDECIMAL_DIG=__DECIMAL_DIG__".to_owned(),
        format!("-I{}", core.display()),
        format!("-I{CORE}/variants/{variant}"),
    ];
    let cpp = [
        "-std=gnu++11",
        "-fpermissive",
        "-fno-exceptions",
        "-fno-threadsafe-statics",
    ];
    let object = |source: &Path| {
        let mut to = out.join(source.file_name().expect("a file"));
        to.set_extension(match source.extension().and_then(|end| end.to_str()) {
            Some(end) => format!("{end}.o"),
            None => "o".to_owned(),
        });
        let plain_c = source.extension().is_some_and(|end| end == "c");
        let mut compiler = Command::new(if plain_c { "avr-gcc" } else { "avr-g++" });
        compiler.arg("-c").args(&flags);
        if source.starts_with(sketch) {
            compiler.args(["-Wall", "-Wextra", "-Werror"]);
        } else {
            compiler.arg("-w");
        }
        match source.extension().and_then(|end| end.to_str()) {
            Some("c") => compiler.arg("-std=gnu11"),
            Some("S") => compiler.args(["-x", "assembler-with-cpp"]),
            _ => compiler
                .args(cpp)
                .args(["-include", "Arduino.h", "-x", "c++"]),
        };
        run(compiler.arg(source).arg("-o").arg(&to));
        to
    };
    let mut core_objects = Vec::new();
    let mut sources: Vec<PathBuf> = std::fs::read_dir(&core)
        .unwrap_or_else(|error| panic!("{}: {error}; run tests/board/install", core.display()))
        .map(|entry| entry.expect("a directory entry").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|end| ["c", "cpp", "S"].iter().any(|known| end == *known))
        })
        .collect();
    sources.sort();
    for source in sources {
        core_objects.push(object(&source));
    }
    let archive = out.join("core.a");
    let _ = std::fs::remove_file(&archive);
    run(Command::new("avr-ar")
        .arg("rcs")
        .arg(&archive)
        .args(&core_objects));
    let main = object(&sketch.join("motorlab.ino"));
    let elf = out.join("motorlab.elf");
    run(Command::new("avr-gcc")
        .args([
            "-Os",
            "-g",
            "-Wl,--gc-sections",
            &format!("-mmcu={processor}"),
        ])
        .arg("-o")
        .arg(&elf)
        .arg(main)
        .arg(archive)
        .arg("-lm"));
    elf
}

fn run(command: &mut Command) {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?}: {error}; run tests/board/install"));
    assert!(
        output.status.success(),
        "{command:?}\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
