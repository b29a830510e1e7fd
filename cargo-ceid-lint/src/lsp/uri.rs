//! From paths to `file:` addresses and back.

use std::path::PathBuf;

pub(super) use crate::source::file_url as of_path;

/// The path that a `file:` address means; none for other schemes, as those of buffers that were never saved.
pub(super) fn to_path(uri: &str) -> Option<PathBuf> {
    let (scheme, rest) = uri.split_once(':')?;
    if !scheme.eq_ignore_ascii_case("file") {
        return None;
    }
    let (host, path) = match rest.strip_prefix("//") {
        Some(rest) => rest.split_at(rest.find('/')?),
        None => ("", rest),
    };
    let path = decoded(path)?;
    let has_host = !host.is_empty() && !host.eq_ignore_ascii_case("localhost");
    if cfg!(windows) {
        let is_drive = path.as_bytes().get(2) == Some(&b':');
        let path = if has_host { format!("//{host}{path}") } else { path[usize::from(is_drive)..].to_owned() };
        return Some(PathBuf::from(path.replace('/', "\\")));
    }
    (!has_host && path.starts_with('/')).then(|| PathBuf::from(path))
}

/// The text without percent signs that stand for bytes.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((first, behind)) = rest.split_first() {
        let code = behind.get(..2).and_then(|code| str::from_utf8(code).ok());
        let byte = code.filter(|_| *first == b'%').and_then(|code| u8::from_str_radix(code, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &behind[2..] } else { behind };
    }
    String::from_utf8(bytes).ok()
}

#[cfg(all(test, unix))]
mod tests {
    use std::path::Path;

    use super::*;

    #[track_caller]
    fn check(uri: &str, expected: Option<&str>) {
        assert_eq!(to_path(uri).as_deref(), expected.map(Path::new));
    }

    #[test]
    fn addresses_are_taken_as_clients_spell_them() {
        check("file:///a/b.rs", Some("/a/b.rs"));
        check("file:///a/%C3%A9%20%F0%9D%9B%BC.rs", Some("/a/é 𝛼.rs"));
        check("file:///a/é 100%.rs", Some("/a/é 100%.rs"));
        check("file://localhost/a", Some("/a"));
        check("FILE:/a", Some("/a"));
    }

    #[test]
    fn other_addresses_mean_no_file() {
        for uri in ["", "file:", "file://", "file://host/a", "untitled:Untitled-1", "git:/a.rs", "file:///%FF", "a"] {
            check(uri, None);
        }
    }

    #[test]
    fn paths_come_back() {
        for path in ["/a/b.rs", "/a b/é𝛼/#?%20[].rs", "/"] {
            check(&of_path(Path::new(path)), Some(path));
        }
        assert_eq!(of_path(Path::new("/a b/é")), "file:///a%20b/%C3%A9");
    }
}
