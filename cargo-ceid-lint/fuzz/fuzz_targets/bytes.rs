//! Arbitrary bytes as one file.
#![no_main]

#[path = "../src/entry.rs"]
mod entry;

libfuzzer_sys::fuzz_target!(|data: &[u8]| entry::check(&String::from_utf8_lossy(data)));
