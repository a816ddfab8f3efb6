//! `foxglove.RawImage`: an ultrasound image, without loss, as Foxglove's viewer draws it.

use bus::message::UsImageHeader;
use prost_types::Timestamp;

use super::{DecodeError, file_time, timestamp};
use crate::wire::schema::RAW_IMAGE_SCHEMA;

/// An image of the bus in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct UsFrame {
    /// What it is of.
    pub header: UsImageHeader,
    /// Its grey values, row by row from the top; as many as the header has pixels.
    pub grey: Vec<u8>,
}

/// An image as it is recorded.
#[derive(Clone, PartialEq, prost::Message)]
pub struct RawImage {
    /// Since the run's epoch: when the image was captured.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Columns.
    #[prost(fixed32, tag = "2")]
    pub width: u32,
    /// Rows.
    #[prost(fixed32, tag = "3")]
    pub height: u32,
    /// `mono8`.
    #[prost(string, tag = "4")]
    pub encoding: String,
    /// Bytes of a row.
    #[prost(fixed32, tag = "5")]
    pub step: u32,
    /// Row by row from the top.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
    /// The scanner.
    #[prost(string, tag = "7")]
    pub frame_id: String,
    /// See [`UsImageHeader::seq`].
    #[prost(uint64, tag = "100")]
    pub seq: u64,
    /// See [`UsImageHeader::t_device_ns`].
    #[prost(sint64, tag = "101")]
    pub t_device_ns: i64,
    /// See [`UsImageHeader::t_capture_ns`].
    #[prost(sint64, tag = "102")]
    pub t_capture_ns: i64,
    /// See [`UsImageHeader::t_arrival_ns`].
    #[prost(sint64, tag = "103")]
    pub t_arrival_ns: i64,
    /// See [`UsImageHeader::t_publish_ns`].
    #[prost(sint64, tag = "104")]
    pub t_publish_ns: i64,
    /// See [`UsImageHeader::pixel_mm`]: 2 values.
    #[prost(double, repeated, tag = "105")]
    pub pixel_mm: Vec<f64>,
    /// See [`UsImageHeader::depth_mm`].
    #[prost(double, tag = "106")]
    pub depth_mm: f64,
    /// See [`UsImageHeader::beams`]: 4 values.
    #[prost(double, repeated, tag = "107")]
    pub beams: Vec<f64>,
    /// See [`UsImageHeader::array`].
    #[prost(uint32, tag = "108")]
    pub array: u32,
    /// See [`UsImageHeader::clock`].
    #[prost(uint32, tag = "109")]
    pub clock: u32,
    /// See [`UsImageHeader::device`].
    #[prost(bytes = "vec", tag = "110")]
    pub device: Vec<u8>,
    /// See [`UsImageHeader::orientation`]: at most 8 bytes; nothing in recordings that are older.
    #[prost(string, tag = "111")]
    pub orientation: String,
}

const GREY: &str = "mono8";

impl From<&UsFrame> for RawImage {
    fn from(frame: &UsFrame) -> Self {
        let header = &frame.header;
        Self {
            timestamp: Some(timestamp(file_time(header.t_capture_ns))),
            width: header.width,
            height: header.height,
            encoding: GREY.to_owned(),
            step: header.width,
            data: frame.grey.clone(),
            frame_id: header.device_name(),
            seq: header.seq,
            t_device_ns: header.t_device_ns,
            t_capture_ns: header.t_capture_ns,
            t_arrival_ns: header.t_arrival_ns,
            t_publish_ns: header.t_publish_ns,
            pixel_mm: header.pixel_mm.to_vec(),
            depth_mm: header.depth_mm,
            beams: header.beams.to_vec(),
            array: header.array,
            clock: header.clock,
            device: header.device.to_vec(),
            orientation: header.orientation().unwrap_or_default(),
        }
    }
}

impl TryFrom<RawImage> for UsFrame {
    type Error = DecodeError;

    fn try_from(image: RawImage) -> Result<Self, DecodeError> {
        let seq = image.seq;
        let length = |field, expected, found| match expected == found {
            true => Ok(()),
            false => Err(DecodeError::Length {
                seq,
                field,
                expected,
                found,
            }),
        };
        // A side has 32 bits, and so has a usize at least.
        let pixels = (image.width as usize).saturating_mul(image.height as usize);
        length("data", pixels, image.data.len())?;
        length("pixel_mm", 2, image.pixel_mm.len())?;
        length("beams", 4, image.beams.len())?;
        length("device", 32, image.device.len())?;
        let turned = image.orientation.len();
        length("orientation", turned.min(8), turned)?;
        let header = UsImageHeader {
            seq,
            t_device_ns: image.t_device_ns,
            t_capture_ns: image.t_capture_ns,
            t_arrival_ns: image.t_arrival_ns,
            t_publish_ns: image.t_publish_ns,
            pixel_mm: std::array::from_fn(|i| image.pixel_mm[i]),
            depth_mm: image.depth_mm,
            beams: std::array::from_fn(|i| image.beams[i]),
            array: image.array,
            clock: image.clock,
            width: image.width,
            height: image.height,
            device: std::array::from_fn(|i| image.device[i]),
            ..UsImageHeader::default()
        }
        .turned(&image.orientation);
        Ok(Self {
            header,
            grey: image.data,
        })
    }
}

/// The image in the bytes of a recorded `foxglove.RawImage`.
///
/// # Errors
/// [`DecodeError`], also for an image of another program.
pub fn decode_us_image(bytes: &[u8]) -> Result<UsFrame, DecodeError> {
    let image: RawImage = prost::Message::decode(bytes).map_err(|source| DecodeError::Protobuf {
        schema: RAW_IMAGE_SCHEMA,
        source,
    })?;
    image.try_into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost::Message as _;

    fn frame() -> UsFrame {
        let header = UsImageHeader {
            seq: u64::MAX,
            t_device_ns: -1,
            t_capture_ns: i64::MIN,
            t_arrival_ns: 3,
            t_publish_ns: i64::MAX,
            pixel_mm: [0.1, f64::MIN_POSITIVE],
            depth_mm: 45.5,
            beams: [1.0, -0.0, 3.5, 0.25],
            array: 2,
            clock: 1,
            width: 3,
            height: 2,
            ..UsImageHeader::default()
        };
        UsFrame {
            header: header.with_device("Ultrasonix").turned("MFA"),
            grey: vec![0, 1, 127, 128, 254, 255],
        }
    }

    #[test]
    fn images_come_back_bit_for_bit() {
        let frame = frame();
        let back = decode_us_image(&RawImage::from(&frame).encode_to_vec()).unwrap();
        assert_eq!(back, frame);
        assert_eq!(
            back.header.beams.map(f64::to_bits),
            frame.header.beams.map(f64::to_bits)
        );
    }

    #[test]
    fn what_is_no_image_is_refused_with_its_field() {
        let good = RawImage::from(&frame());
        let words = |image: RawImage| decode_us_image(&image.encode_to_vec()).unwrap_err().to_string();
        let cut = RawImage {
            data: vec![1; 5],
            ..good.clone()
        };
        assert!(words(cut).contains("data"));
        let huge = RawImage {
            width: u32::MAX,
            height: u32::MAX,
            ..good.clone()
        };
        assert!(words(huge).contains("data"));
        let turned = RawImage {
            orientation: "MFMFMFMFM".to_owned(),
            ..good.clone()
        };
        assert!(words(turned).contains("orientation"));
        let other = RawImage {
            pixel_mm: Vec::new(),
            ..good
        };
        assert!(words(other).contains("pixel_mm"));
        assert!(decode_us_image(&[0xff; 7]).is_err());
    }
}
