//! The attributes of one slice, module by module (PS3.3 A.3.3, Table A.3-1).

use dicom_core::value::{PixelFragmentSequence, Value};
use dicom_core::{DataElement, PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::InMemDicomObject;

use super::ds::{decimal_string, decimal_strings};
use super::placement::Placement;
use super::uid::Which;
use super::{Syntax, rle};

type Object = InMemDicomObject;

/// HU below that of every tissue and of air: a padding above it cannot be told from what was measured.
const LOWEST_AIR_HU: i16 = -1024;

/// What all slices of a series share.
#[derive(Debug, Clone)]
pub(super) struct Series {
    pub placement: Placement,
    /// Columns and rows.
    pub size: [u16; 2],
    pub padding_hu: i16,
    /// What every image must say; empty where there is nothing.
    pub marks: String,
    pub syntax: Syntax,
}

impl Series {
    /// Slice `k` without its voxels, as instance number `instance`.
    pub(super) fn slice(&self, k: u32, instance: u32) -> Object {
        let mut object = Object::new_empty();
        patient_and_study(&mut object);
        self.series_and_equipment(&mut object);
        self.image(&mut object, k, instance);
        self.pixels(&mut object);
        object
    }

    fn series_and_equipment(&self, object: &mut Object) {
        put(object, tags::MODALITY, VR::CS, "CT");
        put(object, tags::SERIES_INSTANCE_UID, VR::UI, &Which::Series.stand_in());
        put(object, tags::SERIES_NUMBER, VR::IS, "1");
        put(object, tags::SERIES_DESCRIPTION, VR::LO, &self.description());
        // Which part of the body this is, and so whether it is one of a pair, is not in a volume.
        put(object, tags::LATERALITY, VR::CS, "");
        // Which way round the patient lay is not in it either; its axes are the patient's own.
        put(object, tags::PATIENT_POSITION, VR::CS, "");
        let frame = Which::FrameOfReference.stand_in();
        put(object, tags::FRAME_OF_REFERENCE_UID, VR::UI, &frame);
        put(object, tags::POSITION_REFERENCE_INDICATOR, VR::LO, "");
        put(object, tags::MANUFACTURER, VR::LO, "Trocar");
        put(object, tags::SOFTWARE_VERSIONS, VR::LO, env!("CARGO_PKG_VERSION"));
    }

    fn description(&self) -> String {
        match self.marks.as_str() {
            "" => "Exported volume".to_owned(),
            marks => format!("Exported volume: {marks}"),
        }
    }

    fn image(&self, object: &mut Object, k: u32, instance: u32) {
        let place = &self.placement;
        put(object, tags::SOP_CLASS_UID, VR::UI, uids::CT_IMAGE_STORAGE);
        put(object, tags::SOP_INSTANCE_UID, VR::UI, &Which::Instance.stand_in());
        // Not the scanner's own files, whatever they were made from.
        put(object, tags::IMAGE_TYPE, VR::CS, "DERIVED\\SECONDARY\\AXIAL");
        put(object, tags::DERIVATION_DESCRIPTION, VR::ST, &self.description());
        put(object, tags::ACQUISITION_NUMBER, VR::IS, "");
        put(object, tags::KVP, VR::DS, "");
        put(object, tags::INSTANCE_NUMBER, VR::IS, &instance.to_string());
        let step = decimal_string(place.step_mm);
        put(object, tags::SLICE_THICKNESS, VR::DS, &step);
        put(object, tags::SPACING_BETWEEN_SLICES, VR::DS, &step);
        let position = decimal_strings(place.position_mm(k));
        put(object, tags::IMAGE_POSITION_PATIENT, VR::DS, &position);
        let orientation = decimal_strings(place.orientation);
        put(object, tags::IMAGE_ORIENTATION_PATIENT, VR::DS, &orientation);
        let spacing = decimal_strings(place.pixel_spacing_mm);
        put(object, tags::PIXEL_SPACING, VR::DS, &spacing);
        if let Some(degrees) = place.tilt_degrees {
            put(object, tags::GANTRY_DETECTOR_TILT, VR::DS, &decimal_string(degrees));
        }
    }

    fn pixels(&self, object: &mut Object) {
        put(object, tags::PHOTOMETRIC_INTERPRETATION, VR::CS, "MONOCHROME2");
        let [columns, rows] = self.size;
        let numbers = [
            (tags::SAMPLES_PER_PIXEL, 1),
            (tags::ROWS, rows),
            (tags::COLUMNS, columns),
            (tags::BITS_ALLOCATED, 16),
            (tags::BITS_STORED, 16),
            (tags::HIGH_BIT, 15),
            // Signed.
            (tags::PIXEL_REPRESENTATION, 1),
        ];
        for (tag, number) in numbers {
            object.put(DataElement::new(tag, VR::US, PrimitiveValue::from(number)));
        }
        if self.padding_hu < LOWEST_AIR_HU {
            let padding = PrimitiveValue::from(self.padding_hu);
            object.put(DataElement::new(tags::PIXEL_PADDING_VALUE, VR::SS, padding));
        }
        put(object, tags::RESCALE_INTERCEPT, VR::DS, "0");
        put(object, tags::RESCALE_SLOPE, VR::DS, "1");
        put(object, tags::RESCALE_TYPE, VR::LO, "HU");
        // Soft tissue, as a first view.
        put(object, tags::WINDOW_CENTER, VR::DS, "40");
        put(object, tags::WINDOW_WIDTH, VR::DS, "400");
    }

    /// The voxels of a slice as the last element of `object`; says how many bytes of the file they are at most.
    pub(super) fn put_voxels(&self, object: &mut Object, slice: &[i16]) -> usize {
        let bytes: Vec<u8> = match self.syntax {
            Syntax::ExplicitLittle | Syntax::ImplicitLittle => slice.iter().flat_map(|v| v.to_le_bytes()).collect(),
            Syntax::ExplicitBig => slice.iter().flat_map(|v| v.to_be_bytes()).collect(),
            Syntax::Rle => rle::frame(slice, usize::from(self.size[0])),
        };
        let length = bytes.len();
        object.put(match self.syntax {
            Syntax::Rle => {
                let frames = PixelFragmentSequence::new(vec![0], vec![bytes]);
                DataElement::new(tags::PIXEL_DATA, VR::OB, Value::from(frames))
            }
            _ => DataElement::new(tags::PIXEL_DATA, VR::OW, PrimitiveValue::U8(bytes.into())),
        });
        length
    }
}

/// Nothing that names a patient: Type 2 attributes are there and empty.
fn patient_and_study(object: &mut Object) {
    let empty = [
        (tags::PATIENT_NAME, VR::PN),
        (tags::PATIENT_ID, VR::LO),
        (tags::PATIENT_BIRTH_DATE, VR::DA),
        (tags::PATIENT_SEX, VR::CS),
        (tags::STUDY_DATE, VR::DA),
        (tags::STUDY_TIME, VR::TM),
        (tags::REFERRING_PHYSICIAN_NAME, VR::PN),
        (tags::STUDY_ID, VR::SH),
        (tags::ACCESSION_NUMBER, VR::SH),
    ];
    for (tag, vr) in empty {
        put(object, tag, vr, "");
    }
    put(object, tags::STUDY_INSTANCE_UID, VR::UI, &Which::Study.stand_in());
}

fn put(object: &mut Object, tag: Tag, vr: VR, text: &str) {
    let value = match text {
        "" => PrimitiveValue::Empty,
        text => PrimitiveValue::from(text),
    };
    object.put(DataElement::new(tag, vr, value));
}
