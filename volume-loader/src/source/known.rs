//! The formats that are read.

/// What is read, for who has something else.
pub(crate) const KNOWN: &str = "known are NIfTI (.nii, .nii.gz), NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), and a folder with a \
    DICOM series";
