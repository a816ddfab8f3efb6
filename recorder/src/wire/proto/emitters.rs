//! `trocar.EmitterFrame`: what the localizer saw, without loss, and without the room left over in the bus message.

use bus::message::{self, EmitterSight, TooManyEmitters};

use super::DecodeError;

/// The emitters that are meant of a [`message::EmitterFrame`], in columns.
#[derive(Clone, PartialEq, prost::Message)]
pub struct EmitterFrame {
    /// See [`message::EmitterFrame::seq`].
    #[prost(uint64, tag = "1")]
    pub seq: u64,
    /// See [`message::EmitterFrame::t_device_ns`].
    #[prost(sint64, tag = "2")]
    pub t_device_ns: i64,
    /// See [`message::EmitterFrame::t_capture_ns`].
    #[prost(sint64, tag = "3")]
    pub t_capture_ns: i64,
    /// See [`message::EmitterFrame::t_publish_ns`].
    #[prost(sint64, tag = "4")]
    pub t_publish_ns: i64,
    /// Numbers of the emitters of the tool's marker.
    #[prost(uint32, repeated, tag = "5")]
    pub tool_emitter: Vec<u32>,
    /// Their places in the localizer's frame, mm, 3 values each.
    #[prost(double, repeated, tag = "6")]
    pub tool_mm: Vec<f64>,
    /// Numbers of the emitters of the marker on the patient.
    #[prost(uint32, repeated, tag = "7")]
    pub reference_emitter: Vec<u32>,
    /// Their places in the localizer's frame, mm, 3 values each.
    #[prost(double, repeated, tag = "8")]
    pub reference_mm: Vec<f64>,
}

fn columns(sights: &[EmitterSight]) -> (Vec<u32>, Vec<f64>) {
    let numbers = sights.iter().map(|sight| sight.emitter).collect();
    (numbers, sights.iter().flat_map(|sight| sight.place_mm).collect())
}

impl TryFrom<&message::EmitterFrame> for EmitterFrame {
    type Error = TooManyEmitters;

    fn try_from(frame: &message::EmitterFrame) -> Result<Self, TooManyEmitters> {
        let (tool_emitter, tool_mm) = columns(frame.tool()?);
        let (reference_emitter, reference_mm) = columns(frame.reference()?);
        Ok(Self {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: frame.t_capture_ns,
            t_publish_ns: frame.t_publish_ns,
            tool_emitter,
            tool_mm,
            reference_emitter,
            reference_mm,
        })
    }
}

fn sights(seq: u64, field: &'static str, numbers: &[u32], mm: &[f64]) -> Result<Vec<EmitterSight>, DecodeError> {
    let (expected, found) = (3 * numbers.len(), mm.len());
    if expected != found {
        return Err(DecodeError::Length {
            seq,
            field,
            expected,
            found,
        });
    }
    let places = mm.chunks_exact(3).zip(numbers);
    let sight = |(place, &emitter): (&[f64], &u32)| EmitterSight {
        place_mm: std::array::from_fn(|i| place[i]),
        emitter,
        reserved: 0,
    };
    Ok(places.map(sight).collect())
}

impl TryFrom<&EmitterFrame> for message::EmitterFrame {
    type Error = DecodeError;

    fn try_from(frame: &EmitterFrame) -> Result<Self, DecodeError> {
        let tool = sights(frame.seq, "tool_mm", &frame.tool_emitter, &frame.tool_mm)?;
        let reference = sights(frame.seq, "reference_mm", &frame.reference_emitter, &frame.reference_mm)?;
        let mut message = Self {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: frame.t_capture_ns,
            t_publish_ns: frame.t_publish_ns,
            ..Self::EMPTY
        };
        message.set(tool.into_iter(), reference.into_iter())?;
        Ok(message)
    }
}

/// The bus message in the bytes of a recorded `trocar.EmitterFrame`.
///
/// # Errors
/// [`DecodeError`].
pub fn decode_emitters(bytes: &[u8]) -> Result<message::EmitterFrame, DecodeError> {
    let frame: EmitterFrame = prost::Message::decode(bytes).map_err(|source| DecodeError::Protobuf {
        schema: crate::wire::schema::EMITTER_SCHEMA,
        source,
    })?;
    (&frame).try_into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use prost::Message as _;

    fn bits(frame: &message::EmitterFrame) -> Vec<u64> {
        let mut bits = vec![frame.seq, u64::from(frame.tool_seen), u64::from(frame.reference_seen)];
        bits.extend([frame.t_device_ns, frame.t_capture_ns, frame.t_publish_ns].map(i64::cast_unsigned));
        for sight in frame.tool_sights.iter().chain(&frame.reference_sights) {
            bits.extend(sight.place_mm.map(f64::to_bits));
            bits.push(sight.emitter.into());
        }
        bits
    }

    fn any_sights() -> impl Strategy<Value = Vec<EmitterSight>> {
        let sight = (prop::array::uniform3(any::<u64>()), any::<u32>()).prop_map(|(place, emitter)| EmitterSight {
            place_mm: place.map(f64::from_bits),
            emitter,
            reserved: 0,
        });
        prop::collection::vec(sight, 0..=message::EmitterFrame::MOST)
    }

    proptest! {
        #[test]
        fn frames_come_back_bit_for_bit(
            numbers in any::<(u64, i64, i64, i64)>(),
            tool in any_sights(),
            reference in any_sights(),
        ) {
            let mut frame = message::EmitterFrame {
                seq: numbers.0,
                t_device_ns: numbers.1,
                t_capture_ns: numbers.2,
                t_publish_ns: numbers.3,
                ..message::EmitterFrame::EMPTY
            };
            frame.set(tool.into_iter(), reference.into_iter()).unwrap();
            let bytes = EmitterFrame::try_from(&frame).unwrap().encode_to_vec();
            prop_assert_eq!(bits(&decode_emitters(&bytes).unwrap()), bits(&frame));
        }

        #[test]
        fn hostile_bytes_are_refused_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let _ = decode_emitters(&bytes);
        }
    }

    #[test]
    fn impossible_frames_are_refused_by_name() {
        let many = EmitterFrame {
            seq: 4,
            tool_emitter: vec![0; 33],
            tool_mm: vec![0.0; 99],
            ..EmitterFrame::default()
        };
        let text = decode_emitters(&many.encode_to_vec()).unwrap_err().to_string();
        assert_eq!(
            text,
            "frame 4 of the localizer: 33 emitters of one marker; at most 32 are allowed"
        );
        let short = EmitterFrame {
            reference_emitter: vec![1, 2],
            reference_mm: vec![0.0; 5],
            ..many
        };
        let text = decode_emitters(
            &EmitterFrame {
                tool_emitter: vec![],
                tool_mm: vec![],
                ..short
            }
            .encode_to_vec(),
        );
        assert_eq!(
            text.unwrap_err().to_string(),
            "message 4: reference_mm has 5 values instead of 6"
        );
        let hostile = message::EmitterFrame {
            tool_seen: 33,
            ..message::EmitterFrame::EMPTY
        };
        assert!(EmitterFrame::try_from(&hostile).is_err());
    }
}
