//! Consistent Overhead Byte Stuffing (Cheshire and Baker, 1999) of frames shorter than 254 bytes.
//!
//! The encoded bytes contain no 0, so that a 0 ends a frame wherever a reader begins. A frame of this length grows by
//! exactly one byte.

/// Longest input of a single code byte.
pub const MAX_INPUT: usize = 253;

/// Encodes `input` into `output` without the ending 0; returns the length, or `None` if it does not fit.
pub fn encode(input: &[u8], output: &mut [u8]) -> Option<usize> {
    if input.len() > MAX_INPUT || output.len() < input.len() + 1 {
        return None;
    }
    let (mut code_at, mut code) = (0, 1u8);
    for (k, &byte) in input.iter().enumerate() {
        if byte == 0 {
            output[code_at] = code;
            (code_at, code) = (k + 1, 1);
        } else {
            output[k + 1] = byte;
            code += 1;
        }
    }
    output[code_at] = code;
    Some(input.len() + 1)
}

/// Decodes in place; returns the length, or `None` for an invalid encoding.
pub fn decode_in_place(bytes: &mut [u8]) -> Option<usize> {
    let mut read = 0;
    let mut written = 0;
    while read < bytes.len() {
        let code = usize::from(bytes[read]);
        if code == 0 || read + code > bytes.len() {
            return None;
        }
        let run = read + 1..read + code;
        if bytes[run.clone()].contains(&0) {
            return None;
        }
        bytes.copy_within(run, written);
        written += code - 1;
        read += code;
        if code < 0xFF && read < bytes.len() {
            bytes[written] = 0;
            written += 1;
        }
    }
    Some(written)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_examples_of_the_paper() {
        for (plain, stuffed) in [
            (&[0x00][..], &[0x01, 0x01][..]),
            (&[0x00, 0x00], &[0x01, 0x01, 0x01]),
            (&[0x11, 0x22, 0x00, 0x33], &[0x03, 0x11, 0x22, 0x02, 0x33]),
            (&[0x11, 0x22, 0x33, 0x44], &[0x05, 0x11, 0x22, 0x33, 0x44]),
            (&[0x11, 0x00, 0x00, 0x00], &[0x02, 0x11, 0x01, 0x01, 0x01]),
        ] {
            let mut out = [0xAA; 8];
            let length = encode(plain, &mut out).unwrap();
            assert_eq!(&out[..length], stuffed);
            let length = decode_in_place(&mut out[..length]).unwrap();
            assert_eq!(&out[..length], plain);
        }
    }

    proptest! {
        #[test]
        fn stuffed_bytes_are_unstuffed_to_the_same_bytes(plain in proptest::collection::vec(any::<u8>(), 0..=MAX_INPUT)) {
            let mut out = [0; MAX_INPUT + 1];
            let length = encode(&plain, &mut out).unwrap();
            prop_assert!(!out[..length].contains(&0));
            let length = decode_in_place(&mut out[..length]).unwrap();
            prop_assert_eq!(&out[..length], &plain[..]);
        }

        #[test]
        fn arbitrary_bytes_are_unstuffed_without_a_panic(mut bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            decode_in_place(&mut bytes);
        }
    }
}
