//! `trocar.Guide` and `trocar.Workflow`: what a person chose, without loss, and how far the run had come.

use bus::message;

use super::{DecodeError, values};
use crate::wire::schema::GUIDE_SCHEMA;

/// `trocar.Guide`: every field of [`message::Guide`], in its units (ns, mm).
#[derive(Clone, PartialEq, prost::Message)]
pub struct Guide {
    /// See [`message::Guide::t_ns`].
    #[prost(sint64, tag = "1")]
    pub t_ns: i64,
    /// See [`message::Guide::plan_id`].
    #[prost(fixed64, tag = "2")]
    pub plan_id: u64,
    /// See [`message::Guide::held_seq`].
    #[prost(uint64, tag = "3")]
    pub held_seq: u64,
    /// See [`message::Guide::held_capture_ns`].
    #[prost(sint64, tag = "4")]
    pub held_capture_ns: i64,
    /// LPS, mm, 3 values.
    #[prost(double, repeated, tag = "5")]
    pub target_mm: Vec<f64>,
    /// mm. Optional, as are other single doubles, because proto3 leaves out a plain 0 and takes -0.0 for one.
    #[prost(double, optional, tag = "6")]
    pub radius_mm: Option<f64>,
    /// LPS, mm, 3 values.
    #[prost(double, repeated, tag = "7")]
    pub entry_mm: Vec<f64>,
    /// mm.
    #[prost(double, optional, tag = "8")]
    pub stop_mm: Option<f64>,
    /// See [`message::Guide::flags`].
    #[prost(uint32, tag = "9")]
    pub flags: u32,
    /// The name's bytes without the zeros at their end.
    #[prost(bytes = "vec", tag = "10")]
    pub name: Vec<u8>,
    /// mm. A recording of before there was a choice has none of these three.
    #[prost(double, optional, tag = "11")]
    pub field_mm: Option<f64>,
    /// HU.
    #[prost(double, optional, tag = "12")]
    pub centre_hu: Option<f64>,
    /// HU.
    #[prost(double, optional, tag = "13")]
    pub width_hu: Option<f64>,
}

impl From<&message::Guide> for Guide {
    fn from(guide: &message::Guide) -> Self {
        let end = guide
            .name
            .iter()
            .rposition(|&byte| byte != 0)
            .map_or(0, |last| last + 1);
        Self {
            t_ns: guide.t_ns,
            plan_id: guide.plan_id,
            held_seq: guide.held_seq,
            held_capture_ns: guide.held_capture_ns,
            target_mm: guide.target_mm.to_vec(),
            radius_mm: Some(guide.radius_mm),
            entry_mm: guide.entry_mm.to_vec(),
            stop_mm: Some(guide.stop_mm),
            flags: guide.flags,
            name: guide.name[..end].to_vec(),
            field_mm: Some(guide.field_mm),
            centre_hu: Some(guide.centre_hu),
            width_hu: Some(guide.width_hu),
        }
    }
}

impl TryFrom<&Guide> for message::Guide {
    type Error = DecodeError;

    fn try_from(guide: &Guide) -> Result<Self, DecodeError> {
        // A guide has no number: its stamp says which.
        let seq = guide.t_ns.unsigned_abs();
        let one = |field, value: Option<f64>| values(seq, field, value.as_slice()).map(|[value]: [f64; 1]| value);
        let mut name = [0; Self::NAME];
        let room = name.get_mut(..guide.name.len()).ok_or(DecodeError::Length {
            seq,
            field: "name",
            expected: Self::NAME,
            found: guide.name.len(),
        })?;
        room.copy_from_slice(&guide.name);
        Ok(Self {
            t_ns: guide.t_ns,
            plan_id: guide.plan_id,
            held_seq: guide.held_seq,
            held_capture_ns: guide.held_capture_ns,
            target_mm: values(seq, "target_mm", &guide.target_mm)?,
            radius_mm: one("radius_mm", guide.radius_mm)?,
            entry_mm: values(seq, "entry_mm", &guide.entry_mm)?,
            stop_mm: one("stop_mm", guide.stop_mm)?,
            field_mm: guide.field_mm.unwrap_or_default(),
            centre_hu: guide.centre_hu.unwrap_or_default(),
            width_hu: guide.width_hu.unwrap_or_default(),
            flags: guide.flags,
            reserved: 0,
            name,
        })
    }
}

/// The bus message in the bytes of a recorded `trocar.Guide`.
///
/// # Errors
/// [`DecodeError`].
pub fn decode_guide(bytes: &[u8]) -> Result<message::Guide, DecodeError> {
    let guide: Guide = prost::Message::decode(bytes).map_err(|source| DecodeError::Protobuf {
        schema: GUIDE_SCHEMA,
        source,
    })?;
    (&guide).try_into()
}

/// `trocar.Workflow`: every field of [`message::Workflow`], and the stage in words.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Workflow {
    /// See [`message::Workflow::t_ns`].
    #[prost(sint64, tag = "1")]
    pub t_ns: i64,
    /// See [`message::Workflow::stage`].
    #[prost(uint32, tag = "2")]
    pub stage: u32,
    /// See [`message::Workflow::flags`].
    #[prost(uint32, tag = "3")]
    pub flags: u32,
    /// The stage as a person reads it; empty for one that is not known.
    #[prost(string, tag = "4")]
    pub stage_word: String,
}

impl From<&message::Workflow> for Workflow {
    fn from(workflow: &message::Workflow) -> Self {
        Self {
            t_ns: workflow.t_ns,
            stage: workflow.stage,
            flags: workflow.flags,
            stage_word: workflow.stage().map_or("", |stage| stage.word()).to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use prost::Message as _;

    /// Numbers as bits, so that NaNs and zeros are told apart.
    fn bits(guide: &message::Guide) -> Vec<u64> {
        let numbers = guide.target_mm.iter().chain(&guide.entry_mm);
        let mut bits: Vec<u64> = numbers
            .chain([
                &guide.radius_mm,
                &guide.stop_mm,
                &guide.field_mm,
                &guide.centre_hu,
                &guide.width_hu,
            ])
            .map(|x| x.to_bits())
            .collect();
        bits.extend([guide.t_ns.cast_unsigned(), guide.held_capture_ns.cast_unsigned()]);
        bits.extend([guide.plan_id, guide.held_seq, guide.flags.into()]);
        bits.extend(guide.name.map(u64::from));
        bits
    }

    proptest! {
        #[test]
        fn guides_come_back_bit_for_bit(
            stamps in any::<(i64, u64, u64, i64, u32)>(),
            mm in prop::array::uniform11(any::<u64>().prop_map(f64::from_bits)),
            name in prop::collection::vec(any::<u8>(), message::Guide::NAME),
        ) {
            let (t_ns, plan_id, held_seq, held_capture_ns, flags) = stamps;
            let guide = message::Guide {
                t_ns, plan_id, held_seq, held_capture_ns, flags,
                target_mm: [mm[0], mm[1], mm[2]],
                entry_mm: [mm[3], mm[4], mm[5]],
                radius_mm: mm[6],
                stop_mm: mm[7],
                field_mm: mm[8],
                centre_hu: mm[9],
                width_hu: mm[10],
                reserved: 0,
                name: name.try_into().unwrap(),
            };
            let back = decode_guide(&Guide::from(&guide).encode_to_vec()).unwrap();
            prop_assert_eq!(bits(&back), bits(&guide));
        }

        #[test]
        fn hostile_bytes_are_refused_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = decode_guide(&bytes);
        }
    }

    /// As recordings were written before images could be changed.
    #[test]
    fn a_guide_without_a_choice_of_images_is_the_scenes() {
        let old = Guide {
            field_mm: None,
            centre_hu: None,
            width_hu: None,
            ..Guide::from(&message::Guide::default())
        };
        assert_eq!(decode_guide(&old.encode_to_vec()).unwrap(), message::Guide::default());
    }

    #[test]
    fn what_is_too_long_or_too_short_is_named() {
        let good = Guide::from(&message::Guide::default());
        let long = Guide {
            name: vec![b'a'; 65],
            ..good.clone()
        };
        let said = decode_guide(&long.encode_to_vec()).unwrap_err().to_string();
        assert_eq!(said, "message 0: name has 65 values instead of 64");
        let short = Guide {
            entry_mm: vec![1.0],
            ..good.clone()
        };
        assert!(
            decode_guide(&short.encode_to_vec())
                .unwrap_err()
                .to_string()
                .contains("entry_mm")
        );
        let none = Guide { stop_mm: None, ..good };
        assert!(
            decode_guide(&none.encode_to_vec())
                .unwrap_err()
                .to_string()
                .contains("stop_mm")
        );
    }
}
