//! A file that ends in .nrrd.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trocar_fuzz::read_as("nrrd", bytes));
