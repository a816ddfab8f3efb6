//! A file that ends in .mha.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trocar_fuzz::read_as("mha", bytes));
