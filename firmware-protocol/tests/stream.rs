//! Damage in whole streams: lost frames, and no panics.

mod swallow;

use firmware_protocol::{BoardFields, BoardMessage, FrameDecoder, MAX_WIRE, Sample, SampleFlags};
use proptest::prelude::*;
use swallow::swallow;

fn sample(k: u16) -> Sample {
    Sample {
        sequence: k,
        time_us: u32::from(k) * 3000,
        counts: i32::from(k) * 2 - 300,
        command_mv: 4500,
        flags: SampleFlags::default(),
        current_ma: None,
        supply_mv: None,
    }
}

/// Frames of samples 0 to `count`, and the start of each.
fn stream(count: u16) -> (Vec<u8>, Vec<usize>) {
    let mut bytes = Vec::new();
    let mut starts = Vec::new();
    for k in 0..count {
        let mut wire = [0; MAX_WIRE];
        let length = BoardMessage::Data(sample(k)).encode(&mut wire).unwrap();
        starts.push(bytes.len());
        bytes.extend_from_slice(&wire[..length]);
    }
    (bytes, starts)
}

fn samples(bytes: &[u8]) -> Vec<Sample> {
    let mut decoder = FrameDecoder::new();
    let mut found = Vec::new();
    for &byte in bytes {
        if let Some(Ok(raw)) = decoder.push(byte)
            && let Ok(BoardMessage::Data(sample)) = BoardMessage::parse(raw, BoardFields::default())
        {
            found.push(sample);
        }
    }
    found
}

#[test]
fn every_single_bit_flip_is_detected_and_loses_at_most_two_frames() {
    let (bytes, starts) = stream(6);
    for at in 0..bytes.len() {
        for bit in 0..8 {
            let mut hurt = bytes.clone();
            hurt[at] ^= 1 << bit;
            let found = samples(&hurt);
            let frame = starts.partition_point(|&start| start <= at) - 1;
            // A flipped ending 0 joins this frame and the next.
            let ending = starts.get(frame + 1).map_or(bytes.len(), |&next| next) - 1;
            let hit = if at == ending {
                frame..=frame + 1
            } else {
                frame..=frame
            };
            let wanted: Vec<_> = (0..6u16)
                .filter(|k| !hit.contains(&usize::from(*k)))
                .map(sample)
                .collect();
            assert_eq!(found, wanted, "byte {at}, bit {bit}");
        }
    }
}

#[test]
fn half_a_million_damaged_streams_are_decoded_without_a_panic() {
    // Damaged frames are decoded further than noise; both are tested.
    let (clean, _) = stream(8);
    let mut state = 1u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as usize
    };
    for round in 0..500_000 {
        let mut bytes = clean.clone();
        for _ in 0..=round % 25 {
            let at = random() % bytes.len();
            match random() % 4 {
                0 => bytes[at] = random() as u8,
                1 => bytes[at] = 0,
                2 => drop(bytes.remove(at)),
                _ => bytes.insert(at, random() as u8),
            }
        }
        swallow(&bytes);
        let noise: Vec<u8> = (0..64).map(|_| random() as u8).collect();
        swallow(&noise);
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_are_decoded_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        swallow(&bytes);
    }

    #[test]
    fn after_any_noise_the_second_frame_is_read(
        noise in proptest::collection::vec(any::<u8>(), 0..200),
    ) {
        let (clean, _) = stream(4);
        let mut bytes = noise;
        bytes.extend_from_slice(&clean);
        let found = samples(&bytes);
        prop_assert!(found.ends_with(&[sample(1), sample(2), sample(3)]));
    }

    #[test]
    fn missing_bytes_lose_only_the_frames_that_they_are_in(from in 0usize..360, length in 1usize..60) {
        let (bytes, starts) = stream(20);
        let to = (from + length).min(bytes.len());
        let mut hurt = bytes[..from].to_vec();
        hurt.extend_from_slice(&bytes[to..]);
        let found = samples(&hurt);
        let hit = |k: usize| {
            let end = starts.get(k + 1).copied().unwrap_or(bytes.len());
            starts[k] < to && end > from
        };
        // A frame cut by the hole continues in the frame right after it.
        let torn = starts.iter().any(|&s| s < from && from < s + 18);
        let joined = |k: usize| torn && starts[k] == to;
        for (k, start) in starts.iter().enumerate() {
            let wanted = sample(k as u16);
            prop_assert!(hit(k) || joined(k) || found.contains(&wanted), "frame {k} at {start}");
        }
        for got in found {
            prop_assert_eq!(got, sample(got.sequence));
        }
    }
}
