//! `trocar.MarkerFrame`: the poses of markers as a localizer made them, without loss, and without the room left over in the bus message.

use bus::message::{self, MarkerSight, MarkersError};

use super::{DecodeError, values};

/// The markers that are meant of a [`message::MarkerFrame`], in columns.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MarkerFrame {
    /// See [`message::MarkerFrame::seq`].
    #[prost(uint64, tag = "1")]
    pub seq: u64,
    /// See [`message::MarkerFrame::t_device_ns`].
    #[prost(sint64, tag = "2")]
    pub t_device_ns: i64,
    /// See [`message::MarkerFrame::t_capture_ns`].
    #[prost(sint64, tag = "3")]
    pub t_capture_ns: i64,
    /// See [`message::MarkerFrame::t_publish_ns`].
    #[prost(sint64, tag = "4")]
    pub t_publish_ns: i64,
    /// See [`message::MarkerFrame::t_arrival_ns`].
    #[prost(sint64, tag = "5")]
    pub t_arrival_ns: i64,
    /// See [`message::MarkerFrame::t_uncertain_ns`].
    #[prost(sint64, tag = "6")]
    pub t_uncertain_ns: i64,
    /// See [`message::MarkerFrame::clock`].
    #[prost(uint32, tag = "7")]
    pub clock: u32,
    /// See [`message::MarkerFrame::device`], without the zeros behind.
    #[prost(bytes = "vec", tag = "8")]
    pub device: Vec<u8>,
    /// Numbers of the markers.
    #[prost(uint32, repeated, tag = "9")]
    pub marker: Vec<u32>,
    /// Their [`MarkerSight::status`].
    #[prost(uint32, repeated, tag = "10")]
    pub status: Vec<u32>,
    /// (w, x, y, z), 4 values each.
    #[prost(double, repeated, tag = "11")]
    pub q: Vec<f64>,
    /// mm, 3 values each.
    #[prost(double, repeated, tag = "12")]
    pub t_mm: Vec<f64>,
    /// mm.
    #[prost(double, repeated, tag = "13")]
    pub error_mm: Vec<f64>,
    /// ns.
    #[prost(sint64, repeated, tag = "14")]
    pub age_ns: Vec<i64>,
}

impl TryFrom<&message::MarkerFrame> for MarkerFrame {
    type Error = MarkersError;

    fn try_from(frame: &message::MarkerFrame) -> Result<Self, MarkersError> {
        let sights = frame.sights()?;
        let named = frame
            .device
            .iter()
            .rposition(|&byte| byte != 0)
            .map_or(0, |last| last + 1);
        Ok(Self {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: frame.t_capture_ns,
            t_publish_ns: frame.t_publish_ns,
            t_arrival_ns: frame.t_arrival_ns,
            t_uncertain_ns: frame.t_uncertain_ns,
            clock: frame.clock,
            device: frame.device[..named].to_vec(),
            marker: sights.iter().map(|sight| sight.marker).collect(),
            status: sights.iter().map(|sight| sight.status).collect(),
            q: sights.iter().flat_map(|sight| sight.q).collect(),
            t_mm: sights.iter().flat_map(|sight| sight.t_mm).collect(),
            error_mm: sights.iter().map(|sight| sight.error_mm).collect(),
            age_ns: sights.iter().map(|sight| sight.age_ns).collect(),
        })
    }
}

impl MarkerFrame {
    /// Each column must have as many values as there are markers.
    fn sights(&self) -> Result<Vec<MarkerSight>, DecodeError> {
        let n = self.marker.len();
        let columns = [
            ("status", n, self.status.len()),
            ("q", 4 * n, self.q.len()),
            ("t_mm", 3 * n, self.t_mm.len()),
            ("error_mm", n, self.error_mm.len()),
            ("age_ns", n, self.age_ns.len()),
        ];
        if let Some(&(field, expected, found)) = columns.iter().find(|(_, expected, found)| expected != found) {
            let seq = self.seq;
            return Err(DecodeError::Length {
                seq,
                field,
                expected,
                found,
            });
        }
        let sight = |i: usize| {
            Ok(MarkerSight {
                q: values(self.seq, "q", &self.q[4 * i..4 * i + 4])?,
                t_mm: values(self.seq, "t_mm", &self.t_mm[3 * i..3 * i + 3])?,
                error_mm: self.error_mm[i],
                age_ns: self.age_ns[i],
                marker: self.marker[i],
                status: self.status[i],
            })
        };
        (0..n).map(sight).collect()
    }
}

impl TryFrom<&MarkerFrame> for message::MarkerFrame {
    type Error = DecodeError;

    fn try_from(frame: &MarkerFrame) -> Result<Self, DecodeError> {
        let mut message = Self {
            seq: frame.seq,
            t_device_ns: frame.t_device_ns,
            t_capture_ns: frame.t_capture_ns,
            t_publish_ns: frame.t_publish_ns,
            t_arrival_ns: frame.t_arrival_ns,
            t_uncertain_ns: frame.t_uncertain_ns,
            clock: frame.clock,
            ..Self::EMPTY
        };
        let (expected, found) = (message.device.len(), frame.device.len());
        let room = message.device.get_mut(..found).ok_or(DecodeError::Length {
            seq: frame.seq,
            field: "device",
            expected,
            found,
        })?;
        room.copy_from_slice(&frame.device);
        message.set(&frame.sights()?)?;
        // A marker that stands twice was never recorded by us.
        message.sights()?;
        Ok(message)
    }
}

/// The bus message in the bytes of a recorded `trocar.MarkerFrame`.
///
/// # Errors
/// [`DecodeError`].
pub fn decode_markers(bytes: &[u8]) -> Result<message::MarkerFrame, DecodeError> {
    let frame: MarkerFrame = prost::Message::decode(bytes).map_err(|source| DecodeError::Protobuf {
        schema: crate::wire::schema::MARKER_SCHEMA,
        source,
    })?;
    (&frame).try_into()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use prost::Message as _;

    use super::*;

    fn bits(frame: &message::MarkerFrame) -> Vec<u64> {
        let mut bits = vec![frame.seq, frame.clock.into(), frame.count.into()];
        let times = [
            frame.t_device_ns,
            frame.t_capture_ns,
            frame.t_publish_ns,
            frame.t_arrival_ns,
            frame.t_uncertain_ns,
        ];
        bits.extend(times.map(i64::cast_unsigned));
        bits.extend(frame.device.map(u64::from));
        for sight in &frame.sights {
            bits.extend(sight.q.map(f64::to_bits));
            bits.extend(sight.t_mm.map(f64::to_bits));
            bits.extend([sight.error_mm.to_bits(), sight.age_ns.cast_unsigned()]);
            bits.extend([sight.marker, sight.status].map(u64::from));
        }
        bits
    }

    /// Any numbers, for markers that differ.
    fn any_sights() -> impl Strategy<Value = Vec<MarkerSight>> {
        let sight = (prop::array::uniform8(any::<u64>()), any::<i64>(), any::<u32>());
        let sight = sight.prop_map(|(numbers, age_ns, status)| {
            let numbers = numbers.map(f64::from_bits);
            MarkerSight {
                q: std::array::from_fn(|i| numbers[i]),
                t_mm: std::array::from_fn(|i| numbers[4 + i]),
                error_mm: numbers[7],
                age_ns,
                marker: 0,
                status,
            }
        });
        let numbered = |sights: Vec<MarkerSight>| {
            (0..)
                .zip(sights)
                .map(|(marker, sight)| MarkerSight { marker, ..sight })
                .collect()
        };
        prop::collection::vec(sight, 0..=message::MarkerFrame::MOST).prop_map(numbered)
    }

    proptest! {
        #[test]
        fn frames_come_back_bit_for_bit(
            seq in any::<u64>(),
            times in prop::array::uniform5(any::<i64>()),
            clock in any::<u32>(),
            device in prop::array::uniform32(any::<u8>()),
            sights in any_sights(),
        ) {
            let [t_device_ns, t_capture_ns, t_arrival_ns, t_publish_ns, t_uncertain_ns] = times;
            let mut frame = message::MarkerFrame {
                seq, t_device_ns, t_capture_ns, t_arrival_ns, t_publish_ns, t_uncertain_ns, clock, device,
                ..message::MarkerFrame::EMPTY
            };
            frame.set(&sights).unwrap();
            let bytes = MarkerFrame::try_from(&frame).unwrap().encode_to_vec();
            prop_assert_eq!(bits(&decode_markers(&bytes).unwrap()), bits(&frame));
        }

        #[test]
        fn hostile_bytes_are_refused_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let _ = decode_markers(&bytes);
        }
    }

    #[test]
    fn impossible_frames_are_refused_by_name() {
        let two = MarkerFrame {
            seq: 4,
            marker: vec![0, 1],
            status: vec![1; 2],
            q: vec![0.0; 8],
            t_mm: vec![0.0; 6],
            error_mm: vec![0.0; 2],
            age_ns: vec![0; 2],
            ..MarkerFrame::default()
        };
        assert!(decode_markers(&two.encode_to_vec()).is_ok());
        for (frame, words) in [
            (
                MarkerFrame {
                    status: vec![1],
                    ..two.clone()
                },
                "message 4: status has 1 values instead of 2",
            ),
            (
                MarkerFrame {
                    q: vec![0.0; 7],
                    ..two.clone()
                },
                "message 4: q has 7 values instead of 8",
            ),
            (
                MarkerFrame {
                    t_mm: vec![],
                    ..two.clone()
                },
                "message 4: t_mm has 0 values instead of 6",
            ),
            (
                MarkerFrame {
                    error_mm: vec![0.0; 3],
                    ..two.clone()
                },
                "message 4: error_mm has 3 values instead of 2",
            ),
            (
                MarkerFrame {
                    age_ns: vec![],
                    ..two.clone()
                },
                "message 4: age_ns has 0 values instead of 2",
            ),
            (
                MarkerFrame {
                    device: vec![b'a'; 33],
                    ..two.clone()
                },
                "message 4: device has 33 values instead of 32",
            ),
            (
                MarkerFrame {
                    marker: vec![1, 1],
                    ..two.clone()
                },
                "frame 4 of the localizer: marker 1 stands in it twice",
            ),
            (
                MarkerFrame {
                    marker: (0..17).collect(),
                    status: vec![1; 17],
                    q: vec![0.0; 68],
                    t_mm: vec![0.0; 51],
                    error_mm: vec![0.0; 17],
                    age_ns: vec![0; 17],
                    ..two.clone()
                },
                "frame 4 of the localizer: 17 markers; at most 16 are allowed",
            ),
        ] {
            assert_eq!(decode_markers(&frame.encode_to_vec()).unwrap_err().to_string(), words);
        }
        let hostile = message::MarkerFrame {
            count: 17,
            ..message::MarkerFrame::EMPTY
        };
        assert!(MarkerFrame::try_from(&hostile).is_err());
    }
}
