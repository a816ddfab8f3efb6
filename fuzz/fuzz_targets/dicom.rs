//! One slice of a DICOM series.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trocar_fuzz::read_as_slice(bytes));
