//! Words of modalities and units.

/// Modalities by DICOM's words, and those of other words for the same.
pub(super) const MODALITIES: [(&str, &str); 18] = [
    ("CT", "CT"),
    ("MR", "MR"),
    ("MRI", "MR"),
    ("DWMRI", "MR"),
    ("FMRI", "MR"),
    ("NM", "NM"),
    ("PT", "PT"),
    ("PET", "PT"),
    ("US", "US"),
    ("XA", "XA"),
    ("DX", "DX"),
    ("CR", "CR"),
    ("RF", "RF"),
    ("MG", "MG"),
    ("OT", "OT"),
    ("OTHER", "OT"),
    ("RTDOSE", "RTDOSE"),
    ("SEG", "SEG"),
];
/// MetaImage's words begin with this.
pub(super) const META: &str = "MET_MOD_";
/// Words of a text that nobody writes of a CT, in small letters.
pub(super) const NO_CT: [&str; 11] = [
    "mri",
    "fmri",
    "mprage",
    "flair",
    "t1w",
    "t2w",
    "dwi",
    "suv",
    "suvbw",
    "bqml",
    "ultrasound",
];
/// Units of length other than mm, in small letters.
pub(super) const LENGTHS: [&str; 17] = [
    "m",
    "meter",
    "meters",
    "metre",
    "metres",
    "cm",
    "centimeter",
    "centimeters",
    "centimetre",
    "centimetres",
    "um",
    "\u{b5}m",
    "micron",
    "microns",
    "nm",
    "inch",
    "inches",
];
/// Units of what is no HU, in small letters, and of RescaleType.
pub(super) const NUMBERS: [&str; 22] = [
    "bqml",
    "bq/ml",
    "kbq/ml",
    "suv",
    "suvbw",
    "g/ml",
    "mg/ml",
    "mgml",
    "mm2/s",
    "mm^2/s",
    "ms",
    "s",
    "hz",
    "ppm",
    "percent",
    "%",
    "au",
    "a.u.",
    "arbitrary",
    "counts",
    "gy",
    "cgy",
];
/// What else RescaleType may be.
pub(super) const RESCALE: [&str; 8] = ["OD", "US", "MGML", "Z_EFF", "ED", "EDW", "HU_MOD", "PCT"];
/// HU, in small letters.
pub(super) const HU: [&str; 5] = ["hu", "hounsfield", "hounsfieldunit", "hounsfieldunits", "[hnsf'u]"];
/// Ends of keys about places, in small letters.
pub(super) const PLACES: [&str; 6] = ["origin", "spacing", "direction", "directions", "offset", "matrix"];
