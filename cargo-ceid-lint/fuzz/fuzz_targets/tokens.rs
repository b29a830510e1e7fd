//! Real files, changed by their tokens: what they are changed into mostly parses, and is changed again.
#![no_main]

#[path = "../src/entry.rs"]
mod entry;
#[path = "../src/mutate.rs"]
mod mutate;

libfuzzer_sys::fuzz_target!(|data: &[u8]| entry::check(&String::from_utf8_lossy(data)));

libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let text = String::from_utf8_lossy(&data[..size]);
    let changed = mutate::mutated(&text, &text, u64::from(seed));
    // A file that is cut off does not parse, so that one which grew too long stays as it was.
    if changed.is_empty() || changed.len() > max_size {
        return size;
    }
    data[..changed.len()].copy_from_slice(changed.as_bytes());
    changed.len()
});
