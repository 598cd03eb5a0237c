//! Reads raw logs from their documentation alone, without the program's code.

use std::path::Path;

/// Everything the board sent.
fn from_board(log: &Path) -> Vec<u8> {
    let text = std::fs::read_to_string(log).expect("a log");
    let mut bytes = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace().skip(1);
        if line.starts_with('#') || words.next() != Some("<") {
            continue;
        }
        let (_, payload) = line.split_once("< ").expect("an arrow");
        if let Some(quoted) = payload.strip_prefix('"') {
            let plain = quoted.trim_end_matches('"');
            bytes.extend(plain.replace("\\r", "\r").replace("\\n", "\n").bytes());
        } else {
            let pairs = payload.split_whitespace();
            bytes.extend(pairs.map(|pair| u8::from_str_radix(pair, 16).expect("two digits")));
        }
    }
    bytes
}

/// CRC-16/CCITT-FALSE, bit by bit.
fn crc(bytes: &[u8]) -> u16 {
    let mut crc = 0xffff_u16;
    for &byte in bytes {
        crc ^= u16::from(byte) << 8;
        for _ in 0..8 {
            let carry = crc & 0x8000 != 0;
            crc <<= 1;
            if carry {
                crc ^= 0x1021;
            }
        }
    }
    crc
}

/// Contents of a COBS-encoded frame, without its CRC; `None` for a damaged one.
fn unstuffed(frame: &[u8]) -> Option<Vec<u8>> {
    let mut content = Vec::new();
    let mut rest = frame;
    while let Some((&code, after)) = rest.split_first() {
        let run = usize::from(code).checked_sub(1)?;
        content.extend(after.get(..run)?);
        rest = &after[run..];
        if code < 0xff && !rest.is_empty() {
            content.push(0);
        }
    }
    let split = content.len().checked_sub(2)?;
    let crc_sent = u16::from_le_bytes([content[split], content[split + 1]]);
    content.truncate(split);
    (crc(&content) == crc_sent).then_some(content)
}

/// `(sequence, counts)` of the complete DATA frames, each once; for logs shorter than 65,536 samples.
pub fn frames(log: &Path) -> Vec<(u64, i64)> {
    let bytes = from_board(log);
    let mut samples: Vec<(u64, i64)> = Vec::new();
    for content in bytes.split(|&byte| byte == 0).filter_map(unstuffed) {
        if content.first() != Some(&4) {
            continue;
        }
        let sequence = u64::from(u16::from_le_bytes([content[1], content[2]]));
        let counts = i32::from_le_bytes([content[7], content[8], content[9], content[10]]);
        if samples.last().is_none_or(|&(last, _)| last < sequence) {
            samples.push((sequence, i64::from(counts)));
        }
    }
    samples
}

/// The lines of three integers that a sketch printed.
pub fn printed_numbers(log: &Path) -> Vec<[f64; 3]> {
    let text = String::from_utf8(from_board(log)).expect("text");
    text.lines()
        .filter_map(|line| {
            let numbers: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
            numbers.ok()?.try_into().ok()
        })
        .collect()
}
