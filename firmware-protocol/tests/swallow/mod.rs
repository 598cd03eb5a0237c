//! All processing of arbitrary bytes, for the stream tests and the fuzz target.

use firmware_protocol::{
    BoardFields, BoardMessage, FrameDecoder, HostMessage, MAX_WIRE, SequenceUnwrapper,
};

/// Decodes, parses and encodes again; panics only on a bug of the crate.
pub fn swallow(bytes: &[u8]) {
    let mut decoder = FrameDecoder::new();
    let mut sequence = SequenceUnwrapper::new();
    for &byte in bytes {
        let Some(Ok(raw)) = decoder.push(byte) else {
            continue;
        };
        for bits in 0..8 {
            let parsed = BoardMessage::parse(raw, BoardFields::from_bits(bits));
            if let Ok(BoardMessage::Data(sample)) = parsed {
                sequence.push(sample.sequence);
            }
            if let Ok(message) = parsed {
                let mut wire = [0; MAX_WIRE];
                assert!(message.encode(&mut wire).is_some());
            }
        }
        if let Ok(message) = HostMessage::parse(raw) {
            let mut wire = [0; MAX_WIRE];
            assert!(message.encode(&mut wire).is_some());
        }
    }
}
