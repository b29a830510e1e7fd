//! Percent-encoding (RFC 3986), for addresses of files.

use std::path::Path;

/// The `file:` address of an absolute path.
#[must_use]
pub fn file_url(path: &Path) -> String {
    let path = path.to_string_lossy();
    let path = if cfg!(windows) { format!("/{}", path.replace('\\', "/")) } else { path.into_owned() };
    let plain: &[u8] = if cfg!(windows) { b"-._~/:" } else { b"-._~/" };
    format!("file://{}", percent_encoded(&path, plain))
}

/// The text with every byte encoded but letters, digits and those of `plain`.
#[must_use]
pub fn percent_encoded(text: &str, plain: &[u8]) -> String {
    let encoded = |byte: u8| {
        if byte.is_ascii_alphanumeric() || plain.contains(&byte) {
            char::from(byte).to_string()
        } else {
            format!("%{byte:02X}")
        }
    };
    text.bytes().map(encoded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_encoded_one_by_one() {
        assert_eq!(percent_encoded("a b/ü%", b"/"), "a%20b/%C3%BC%25");
    }
}
