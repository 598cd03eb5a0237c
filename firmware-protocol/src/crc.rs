//! CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, not reflected, no final XOR.
//!
//! Check value, of the ASCII digits `123456789`: 0x29B1. Every burst error of up to 16 bits is detected; of other
//! errors, one frame in 65,536 is not.

/// Value before the first byte.
pub const CRC_START: u16 = 0xFFFF;

const TABLE: [u16; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = (byte as u16) << 8;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 0x8000 == 0 {
                crc << 1
            } else {
                (crc << 1) ^ 0x1021
            };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

/// The CRC of `bytes`, continued from `crc`.
pub fn crc16(crc: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(crc, |crc, &byte| {
        (crc << 8) ^ TABLE[usize::from((crc >> 8) as u8 ^ byte)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_check_value() {
        assert_eq!(crc16(CRC_START, b"123456789"), 0x29B1);
    }

    #[test]
    fn parts_give_the_same_as_the_whole() {
        let whole = crc16(CRC_START, b"motorlab");
        assert_eq!(crc16(crc16(CRC_START, b"motor"), b"lab"), whole);
    }
}
