//! The tokens of a real file, changed: the first eight bytes say how.
#![no_main]

#[path = "../src/entry.rs"]
mod entry;
#[path = "../src/mutate.rs"]
mod mutate;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    if let Some((seed, text)) = data.split_first_chunk() {
        let text = String::from_utf8_lossy(text);
        entry::check(&mutate::mutated(&text, &text, u64::from_le_bytes(*seed)));
    }
});
