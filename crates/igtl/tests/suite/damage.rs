//! Golden messages cut at every byte, and with every byte changed: no panic, and nothing with a wrong CRC is given.

use igtl::{Fault, HEADER_BYTES, Limits, crc::bitwise, decode};

use crate::support::{golden, stream};

#[test]
fn cut_at_every_byte_it_is_called_cut() {
    for (name, bytes) in golden() {
        for end in 0..bytes.len() {
            let error = decode(&bytes[..end], &Limits::default()).unwrap_err();
            let Fault::Truncated { found, needed } = error.fault else {
                panic!("{name} at {end}: {error}")
            };
            let all = if end < HEADER_BYTES { HEADER_BYTES } else { bytes.len() };
            assert_eq!((found, needed), (end as u64, all as u64), "{name}");
        }
        // In a stream that ends there, the same.
        for end in (1..bytes.len()).step_by(7) {
            let said = stream(&bytes[..end], &[3, 1, 60], Limits::default());
            assert!(
                matches!(&said[..], [Err(e)] if matches!(e.fault, Fault::Truncated { .. })),
                "{name} at {end}"
            );
        }
    }
}

#[test]
fn no_changed_byte_makes_a_message_with_a_wrong_crc() {
    for (name, good) in golden() {
        for at in 0..good.len() {
            for change in [1, 2, 3, 4, 8, 16, 32, 64, 128, 255] {
                let mut bytes = good.clone();
                bytes[at] ^= change;
                match decode(&bytes, &Limits::default()) {
                    Err(error) => assert!(!error.to_string().is_empty()),
                    Ok((message, taken)) => {
                        assert!(
                            at < 42,
                            "{name}: byte {at} of the body, its length or its CRC was changed"
                        );
                        let said = u64::from_be_bytes(bytes[50..58].try_into().unwrap());
                        assert_eq!(bitwise(&bytes[58..taken]), said, "{name} at {at}");
                        drop(message.fields().json());
                    }
                }
            }
        }
    }
}

#[test]
fn a_message_behind_a_damaged_one_is_found() {
    let mut longest = 0;
    for (name, good) in golden() {
        for at in (HEADER_BYTES..good.len()).step_by(11) {
            let mut bytes = good.clone();
            bytes[at] ^= 0x20;
            bytes.extend(&good);
            let said = stream(&bytes, &[17, 4096], Limits::default());
            assert!(
                matches!(&said[..], [Err(e), Ok(_)] if matches!(e.fault, Fault::Crc { .. })),
                "{name} at {at}: {said:?}"
            );
            longest = longest.max(said.len());
        }
    }
    assert!(longest == 0 || longest == 2);
}
