//! Whose examination it is: what a person compares with the patient on the table.

use iceoryx2::prelude::ZeroCopySend;

use super::{VolumeHash, field_text, text_field};

/// Where an identity comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IdentitySource {
    /// Nobody says whose the examination is: the file has no place for it, or nothing stands there.
    Unknown,
    /// The examination itself.
    Examination,
    /// The scene, whatever the examination says.
    Scene,
    /// A generated patient.
    Phantom,
}

/// Every source with its code on the wire.
const CODES: [(IdentitySource, u32); 4] = [
    (IdentitySource::Unknown, 0),
    (IdentitySource::Examination, 1),
    (IdentitySource::Scene, 2),
    (IdentitySource::Phantom, 3),
];

/// Whose examination it is, in the words of the file or the scene. Published by the volume's loader with the volume. It goes into no
/// report and no recording unless the scene asks for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/Identity/1")]
pub struct Identity {
    /// The volume that it belongs to: another volume's identity is none.
    pub volume_hash: [u8; 32],
    /// The patient's name, as DICOM's PN: family name, given name and so on between `^`. Empty where it is not known.
    pub name: [u8; Identity::NAME],
    /// The patient's number in the hospital.
    pub patient_id: [u8; 64],
    /// YYYY-MM-DD.
    pub birth_date: [u8; 16],
    /// When the examination was made, YYYY-MM-DD.
    pub study_date: [u8; 16],
    /// What was examined, in the words of the department.
    pub description: [u8; 64],
    /// Code of an [`IdentitySource`].
    pub source: u32,
    /// Room for alignment; zero.
    pub reserved: u32,
}

const _: () = assert!(size_of::<Identity>() == 32 + Identity::NAME + 64 + 16 + 16 + 64 + 8);

impl Identity {
    /// Most bytes of a name: 64 characters in any script.
    pub const NAME: usize = 256;

    /// That of a volume of which nobody says whose it is.
    pub const fn unknown(volume: VolumeHash) -> Self {
        Self {
            volume_hash: volume.0,
            name: [0; Self::NAME],
            patient_id: [0; 64],
            birth_date: [0; 16],
            study_date: [0; 16],
            description: [0; 64],
            source: 0,
            reserved: 0,
        }
    }

    /// In words; what does not fit is cut off at a character's boundary. Order: name, patient's number, birth date, date of the
    /// examination, what was examined.
    pub fn new(volume: VolumeHash, source: IdentitySource, words: [&str; 5]) -> Self {
        let [name, patient_id, birth_date, study_date, description] = words;
        Self {
            volume_hash: volume.0,
            name: text_field(name),
            patient_id: text_field(patient_id),
            birth_date: text_field(birth_date),
            study_date: text_field(study_date),
            description: text_field(description),
            source: CODES
                .iter()
                .find(|(known, _)| *known == source)
                .map_or(0, |&(_, code)| code),
            reserved: 0,
        }
    }

    /// Where it comes from; an unknown code counts as unknown.
    pub fn source(&self) -> IdentitySource {
        let known = CODES.iter().find(|(_, code)| *code == self.source);
        known.map_or(IdentitySource::Unknown, |&(source, _)| source)
    }

    /// The fields in words, in the order of [`Identity::new`]; control characters, which a screen would not show, become spaces.
    pub fn words(&self) -> [String; 5] {
        let plain = |field: &[u8]| field_text(field).replace(char::is_control, " ");
        [
            plain(&self.name),
            plain(&self.patient_id),
            plain(&self.birth_date),
            plain(&self.study_date),
            plain(&self.description),
        ]
    }

    /// The volume that it belongs to.
    pub fn volume(&self) -> VolumeHash {
        VolumeHash(self.volume_hash)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_identity_comes_back_in_its_words() {
        let wide = "文".repeat(40);
        let words = [wide.as_str(), "0000001", "1950-01-01", "2026-11-20", "abdomen\n1"];
        for (source, _) in CODES {
            let identity = Identity::new(VolumeHash([7; 32]), source, words);
            assert_eq!(identity.source(), source);
            assert_eq!(identity.volume(), VolumeHash([7; 32]));
            assert_eq!(identity.words()[..4], words[..4]);
            assert_eq!(identity.words()[4], "abdomen 1");
        }
        let strange = Identity {
            source: 99,
            ..Identity::unknown(VolumeHash([0; 32]))
        };
        assert_eq!(strange.source(), IdentitySource::Unknown);
    }
}
